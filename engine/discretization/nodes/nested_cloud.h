#pragma once

#include <cstdint>
#include <vector>

#include "base/types.h"
#include "discretization/nodes/node_cloud.h"
#include "discretization/nodes/spacing_field.h"
#include "discretization/surface/feature_edges.h"
#include "discretization/surface/surface_tree.h"

namespace palpate {

/// One fine cloud that holds coarser ones. In farthest-point order (Gonzalez 1985; Eldar et al. 1997) each node has an
/// insertion radius, its distance from the nodes that come before it, and the nodes with a radius of at least r are a
/// cloud whose closest pair is r apart and which leaves no gap wider than r. So a coarse node is a node of all finer
/// clouds, and what is live far from a tool does not depend on where the tool is.
///
/// The order is kept by dimension, as makeNodeCloud places nodes: corners, sharp edges, faces, the inside. A node's
/// radius counts nodes of its own dimension and below, and is at most its distance from the (finest) nodes of lower
/// dimension over min_depth_share: a coarse cloud keeps corners and edges, and has no inner node hard below its faces,
/// where cells would be flat.
struct NestedCloud {
  std::vector<Vec3> X;                   // (node_count) m
  std::vector<std::uint8_t> on_surface;  // (node_count) 1 on the body's surface
  std::vector<double> coarsest;          // (node_count) m, the widest spacing for which it is live; infinity: any

  int nodeCount() const { return static_cast<int>(X.size()); }
};

/// Of a node's insertion radius: its least distance from nodes of lower dimension. Larger: fewer flat cells, but gaps
/// below the surface.
inline constexpr double min_depth_share = 0.85;

/// The spacing of the live cloud of insertion radius r in a cloud of spacing `finest` (both m): mean cell edges as in a
/// cloud that is made for it. A cloud that is well spread holds no other that is not at least some 1.3 times as wide,
/// so between these r counts for less; beyond, r is 0.7 of the spacing.
double spacingOfRadius(double r, double finest);

/// The dimension of what each node lies on (node_count): 0 a corner, 1 a sharp edge, 2 a face, 3 the inside.
/// Nodes count as on an edge within 0.2 spacings of it: fitToVolume moves them less than that.
std::vector<std::uint8_t> nodeDimensions(const NodeCloud& cloud, const FeatureEdges& features,
                                         const SpacingField& spacing);

/// @param dimension  (node_count) 0 .. 3; a border between materials counts as a sheet (2), on the surface as an edge,
///                   where it meets a sharp edge as a corner
/// @param finest     the cloud's own spacing: where that (or less) is wanted all nodes are live
/// @param pairs      as pairsAcrossAir gives them, of which both are live or neither where the wanted spacing is
///                   even; empty: none
/// Ties go to the lower number; equal bits at each call. Cost ~ n log n with some hundred neighbours a node.
/// Test: discretization/nodes/nested_cloud_test.cpp
NestedCloud nestedOrder(const NodeCloud& cloud, std::vector<std::uint8_t> dimension, const SpacingField& finest,
                        const std::vector<int>& pairs = {});

/// The node straight across the air, where that is no wider than `widest`, m, or -1 (node_count): makeNodeCloud puts
/// such pairs.
std::vector<int> pairsAcrossAir(const NodeCloud& cloud, const SurfaceTree& surface, double widest);

/// Makes some nodes live everywhere: of `members` the `count` that come first in farthest-point order.
void keepLive(const std::vector<int>& members, int count, NestedCloud& cloud);

/// The nodes that are live where `wanted` asks for its spacing: coarsest >= wanted.at(X). Ascending.
std::vector<int> liveNodes(const NestedCloud& cloud, const SpacingField& wanted);

}  // namespace palpate
