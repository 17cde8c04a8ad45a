#pragma once

#include <vector>

#include "simulation/model.h"
#include "simulation/node_passes.h"
#include "simulation/state.h"

namespace palpate {

/// No point turns inside out: what is prevented need not be watched. A point that is squeezed below watched_J keeps, in
/// one step, at least half of its volume, and `least_J` of it at any rate:
///
///   J(u + du) >= max(J(u) / 2, least_J)         (not less than J(u), where that is below least_J already)
///
/// Each point that would not gets an impulse along its own dJ/du, as a contact would give it: it moves no centre of
/// mass, and takes energy only. Points are gone over one after the other, forwards and backwards, some times.
/// A step halves J at most since the masses follow the stiffness, which goes with 1 / J, a step behind
/// (follow_stiffness.h); what is stiffer than that is unstable and was what blew up under a rough hand.
class CompressionLimit {
 public:
  static constexpr float watched_J = 0.2F;  // Formulation::floor_J0, from which on the energy has a floor
  static constexpr double least_J = 0.02;   // Material::min_isochoric_J, below which the energy is a tangent

  explicit CompressionLimit(const Model& model);

  /// Corrects du. @param J  of the kernel's points at u (KernelScratch::J)
  /// @param least  of them
  /// Real-time: no allocation, no lock, no throw; serial; costs a comparison where nothing is squeezed.
  /// Test: simulation/limit_compression_test.cpp
  void apply(const Model& model, const AlignedVector<float>& J, float least, const StepMasses& masses, State& state);

 private:
  struct Point {
    Mat3 F = Mat3::Identity();
    double allowed = 0;  // of J at the step's end
    int row = 0;         // of Model::point_shape
  };
  std::vector<Point> squeezed_;  // (capacity)
};

}  // namespace palpate
