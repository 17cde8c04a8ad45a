#pragma once

#include <algorithm>
#include <array>

#include "base/types.h"
#include "mechanics/boundary_shifts.h"

namespace palpate {

/// What some vertices of the skin have, in their order. Equal ones have equal bytes.
struct VertexValues {
  static constexpr int capacity = 64;
  int count = 0;
  std::array<int, capacity> vertex{};  // ascending
  std::array<Float4, capacity> value{};

  bool operator==(const VertexValues& other) const;
  /// @return false where there are `capacity` others
  bool put(int at, const Vec3& of);
  void drop(int at);
  bool has(int at) const { return std::binary_search(vertex.begin(), vertex.begin() + count, at); }
  Vec3 at(int skin_vertex) const;  // 0 where there is none
};

/// What is beside the scene's own gravity and boundaries: set live, and part of State. Equal loads have equal bytes.
struct LiveLoads {
  Vec3 gravity = Vec3::Zero();  // m/s^2, more than the scene's
  VertexValues forces;          // N, on the tissue there
  VertexValues pins;            // m, where the vertex is held
  BoundaryShifts region_shift;  // that are wanted, beside the scene's own motions

  bool operator==(const LiveLoads& other) const = default;
  bool any() const;

  /// The force at a vertex of the skin from now on, N; 0: none.
  /// @return false where there are VertexValues::capacity others
  bool setForce(int at, const Vec3& newtons);
};

}  // namespace palpate
