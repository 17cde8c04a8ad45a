#include "step/limit_compression.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cstring>
#include <random>

#include "step/follow_stiffness.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

/// Points' J at u + share of du, in the kernel's order (padding 1).
AlignedVector<float> volumeRatios(const Model& model, const State& state, float share) {
  AlignedVector<float> J(model.kernel.point.size(), 1.0F);
  std::vector<Vec3> x(model.X.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = toVec3(state.u[i]) + share * toVec3(state.du[i]);
  for (std::size_t place = 0; place < J.size(); ++place)
    if (const int q = model.kernel.point[place]; q >= 0)
      J[place] = static_cast<float>(deformationGradient(model.point_shape, q, x).determinant());
  return J;
}

/// The kernel's at u.
KernelScratch scratchOf(const Model& model, const State& state) {
  KernelScratch scratch = Workspace(model, 1).kernel;
  scratch.J = volumeRatios(model, state, 0);
  scratch.cof2.assign(scratch.J.size(), 3);
  std::vector<Vec3> x(model.X.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = toVec3(state.u[i]);
  for (std::size_t place = 0; place < scratch.J.size(); ++place)
    if (const int q = model.kernel.point[place]; q >= 0) {
      const Mat3 F = deformationGradient(model.point_shape, q, x);
      scratch.cof2[place] = static_cast<float>((F.determinant() * F.inverse()).squaredNorm());
    }
  return scratch;
}

void limit(const Model& model, float least_J, double max_cof2, State& state) {
  ForceReport forces;
  forces.min_J = least_J;
  forces.max_cof2 = max_cof2;
  const StepMasses masses{model.inverse_mass.data(), nullptr, nullptr, 1, 0, 0};
  SpinTeam team(2);
  CompressionLimit(model).apply(model, scratchOf(model, state), forces, masses, state, team);
}

Vec3 momentum(const Model& model, const State& state) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < model.X.size(); ++i) sum += toVec3(state.du[i]) / model.inverse_mass[i];
  return sum;
}

double energy(const Model& model, const State& state) {
  double sum = 0;
  for (std::size_t i = 0; i < model.X.size(); ++i) sum += toVec3(state.du[i]).squaredNorm() / model.inverse_mass[i];
  return sum;
}

/// Squeezed flat to a sixth, and in the next step further, through itself where X is in the middle.
State squeezed(const Model& model, double further) {
  State state = initialState(model);
  std::mt19937 random(3);
  for (std::size_t i = 0; i < model.X.size(); ++i) {
    const Vec3& X = model.X[i];
    const double trembles = 1e-5 * (static_cast<double>(random() % 2000) / 1000 - 1);
    state.u[i] = toFloat4(Vec3(0, 0, -(1 - 1. / 6) * X.z()));
    state.du[i] = toFloat4(Vec3(trembles, 0, -further * X.z() * (X.head<2>().norm() < 0.015)));
  }
  return state;
}

}  // namespace

TEST_CASE("No step takes more than half of a squeezed point's volume, and none turns it inside out",
          "[limit_compression]") {
  const Model model = test::blockModel(test::blockScene());
  State state = squeezed(model, 0.3);
  const AlignedVector<float> before = volumeRatios(model, state, 0), wanted = volumeRatios(model, state, 1);
  const float least = *std::min_element(before.begin(), before.end());
  REQUIRE(least > 0.1F);
  REQUIRE(*std::min_element(wanted.begin(), wanted.end()) < -0.01F);
  const Vec3 had = momentum(model, state);
  const double energy_before = energy(model, state);
  limit(model, least, 3, state);
  const AlignedVector<float> after = volumeRatios(model, state, 1);
  int moved = 0;
  for (std::size_t k = 0; k < after.size(); ++k) {
    CHECK(after[k] > 0.4F * before[k]);  // a half but for what the sweeps leave
    moved += wanted[k] < 0.5F * before[k];
  }
  CHECK(moved > 5);
  CHECK((momentum(model, state) - had).norm() < 1e-5 * had.norm());  // float's rounding
  CHECK(energy(model, state) < energy_before);
}

TEST_CASE("What is squeezed no further than by half in a step is left alone, bit for bit", "[limit_compression]") {
  const Model model = test::blockModel(test::blockScene());
  State state = squeezed(model, 0.02);
  const AlignedVector<Float4> before = state.du;
  limit(model, 0.1F, 3, state);
  CHECK(std::memcmp(before.data(), state.du.data(), before.size() * sizeof(Float4)) == 0);
}

TEST_CASE("Nor does a step as wide as a cell turn tissue inside out that was at rest", "[limit_compression]") {
  const Model model = test::blockModel(test::blockScene());
  State state = initialState(model);
  for (std::size_t i = 0; i < model.X.size(); ++i)
    state.du[i] = toFloat4(Vec3(0, 0, -1.3 * model.X[i].z() * (model.X[i].head<2>().norm() < 0.015)));
  const AlignedVector<float> before = volumeRatios(model, state, 0), wanted = volumeRatios(model, state, 1);
  REQUIRE(*std::min_element(before.begin(), before.end()) > 0.999F);
  REQUIRE(*std::min_element(wanted.begin(), wanted.end()) < -0.2F);
  const Vec3 had = momentum(model, state);
  const double energy_before = energy(model, state);
  limit(model, 1, 3, state);
  const AlignedVector<float> after = volumeRatios(model, state, 1);
  CHECK(*std::min_element(after.begin(), after.end()) > 0.45F);  // a half but for what the sweeps leave
  CHECK((momentum(model, state) - had).norm() < 1e-5 * had.norm());
  CHECK(energy(model, state) < energy_before);
}

TEST_CASE("Nor is tissue turned inside out that is pressed flat at its volume, however slowly", "[limit_compression]") {
  const Model model = test::blockModel(test::blockScene());
  State state = initialState(model);
  constexpr double flat = 1.0 / 12;
  const double wide = 1 / std::sqrt(flat);
  for (std::size_t i = 0; i < model.X.size(); ++i) {
    const Vec3& X = model.X[i];
    state.u[i] = toFloat4(Vec3((wide - 1) * X.x(), (wide - 1) * X.y(), (flat - 1) * X.z()));
    state.du[i] = toFloat4(Vec3(0, 0, X.head<2>().norm() < 0.015 ? -1.5 * flat * X.z() : 0));
  }
  const AlignedVector<float> before = volumeRatios(model, state, 0), wanted = volumeRatios(model, state, 1);
  REQUIRE(*std::min_element(before.begin(), before.end()) > 0.9F);
  REQUIRE(*std::min_element(wanted.begin(), wanted.end()) < 0);
  limit(model, 1, wide * wide * wide * wide, state);
  const AlignedVector<float> after = volumeRatios(model, state, 1);
  CHECK(*std::min_element(after.begin(), after.end()) > 0.4F);
}
