#pragma once

#include <array>
#include <vector>

#include "approximation/shape_table.h"
#include "base/types.h"
#include "mechanics/load_curve.h"

namespace palpate {

/// A node, or a point between the nodes, where displacement is imposed, and which boundary imposes each component.
struct ImposedNode {
  static constexpr int point = -1;
  int node = 0;                             // or `point`: its place and row stand in EssentialNodes
  std::array<int, 3> boundary{-1, -1, -1};  // index into EssentialNodes::motions; -1: the component is free
};

/// How one boundary moves: a rotation, then a translation, both scaled by the load curve.
struct BoundaryMotion {
  Vec3 translation = Vec3::Zero();  // m
  Vec3 axis_point = Vec3::Zero();   // m, a point of the axis of rotation; the resultant moment is about it
  Vec3 axis = Vec3::UnitZ();        // unit
  double angle = 0;                 // rad, right-handed about axis
  double duration = 0;              // s
  LoadCurve curve;

  bool moves() const { return angle != 0 || !translation.isZero(0); }
  /// Displacement at `time_s` of the point that is at X at rest, m.
  Vec3 at(const Vec3& X, double time_s) const;
};

/// All data of the essential boundary except the masses: the paper's Phi and V follow from it.
struct EssentialNodes {
  std::vector<ImposedNode> nodes;       // (row_count)
  std::vector<Vec3> X;                  // (row_count) m
  ShapeTable phi;                       // Phi_kj = N_j(X_k), one row per imposed node
  std::vector<BoundaryMotion> motions;  // (boundary_count)

  // EBCIEM only (empty: SEBCIEM): the cells' outer faces, each with `facet_points` quadrature points.
  std::vector<std::array<int, 3>> facets;  // nodes
  int facet_points = 0;
  ShapeTable facet_phi;            // N_j at the points, facet by facet
  std::vector<Vec3> facet_weight;  // (facet_count * facet_points) m^2 times the three corners' linear
                                   // shape functions: w_i N^k(s_i) of paper eq. 17
};

}  // namespace palpate
