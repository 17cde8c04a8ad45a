#include <catch2/catch.hpp>
#include <random>

#include "support/kernel_forces.h"

using namespace palpate;
using namespace palpate::test;

namespace {

constexpr GradientPrecision precisions[] = {GradientPrecision::Float32, GradientPrecision::Int16};

/// Nodes displaced at random by up to a twentieth of their distance.
std::vector<Vec3> shaken(const TestBody& body) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> offset(-1, 1);
  const double size = 0.05 * body.X.back()[0] / (body.n - 1);
  std::vector<Vec3> u;
  for (int i = 0; i < body.nodeCount(); ++i) {
    const double x = offset(random), y = offset(random), z = offset(random);
    u.push_back(size * Vec3(x, y, z));
  }
  return u;
}

std::string describe(InstructionSet set, GradientPrecision gradients, bool patched) {
  return std::string(nameOf(set)) + (gradients == GradientPrecision::Int16 ? ", int16" : ", float32") +
         (patched ? ", patches" : "");
}

}  // namespace

TEST_CASE("Each instruction set's kernel equals the reference, with float32 and 16-bit gradients",
          "[kernel][instructions]") {
  for (const auto& material :
       {Material::neoHookean(3000, 0.49, 1000), Material::neoHookean(3000, 0.499, 1000), ogden()}) {
    const TestBody body(6, 0.1, 1, 1.8, 0.1, 0.2, material);
    auto states = hardStates(body);  // strained, turned by 90 degrees, compressed by 75 %
    states.push_back(shaken(body));
    for (const NodePatches& patches : {NodePatches{}, body.patches()})
      for (std::size_t state = 0; state < states.size(); ++state) {
        const auto exact = referenceForces(body, states[state], patches);
        double min_J = 1;
        for (int q = 0; q < body.shape.rowCount(); ++q)
          min_J = std::min(min_J, deformationGradient(body.shape, q, states[state]).determinant());
        for (const InstructionSet set : supportedInstructionSets())
          for (const GradientPrecision gradients : precisions) {
            ForceReport report;
            const auto fast = fastForces(body, states[state], 1, &report, patches, gradients, set);
            const double ratio = material.bulk_modulus / material.shear_modulus;
            const double error = distance(fast, exact) / norm(exact);
            INFO(describe(set, gradients, !patches.empty())
                 << ", state " << state << ": relative error " << error << " at K/mu " << ratio);
            // Gradients rounded to float move J by 6e-8 |gradN| |u| n^(1/2) ~ 1e-6, which the bulk modulus multiplies
            // against forces of the order of the shear modulus: (K / mu) 1e-6. Rounded to 16 bits they are off by up to
            // 1.5e-5 of the largest, and so are the forces that they spread, whatever K; F is not (kernel_layout.h).
            CHECK(error < 1e-6 * ratio + (gradients == GradientPrecision::Int16 ? 3e-5 : 0));
            CHECK(report.min_J == Approx(min_J).epsilon(1e-4));
            CHECK(report.inverted_points == 0);
          }
      }
  }
}

TEST_CASE("Rigid motion makes no force in any kernel", "[kernel][instructions]") {
  const TestBody body(6, 0.1, 4, 1.8, 0.1, 0.2, Material::neoHookean(3000, 0.499, 1000));
  const auto strained = referenceForces(body, wave(body, 0.3));
  for (const double angle : {0.7, M_PI / 2}) {
    auto u = body.displacement(Eigen::AngleAxisd(angle, Vec3(1, 1, 0).normalized()).toRotationMatrix());
    for (auto& a : u) a += Vec3(0.05, -0.02, 0.01);
    for (const InstructionSet set : supportedInstructionSets())
      for (const GradientPrecision gradients : precisions)
        for (const NodePatches& patches : {NodePatches{}, body.patches()}) {
          const double error = norm(fastForces(body, u, 1, nullptr, patches, gradients, set)) / norm(strained);
          INFO(describe(set, gradients, !patches.empty()) << ": " << error << " of a working force");
          CHECK(error <
                1e-4);  // float's 1e-6 in J times K / mu = 500, against a force to which K gives most: a fifth of it
        }
  }
}

TEST_CASE("In every kernel any number of threads gives the same bits", "[kernel][instructions][determinism]") {
  for (const auto& material : {Material::neoHookean(3000, 0.49, 1000), ogden()}) {
    const TestBody body(6, 0.1, 1, 1.8, 0.1, 0.2, material);
    const auto u = wave(body, 0.3);
    for (const InstructionSet set : supportedInstructionSets())
      for (const NodePatches& patches : {NodePatches{}, body.patches()}) {
        std::vector<std::vector<Vec3>> forces;
        for (const GradientPrecision gradients : precisions) {
          INFO(describe(set, gradients, !patches.empty()));
          forces.push_back(fastForces(body, u, 1, nullptr, patches, gradients, set));
          for (const int threads : {2, 3})
            CHECK(fastForces(body, u, threads, nullptr, patches, gradients, set) == forces.back());
        }
        CHECK(forces[0] != forces[1]);  // these really are other gradients
      }
  }
}
