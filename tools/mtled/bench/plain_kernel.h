#pragma once

#include <cstdint>
#include <vector>

#include "approximation/shape_table.h"
#include "base/spin_team.h"
#include "base/types.h"
#include "mechanics/materials/material.h"

namespace palpate::tools {

/// The internal forces as one would write them with care but without vector registers in mind: fixed-size Eigen
/// types, double, flat arrays, one point after another. What the block kernel's speed is measured against.
///
///   F = I + sum_i u_i (x) gradN_i,  P = mu J^(-2/3) (F - I1/3 F^-T) + K (J - 1) J F^-T,  f_i -= V P gradN_i
///
/// Points come in the block kernel's order, so that this one's caches are as warm. Threads take equal parts of the
/// points and a force array each, which are added up at the end.
/// Test: tools/bench_command_test.cpp (equals referenceInternalForces)
class PlainKernel {
 public:
  /// @param order     points in the order of work; entries below 0 are skipped   (any length)
  /// @param shape     with gradients, one row per point
  /// @param volume    m^3 (point_count)
  /// @param material  neo-Hookean without barrier, of all points; another throws std::invalid_argument
  PlainKernel(const std::vector<int>& order, const ShapeTable& shape, const std::vector<double>& volume,
              const Material& material);

  /// @param u  m (node_count)
  /// @param f  N (node_count), overwritten
  void forces(const std::vector<Vec3>& u, std::vector<Vec3>& f, SpinTeam& team);

  /// Read in one evaluation: gradients, nodes, row ends and volumes.
  double streamedBytes() const;

 private:
  void pointForces(int begin, int end, const Vec3* u, Vec3* f) const;

  std::vector<std::int32_t> begin_{0};      // (point_count + 1)
  std::vector<std::int32_t> node_;          // (entry_count)
  std::vector<Vec3> gradN_;                 // (entry_count) 1/m
  std::vector<double> volume_;              // (point_count) m^3
  double mu_ = 0, K_ = 0;                   // Pa
  std::vector<std::vector<Vec3>> partial_;  // (team size - 1)(node_count); member 0 writes into f itself
};

}  // namespace palpate::tools
