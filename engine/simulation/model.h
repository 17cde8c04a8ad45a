#pragma once

#include <cstdint>
#include <vector>

#include "base/types.h"
#include "contact/contact.h"
#include "mechanics/essential_boundary.h"
#include "mechanics/kernel_layout.h"
#include "mechanics/materials/material.h"
#include "simulation/preparation.h"
#include "simulation/scene.h"

namespace palpate {

/// A scene made ready to run. Never changes during a run (what is set live is in State), so simulations may share one.
struct Model : Preparation {
  Scene scene;
  std::vector<std::uint8_t> imposed;  // (node_count) bit c set: component c is imposed

  // Computed from the materials and the cells.
  std::vector<Material> materials;    // as loaded; those in force are in State
  AlignedVector<float> inverse_mass;  // (node_count) 1/kg

  NodePatches patches;         // empty without scene.node_patch_volume
  KernelLayout kernel;         // what the hot kernel reads
  EssentialBoundary boundary;  // of `essential` and the masses

  Pose tool_start;
  double first_contact_travel = 0;  // m the tool goes along its axis before it first touches the skin

  // Time. tick = substeps_per_tick * dt = 1 / scene.rate_hz.
  double dt = 0;           // s
  double dt_critical = 0;  // s, of the operator at rest (Lanczos)
  double dt_proven = 0;    // s, Gershgorin bound: stable at rest for certain
  int substeps_per_tick = 1;
  double rest_energy = 0;    // J, strain energy below which is rounding
  double max_increment = 0;  // m a node may move in one step; more is a blow-up
  double setup_seconds = 0;
};

}  // namespace palpate
