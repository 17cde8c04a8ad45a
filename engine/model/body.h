#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/types.h"
#include "contact/skin_contact.h"
#include "contact/tool_set.h"
#include "discretization/surface/surface_gaps.h"
#include "mechanics/materials/material.h"
#include "model/preparation.h"
#include "scene/scene.h"

namespace palpate {

/// What a scene is, without what only the solver reads: all that a viewer needs.
struct Body : Preparation {
  Scene scene;
  std::vector<std::uint8_t> imposed;  // (node_count) bit c set: component c is imposed
  std::vector<Material> materials;    // as loaded; those in force are in State

  std::vector<std::shared_ptr<const SurfaceGaps>> gaps;  // (body_count) in each one's skin, at which supports end

  SkinBodies bodies;            // that touch one another; empty: there is one
  std::vector<int> node_organ;  // (node_count) of the scene's organs (Scene::organs); empty: there is one

  ToolSet tools;

  // Time. tick = substeps_per_tick * dt = 1 / scene.dynamics.rate_hz.
  double dt = 0;           // s
  double dt_critical = 0;  // s, of the operator at rest (Lanczos)
  double dt_proven = 0;    // s, Gershgorin bound: stable at rest for certain
  int substeps_per_tick = 1;
  double setup_seconds = 0;
};

}  // namespace palpate
