#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "model/preparation.h"

namespace palpate {

/// The integration points around each node, a group for each material there: expected_error.h fits what they see by a
/// linear function, by least squares over their volumes, whose value at the node is sum_q weight_q v_q. Along
/// directions in which a group's points don't differ it is constant.
struct PointGroups {
  static constexpr double of_cell = 1.0 / 20;

  int count = 0;
  std::vector<std::array<int, 4>> of_point;    // (point_count) groups at the nodes of its cell,
  std::vector<std::array<float, 4>> share;     // (point_count) its share of each group's volume,
  std::vector<std::array<float, 4>> weight;    // (point_count) its weight in the group's fit,
  std::vector<std::array<float, 4>> position;  // (point_count) and where it is between them: barycentric coordinates
  // (point_count) The mean square, over what a point stands for, of what it does not see of a linear function with the
  // values v_k at its cell's nodes is unseen sum_k (v_k - v)^2, v their mean: of_cell for a cell; more for the point
  // that stands for two, the second taken for regular; 0 for one of several, as they see it.
  std::vector<float> unseen;
  // (point_count) 1: its cell has a node at which what is held ends amid smooth skin, or is thin: stress has no bound.
  std::vector<std::uint8_t> at_edge;
};
/// @param base  (material_count) of each material the one whose group it belongs to, as mixtures do to their first;
/// empty: each to its own
/// Test: simulation/resolution_test.cpp
PointGroups makePointGroups(const Preparation& preparation, const std::vector<int>& base = {});

}  // namespace palpate
