#pragma once

#include <cmath>
#include <vector>

#include "mechanics/internal_forces.h"
#include "support/test_body.h"

namespace palpate::test {

/// Forces of the fast kernel in one instruction set.
template <class Real = float>
std::vector<Vec3> fastForces(const TestBody& body, const std::vector<Vec3>& u, int threads = 1,
                             ForceReport* report = nullptr, const NodePatches& patches = {},
                             GradientPrecision gradients = GradientPrecision::Float32,
                             InstructionSet set = chosenInstructionSet()) {
  const auto layout = makeKernelLayout<Real>(body.shape, body.point_X, body.volume, body.point_material, body.materials,
                                             body.nodeCount(), patches, gradients, body.X);
  auto scratch = makeKernelScratch(layout, set);
  SpinTeam team(threads);
  team.wake();
  AlignedVector<Real4<Real>> u4, f(body.X.size());
  for (const auto& a : u) u4.push_back(toReal4<Real>(a));
  const auto r = internalForces(layout, makeKernelMaterials(layout, body.materials), u4.data(), scratch, team);
  if (report) *report = r;
  sumForces(layout, scratch, 0, body.nodeCount(), f.data());
  team.park();
  std::vector<Vec3> result;
  for (const auto& a : f) result.push_back(toVec3(a));
  return result;
}

inline std::vector<Vec3> referenceForces(const TestBody& body, const std::vector<Vec3>& u,
                                         const NodePatches& patches = {}) {
  std::vector<Vec3> f;
  referenceInternalForces(body.shape, body.volume, body.point_material, body.materials, u, f, patches);
  return f;
}

/// Stiffness at rest by differences of the forces (3 n, 3 n), N/m.
inline Eigen::MatrixXd stiffnessByDifferences(const TestBody& body, const NodePatches& patches = {}) {
  const int n = body.nodeCount() * 3;
  Eigen::MatrixXd K(n, n);
  std::vector<Vec3> u(body.X.size(), Vec3::Zero());
  const double e = 1e-7;
  for (int c = 0; c < n; ++c) {
    u[c / 3][c % 3] = e;
    const auto ahead = referenceForces(body, u, patches);
    u[c / 3][c % 3] = -e;
    const auto behind = referenceForces(body, u, patches);
    u[c / 3][c % 3] = 0;
    for (int r = 0; r < n; ++r) K(r, c) = -(ahead[r / 3][r % 3] - behind[r / 3][r % 3]) / (2 * e);
  }
  return (K + K.transpose()) / 2;
}

inline double norm(const std::vector<Vec3>& f) {
  double s = 0;
  for (const auto& a : f) s += a.squaredNorm();
  return std::sqrt(s);
}
inline double distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double s = 0;
  for (std::size_t i = 0; i < a.size(); ++i) s += (a[i] - b[i]).squaredNorm();
  return std::sqrt(s);
}

/// Smooth displacement with strains up to about `size`.
inline std::vector<Vec3> wave(const TestBody& body, double size) {
  const double L = body.X.back()[0];
  std::vector<Vec3> u;
  for (const auto& x : body.X)
    u.emplace_back(size * L / 4 *
                   Vec3(std::sin(3 * x[1] / L), std::cos(2 * x[2] / L), std::sin(2 * x[0] / L + x[2] / L)));
  return u;
}

/// Displacements that are hard on a kernel: large strain, a turn by 90 degrees, compression by 75 %.
inline std::vector<std::vector<Vec3>> hardStates(const TestBody& body) {
  const Mat3 turn = Eigen::AngleAxisd(M_PI / 2, Vec3(0, 0.6, 0.8)).toRotationMatrix();
  auto turned = wave(body, 0.2);
  for (std::size_t i = 0; i < turned.size(); ++i) turned[i] = turn * (body.X[i] + turned[i]) - body.X[i];
  auto squeezed = body.displacement(Vec3(2.0, 2.0, 0.25).asDiagonal());
  const auto bumps = wave(body, 0.02);
  for (std::size_t i = 0; i < squeezed.size(); ++i) squeezed[i] += bumps[i];
  return {wave(body, 0.3), turned, squeezed};
}

inline Material ogden() {
  const double mu = 643.6, alpha = -1.1;
  return Material::ogden(&mu, &alpha, 1, 1.2598e-4, 970);
}

}  // namespace palpate::test
