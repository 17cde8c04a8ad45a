#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "approximation/shape_table.h"
#include "base/types.h"
#include "contact/contact.h"
#include "mechanics/essential_boundary.h"
#include "mechanics/kernel_layout.h"
#include "mechanics/materials/material.h"
#include "simulation/scene.h"

namespace palpate {

/// A scene made ready to run. Never changes during a run (what is set live is in State), so simulations may share one.
struct Model {
  Scene scene;

  // Computed by makeNodeCloud (reordered along a space-filling curve) and the boundaries' regions.
  std::vector<Vec3> X;                 // (node_count) m
  std::vector<double> support_radius;  // (node_count) m
  std::vector<std::uint8_t> imposed;   // (node_count) bit c set: component c is imposed

  // Computed by makeBackgroundCells and makeIntegrationPoints.
  std::vector<std::array<int, 4>> cells;  // (cell_count)
  std::vector<Vec3> point_X;              // (point_count) m
  std::vector<double> point_volume;       // (point_count) m^3
  std::vector<int> point_material;        // (point_count) index into materials
  double surface_volume = 0;              // m^3, of the organ's own surface
  double cell_volume = 0;                 // m^3, of the background cells

  // Computed by shapeFunctions (MMLS).
  ShapeTable point_shape;             // N, gradN at the integration points
  ShapeTable node_shape;              // N at the nodes' own positions
  std::vector<int> point_cell;        // (point_count) the cell that the point stands for
  std::vector<int> point_other_cell;  // (point_count) a second one that it stands for, or -1; empty: each has one

  // Computed from the materials and the cells.
  std::vector<Material> materials;    // as loaded; those in force are in State
  std::vector<double> mass;           // (node_count) kg
  AlignedVector<float> inverse_mass;  // (node_count) 1/kg

  NodePatches patches;       // empty without scene.node_patch_volume
  KernelLayout kernel;       // what the hot kernel reads
  EssentialNodes essential;  // what is imposed where; with the masses it makes `boundary`
  EssentialBoundary boundary;

  // Skin and tool.
  SkinModel skin;
  ShapeTable skin_shape;  // N at the skin's vertices (double, for set-up and drawing)
  Pose tool_start;
  double first_contact_travel = 0;  // m the tool goes along its axis before it first touches the skin

  // Time. tick = substeps_per_tick * dt = 1 / scene.rate_hz.
  double dt = 0;           // s
  double dt_critical = 0;  // s, of the operator at rest (Lanczos)
  double dt_proven = 0;    // s, Gershgorin bound: stable at rest for certain
  int substeps_per_tick = 1;
  double added_mass = 0;     // share of the body's own mass that was added to spare steps (mass_scaling.h)
  double rest_energy = 0;    // J, strain energy below which is rounding
  double max_increment = 0;  // m a node may move in one step; more is a blow-up
  double setup_seconds = 0;

  int nodeCount() const { return static_cast<int>(X.size()); }
  int pointCount() const { return static_cast<int>(point_X.size()); }
};

}  // namespace palpate
