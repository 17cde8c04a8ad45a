#pragma once

#include <cstdint>
#include <vector>

#include "mechanics/internal_forces.h"
#include "simulation/model.h"
#include "simulation/node_passes.h"
#include "simulation/state.h"

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

  /// A node goes far: |du_i| |gradN_i| in a step, at the point where that is largest. Half of a point's volume takes
  /// several such nodes at rest; where |F^-1|^2 is above 12 (3 at rest) less of them, above 100 any.
  static constexpr double far = 0.15, far_where_flat = 0.05;
  static constexpr float flat = 12, very_flat = 100;

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
  int findFar(const AlignedVector<Float4>& du);
  bool isWatched(const Model& model, const KernelScratch& kernel, std::size_t place, int furthest,
                 const State& state) const;

  std::vector<float> far2_;            // (node_count) m^2, of |du|^2
  std::vector<std::uint8_t> goes_;     // (node_count) in this step: 1: far where the tissue is flat, 2: far
  std::vector<std::uint8_t> watched_;  // (place_count of the kernel)
  std::vector<Point> squeezed_;        // (capacity)
};

}  // namespace palpate
