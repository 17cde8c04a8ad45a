#pragma once

#include <array>

#include "base/types.h"

namespace palpate {

struct Model;
struct State;
struct StepMasses;

/// What is beside the scene's own gravity: set live, and part of State. Equal loads have equal bytes.
struct LiveLoads {
  static constexpr int max_forces = 64;
  Vec3 gravity = Vec3::Zero();             // m/s^2, more than the scene's
  int count = 0;                           // forces
  std::array<int, max_forces> vertex{};    // of the skin, ascending
  std::array<Float4, max_forces> force{};  // N, on the tissue there

  bool operator==(const LiveLoads& other) const;
  bool any() const { return count > 0 || !gravity.isZero(0); }

  /// The force at a vertex of the skin from now on, N; 0: none.
  /// @return false where there are max_forces others
  bool setForce(int at, const Vec3& newtons);
};

/// Mass of the tissue itself by nodes, sum_q V_q rho_q N_i(X_q), kg (node_count). Set-up.
AlignedVector<float> tissueMass(const Model& model);

/// du += alpha M^-1 (m g + sum_v N(X_v) f_v)
/// @param tissue_mass  m, by tissueMass
/// Real-time: no allocation, no lock, no throw. Nothing is computed where there is no load.
void addLoads(const Model& model, const AlignedVector<float>& tissue_mass, double alpha, const StepMasses& masses,
              State& state);

}  // namespace palpate
