#pragma once

#include <cstdint>
#include <vector>

#include "mechanics/internal_forces.h"
#include "model/model.h"
#include "model/state.h"
#include "step/node_passes.h"

namespace palpate {

/// No point turns inside out: what is prevented need not be watched. A point that is squeezed below watched_J, or whose
/// nodes go far in a step for how flat it is, keeps in one step at least half of its volume, and `least_J` of it at any
/// rate:
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

  /// A node goes far for a point: |du_i| |gradN_i| |F^-1| in a step, gradN_i where it is largest. A screen before the
  /// exact test, which costs two gradients a point. Least J of 15,000 rough ticks (liver, two fingers): without the
  /// test -0.44 and -0.20, from 1 on 0.015 and -0.007, from 0.5 on 0.020 both; 0.25 brings no more.
  static constexpr double far = 0.5;

  explicit CompressionLimit(const Model& model);

  /// Corrects du. @param kernel  its points' J and |cof F|^2 at u; `forces` bounds them
  /// Real-time: no allocation, no lock, no throw; costs a comparison for each node where nothing is squeezed. The team
  /// looks for the points in fixed parts. Test: simulation/limit_compression_test.cpp
  void apply(const Model& model, const KernelScratch& kernel, const ForceReport& forces, const StepMasses& masses,
             State& state, SpinTeam& team);

 private:
  struct Point {
    Mat3 F = Mat3::Identity();
    double allowed = 0;  // of J at the step's end
    int row = 0;         // of Model::point_shape
  };
  float findWays(const AlignedVector<Float4>& du);
  bool isWatched(const Model& model, const KernelScratch& kernel, std::size_t place, double furthest,
                 const State& state) const;

  std::vector<float> steepest2_;       // (node_count) 1/m^2, largest |gradN_i|^2
  std::vector<float> way2_;            // (node_count) |du_i|^2 |gradN_i|^2 of this step
  std::vector<std::uint8_t> watched_;  // (place_count of the kernel)
  std::vector<Point> squeezed_;        // (capacity)
};

}  // namespace palpate
