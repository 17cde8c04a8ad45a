#pragma once

#include <vector>

#include "mechanics/materials/material.h"

namespace palpate::tools {

// Bodies of parts that are each strained evenly: closed forms but for the root of some numbers.

struct Layer {
  double height = 0;  // m
  Material material;
};

/// Layers across z, between a plane that is held and one that is moved, with sides that go where their layer goes:
///   F_k = 1 + c_k (x) e_z,  P_k e_z the same in all layers,  sum_k h_k c_k = motion
struct Laminate {
  std::vector<Layer> layers;  // from z = 0 up
  std::vector<Vec3> c;        // (layer_count)
  Vec3 traction;              // P e_z, Pa

  /// @param motion  of the upper plane, m
  Laminate(std::vector<Layer> from, const Vec3& motion);

  /// Where a point goes, m.
  Vec3 moved(const Vec3& X) const;
};

/// Stretches of tissue between plates: `along` z it is driven, across it x is free, and y free or held. With fibres
/// along an axis, or none.
/// @return P_zz, Pa
double stressBetweenPlates(const Material& material, double along, bool y_held);

}  // namespace palpate::tools
