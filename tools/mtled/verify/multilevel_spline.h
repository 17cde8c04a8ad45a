#pragma once

#include <array>
#include <vector>

#include "discretization/surface/surface_geometry.h"

namespace palpate::tools {

/// Scattered data as a sum of cubic B-splines on finer and finer lattices (Lee, Wolberg and Shin 1997, "Scattered data
/// interpolation with multilevel B-splines", their algorithms BA and MBA in space): what image programs make a
/// transform of moved points by. Each level takes on what those before left:
///   phi_c = sum_p w_cp^2 phi_cp / sum_p w_cp^2,   phi_cp = w_cp z_p / sum_d w_dp^2
/// with w_cp the product of three cubic B-splines of control point c at point p, and z_p its residual.
/// Beside our own field, for comparison (mtled verify brain_shift). Test: tools/multilevel_spline_test.cpp
class MultilevelSpline {
 public:
  /// @param box     that the spline is defined on; evaluated beyond it, it is that of its nearest place
  /// @param finest  m, so fine the last lattice is at least; each has half the cells' edges of the one before
  MultilevelSpline(const std::vector<Vec3>& X, const std::vector<Vec3>& value, const Box3& box, double finest);

  Vec3 at(const Vec3& X) const;
  int levelCount() const { return static_cast<int>(levels_.size()); }

 private:
  struct Level {
    Vec3 origin = Vec3::Zero();  // m, where the cells begin
    double edge = 1;             // m, of a cell
    std::array<int, 3> cells{};
    std::vector<Vec3> phi;  // (cells + 3 along each axis)

    /// Calls each(control point, weight) for the 64 around X.
    template <class Each>
    void around(const Vec3& X, Each each) const;
    void fit(const std::vector<Vec3>& X, const std::vector<Vec3>& value);
    Vec3 at(const Vec3& X) const;
  };
  std::vector<Level> levels_;
};

}  // namespace palpate::tools
