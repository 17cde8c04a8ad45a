#pragma once

#include <vector>

#include "base/input_error.h"
#include "base/types.h"

namespace palpate {

/// The distance wanted between neighbouring nodes, m, as a function of place: one spacing
/// everywhere, finer inside some spheres, growing linearly around each.
struct SpacingField {
  struct Refinement {
    Vec3 centre = Vec3::Zero();  // m
    double radius = 0;           // m, >= 0
    double spacing = 0;          // m, inside the sphere
    double blend = 0;            // m, width of the zone of transition to `spacing` below; 0: 3 x the difference
    SourceLocation place;        // where the scene asks for it
  };

  double spacing = 0;  // m
  std::vector<Refinement> refinements;
  SourceLocation place;  // where the scene asks for it

  /// The steepest growth of the spacing, m per m. If it grew faster, neighbouring cells would differ by more than
  /// 1.5 times in size, which costs accuracy; a blend that is too narrow for this growth is widened.
  static constexpr double steepest_growth = 0.5;

  /// Spacing at x, m. Lipschitz with constant steepest_growth.
  double at(const Vec3& x) const;

  /// The smallest and the largest value anywhere, m.
  double smallest() const;
  double largest() const { return spacing; }

  /// Throws InputError (place, problem, advice) where a length is not finite and positive, or a
  /// refinement is coarser than the global spacing.
  void check() const;
};

}  // namespace palpate
