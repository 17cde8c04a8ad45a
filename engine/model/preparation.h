#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "approximation/shape_table.h"
#include "contact/skin.h"
#include "discretization/nodes/nested_cloud.h"
#include "mechanics/critical_time_step.h"
#include "mechanics/essential_nodes.h"
#include "mechanics/materials/material.h"
#include "scene/scene.h"

namespace palpate {

/// Of the volume of a material, where the cells see little of that: what they take for another.
struct MissedShare {
  int body = 0, material = 0, other = 0, unused = 0;  // indices into the scene's materials
  double share = 0;
};

/// The part of a Model that takes long to make, and follows from the organ, the discretization, the materials and the
/// boundaries alone: what a cache keeps. buildModel adds the rest in a moment.
struct Preparation {
  // Computed by makeNodeCloud (in slices along the organ) and the lumped masses.
  std::vector<Vec3> X;                 // (node_count) m
  std::vector<double> support_radius;  // (node_count) m
  std::vector<double> mass;            // (node_count) kg, with what scene.dynamics.mass_scaling adds
  std::vector<double> own_mass;        // (node_count) kg, of the tissue

  // Computed by makeBackgroundCells and makeIntegrationPoints.
  std::vector<std::array<int, 4>> cells;  // (cell_count)
  std::vector<Vec3> point_X;              // (point_count) m
  std::vector<double> point_volume;       // (point_count) m^3
  std::vector<int> point_material;        // (point_count) index into the scene's materials
  std::vector<int> point_cell;            // (point_count) the cell that the point stands for
  std::vector<int> point_other_cell;      // (point_count) a second one that it stands for, or -1; empty: each has one
  // Vertices at which the volume is held: the nodes, and at borders between materials one more of a node for each
  // further side (sharp_interfaces.h). Empty where there is no border.
  std::vector<int> side_node;                    // (side_count) node of vertex node_count + k
  std::vector<std::uint64_t> vertex_group;       // (node_count + side_count) a bit for each group of cells (GroupBits)
  std::vector<std::array<int, 4>> volume_cells;  // (cell_count) as `cells`, by vertices
  double surface_volume = 0;                     // m^3, of the organ's own surface
  double cell_volume = 0;                        // m^3, of the background cells

  // Bodies that are not joined to one another stand one after another (join_bodies.h).
  std::vector<int> end_node, end_point;  // (body_count)

  // Of the cells' materials (thin_layers.h): one of which they see little, the error that forces have for it, and what
  // that follows from. With other materials than those loaded: layerError().
  int thin_layer = -1;  // index into the scene's materials; -1: none
  double layer_error = 0;
  std::vector<MissedShare> missed_shares;  // by body and material

  // Computed by shapeFunctions (MMLS).
  ShapeTable point_shape;  // N, gradN at the integration points
  ShapeTable node_shape;   // N at the nodes' own positions

  // Kept are skin.surface, refined for contact, with its rows of N, and essential's nodes and facets with facet_weight
  // and facet_phi; what else these two hold follows from that and the scene, and comes from buildModel.
  SkinModel skin;
  EssentialNodes essential;  // what is imposed where

  CriticalTimeStep limit;  // of the operator at rest

  // Of the first place of a cloud that follows the tool (place.h), for all others; else empty.
  NestedCloud cloud;
  double pair_moment = 0;

  int nodeCount() const { return static_cast<int>(X.size()); }
  double addedMass() const;  // as a share of the tissue's own
  int pointCount() const { return static_cast<int>(point_X.size()); }
  int bodyCount() const { return static_cast<int>(end_node.size()); }
  int bodyOfNode(int node) const;
  int bodyOfPoint(int point) const;
};

/// What the nodes have, and after it what those of side_node have.
template <class T>
std::vector<T> verticesOf(std::vector<T> of_nodes, const std::vector<int>& side_node) {
  of_nodes.reserve(of_nodes.size() + side_node.size());
  for (const int i : side_node) of_nodes.push_back(of_nodes[static_cast<std::size_t>(i)]);
  return of_nodes;
}

/// N at the vertices of volume_cells: with the nodes' rows those of a border's further sides, which go with their node.
ShapeTable vertexShape(const ShapeTable& node_shape, const std::vector<int>& side_node);

/// Preparation::layer_error with these materials: where cells miss much of a layer it counts as far as that is softer
/// or stiffer than what they take it for. Of mixed tissue as loaded.
/// Real-time: no allocation, no lock, no throw.
double layerError(const Preparation& preparation, std::span<const Material> materials);

/// Whether all sizes agree, all indices are in range, and all numbers are finite (masses, radii and the step
/// positive): what the rest of the set-up relies on, and what a file that was kept must be held to.
/// Test: io/model_cache_test.cpp
bool isSound(const Preparation& preparation, std::size_t material_count, std::size_t boundary_count);

/// All that a preparation depends on, as bytes: the organ's surface and scene.set_up_values. Equal bytes, equal
/// preparation (by the same program), where set_up_values is not empty.
std::string preparationKey(const Scene& scene, const TriangleSurface& organ);

}  // namespace palpate
