#include "model/point_groups.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <map>
#include <utility>

namespace palpate {
namespace {

using Corners = std::array<Vec3, 4>;

Corners cornersOf(const Preparation& p, std::size_t q) {
  Corners X;
  for (std::size_t k = 0; k < 4; ++k)
    X[k] = p.X[static_cast<std::size_t>(p.cells[static_cast<std::size_t>(p.point_cell[q])][k])];
  return X;
}

std::array<float, 4> barycentric(const Corners& X, const Vec3& at) {
  Mat3 edges;
  edges << X[1] - X[0], X[2] - X[0], X[3] - X[0];
  const Eigen::Vector3f b = edges.inverse().operator*(at - X[0]).cast<float>();
  return {1 - b.sum(), b[0], b[1], b[2]};
}

/// Of the first cell of a point. @param volume  of all that it stands for, m^3
float unseenOf(const Corners& X, const Vec3& at, double volume) {
  constexpr double of_cell = PointGroups::of_cell, alike = 1e-6;
  const double first = std::abs((X[1] - X[0]).cross(X[2] - X[0]).dot(X[3] - X[0])) / 6, other = volume - first;
  if (other < -alike * first) return 0;
  if (other < alike * first) return of_cell;
  const Vec3 middle = (X[0] + X[1] + X[2] + X[3]) / 4, other_middle = (volume * at - first * middle) / other;
  double seen = 0;  // moment of the first, over its volume, m^2
  for (const Vec3& x : X) seen += of_cell * (x - middle).squaredNorm();
  const double edge = std::cbrt(6 * std::sqrt(2.0) * other), second = 4 * of_cell * 3.0 / 8 * edge * edge;
  const double sum =
      first * (seen + (middle - at).squaredNorm()) + other * (second + (other_middle - at).squaredNorm());
  return static_cast<float>(of_cell * sum / (volume * seen));
}

/// What a point weighs in the fit of a group is w (1 + slope . (X - middle)), w its share of the volume.
struct Fit {
  Vec3 node = Vec3::Zero(), middle = Vec3::Zero(), slope = Vec3::Zero();
  Mat3 moment = Mat3::Zero();
  double volume = 0;

  void solve() {
    constexpr double flat = 0.03;
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(moment);
    const double least = flat * std::max(solver.eigenvalues()[2], (node - middle).squaredNorm());
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Vec3 axis = solver.eigenvectors().col(k);
      if (const double along = solver.eigenvalues()[k]; along > least) slope += axis.dot(node - middle) / along * axis;
    }
  }
};

}  // namespace

PointGroups makePointGroups(const Preparation& p) {
  PointGroups groups;
  std::map<std::pair<int, int>, int> number;  // of node and material
  std::vector<Fit> fit;
  const std::size_t points = p.point_X.size();
  const auto forEach = [&](auto act) {
    for (std::size_t q = 0; q < points; ++q)
      for (std::size_t k = 0; k < 4; ++k) act(q, k, fit[static_cast<std::size_t>(groups.of_point[q][k])]);
  };
  groups.of_point.resize(points);
  for (std::size_t q = 0; q < points; ++q)
    for (std::size_t k = 0; k < 4; ++k) {
      const int node = p.cells[static_cast<std::size_t>(p.point_cell[q])][k];
      const auto [group, is_new] = number.try_emplace({node, p.point_material[q]}, static_cast<int>(number.size()));
      groups.of_point[q][k] = group->second;
      if (is_new) fit.emplace_back().node = p.X[static_cast<std::size_t>(node)];
    }
  groups.count = static_cast<int>(fit.size());
  forEach([&](std::size_t q, std::size_t, Fit& f) {
    f.volume += p.point_volume[q];
    f.middle += p.point_volume[q] * p.point_X[q];
  });
  for (Fit& f : fit) f.middle /= f.volume;
  forEach([&](std::size_t q, std::size_t, Fit& f) {
    const Vec3 off = p.point_X[q] - f.middle;
    f.moment += p.point_volume[q] / f.volume * off * off.transpose();
  });
  for (Fit& f : fit) f.solve();
  groups.share.resize(points);
  groups.weight.resize(points);
  forEach([&](std::size_t q, std::size_t k, const Fit& f) {
    const double share = p.point_volume[q] / f.volume;
    groups.share[q][k] = static_cast<float>(share);
    groups.weight[q][k] = static_cast<float>(share * (1 + f.slope.dot(p.point_X[q] - f.middle)));
  });
  for (std::size_t q = 0; q < points; ++q) {
    const Corners X = cornersOf(p, q);
    groups.position.push_back(barycentric(X, p.point_X[q]));
    groups.unseen.push_back(unseenOf(X, p.point_X[q], p.point_volume[q]));
  }
  return groups;
}

}  // namespace palpate
