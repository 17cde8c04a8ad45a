#include "model/point_groups.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "discretization/cells/background_cells.h"

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

/// Nodes that are held where that ends without a cell's depth: amid smooth skin, and of lines and sheets inside
/// (node_count).
std::vector<bool> heldEdges(const Preparation& p) {
  constexpr double smooth = 0.5;  // cosine between facets
  std::vector<bool> held(p.X.size(), false), edge(p.X.size(), false);
  for (const ImposedNode& node : p.essential.nodes)
    if (node.node >= 0)
      held[static_cast<std::size_t>(node.node)] =
          std::all_of(node.boundary.begin(), node.boundary.end(), [](int b) { return b >= 0; });
  if (std::find(held.begin(), held.end(), true) == held.end()) return edge;
  const auto isHeld = [&](const auto& nodes) {
    return std::all_of(nodes.begin(), nodes.end(), [&](int i) { return held[static_cast<std::size_t>(i)]; });
  };

  const std::vector<std::array<int, 3>> facets = boundaryFacets(p.cells);
  std::map<std::pair<int, int>, std::size_t> across;  // the facet at an edge
  std::vector<bool> of_facet(p.X.size(), false), inside(p.X.size(), true);
  const auto normal = [&](const std::array<int, 3>& f) {
    const auto at = [&](std::size_t k) { return p.X[static_cast<std::size_t>(f[k])]; };
    return Vec3((at(1) - at(0)).cross(at(2) - at(0)).normalized());
  };
  for (std::size_t k = 0; k < facets.size(); ++k)
    for (std::size_t e = 0; e < 3; ++e) {
      const int a = facets[k][e], b = facets[k][(e + 1) % 3];
      inside[static_cast<std::size_t>(a)] = false;
      if (isHeld(facets[k])) of_facet[static_cast<std::size_t>(a)] = true;
      const auto [other, is_new] = across.try_emplace(std::minmax(a, b), k);
      if (is_new || isHeld(facets[k]) == isHeld(facets[other->second])) continue;
      if (normal(facets[k]).dot(normal(facets[other->second])) > smooth)
        edge[static_cast<std::size_t>(a)] = edge[static_cast<std::size_t>(b)] = true;
    }

  for (std::size_t i = 0; i < p.X.size(); ++i)
    if (held[i] && !of_facet[i]) edge[i] = true;
  std::vector<bool> deep = held;  // all cells around are held, and none is at the skin
  for (const auto& cell : p.cells)
    if (!isHeld(cell))
      for (const int i : cell) deep[static_cast<std::size_t>(i)] = false;
  for (std::size_t i = 0; i < p.X.size(); ++i) deep[i] = deep[i] && inside[i];
  for (const auto& cell : p.cells)
    if (std::any_of(cell.begin(), cell.end(), [&](int i) { return deep[static_cast<std::size_t>(i)]; }))
      for (const int i : cell) edge[static_cast<std::size_t>(i)] = false;
  return edge;
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

PointGroups makePointGroups(const Preparation& p, const std::vector<int>& base) {
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
      const int own = p.point_material[q], material = base.empty() ? own : base[static_cast<std::size_t>(own)];
      const auto [group, is_new] = number.try_emplace({node, material}, static_cast<int>(number.size()));
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
  const std::vector<bool> edge = heldEdges(p);
  for (std::size_t q = 0; q < points; ++q) {
    const auto& cell = p.cells[static_cast<std::size_t>(p.point_cell[q])];
    groups.at_edge.push_back(
        std::any_of(cell.begin(), cell.end(), [&](int i) { return edge[static_cast<std::size_t>(i)]; }));
    const Corners X = cornersOf(p, q);
    groups.position.push_back(barycentric(X, p.point_X[q]));
    groups.unseen.push_back(unseenOf(X, p.point_X[q], p.point_volume[q]));
  }
  return groups;
}

}  // namespace palpate
