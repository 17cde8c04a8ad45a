#include "discretization/gradients/boundary_points.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "discretization/surface/facet_rule.h"

namespace palpate {
namespace {

/// Conjugate gradients on the normal equations of min |B x - r|^2, x orthogonal to the linear functions of X.
class LeastSquares {
 public:
  /// @param rows  samples whose entries of N are B's columns
  LeastSquares(const ShapeTable& N, const std::vector<int>& rows, const BoundaryPoints& samples) : N_(N), rows_(rows) {
    Vec3 middle = Vec3::Zero();
    for (const int k : rows) middle += samples.X[k] / static_cast<double>(rows.size());
    Eigen::Matrix<double, Eigen::Dynamic, 4> linear(static_cast<Eigen::Index>(rows.size()), 4);
    double size = 0;
    for (const int k : rows) size = std::max(size, (samples.X[k] - middle).norm());
    for (Eigen::Index j = 0; j < linear.rows(); ++j)
      linear.row(j) << 1, (samples.X[rows[j]] - middle).transpose() / std::max(size, 1e-12);
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(linear);
    qr.setThreshold(1e-9);  // a flat face has no more than three
    kept_ = qr.householderQ() * Eigen::MatrixXd::Identity(linear.rows(), qr.rank());
  }

  Eigen::VectorXd solve(Eigen::VectorXd r) const {
    constexpr int most = 100;
    // Of three points every function is linear, and g nothing but rounding, some 1e-16 of B^T r.
    constexpr double tolerance = 1e-8, rounding = 1e-13;
    Eigen::VectorXd x = Eigen::VectorXd::Zero(kept_.rows()), g = transposed(r), p = g, Bp(r.size());
    double gg = g.squaredNorm();
    const double stop = std::max(tolerance * tolerance * gg, rounding * rounding * whole(r).squaredNorm());
    for (int k = 0; k < most && gg > stop; ++k) {
      Bp.setZero();
      for (std::size_t j = 0; j < rows_.size(); ++j)
        for (int e = N_.begin[rows_[j]]; e < N_.begin[rows_[j] + 1]; ++e)
          Bp[N_.node[e]] += N_.N[e] * p[static_cast<Eigen::Index>(j)];
      const double step = gg / Bp.squaredNorm();
      x += step * p;
      r -= step * Bp;
      g = transposed(r);
      const double before = gg;
      gg = g.squaredNorm();
      p = g + gg / before * p;
    }
    return x;
  }

 private:
  /// B^T r
  Eigen::VectorXd whole(const Eigen::VectorXd& r) const {
    Eigen::VectorXd g = Eigen::VectorXd::Zero(kept_.rows());
    for (std::size_t j = 0; j < rows_.size(); ++j)
      for (int e = N_.begin[rows_[j]]; e < N_.begin[rows_[j] + 1]; ++e)
        g[static_cast<Eigen::Index>(j)] += N_.N[e] * r[N_.node[e]];
    return g;
  }

  /// That without its linear part.
  Eigen::VectorXd transposed(const Eigen::VectorXd& r) const {
    const Eigen::VectorXd g = whole(r);
    return g - kept_ * (kept_.transpose() * g);
  }

  const ShapeTable& N_;
  const std::vector<int>& rows_;
  Eigen::MatrixXd kept_;  // an orthonormal basis of the linear functions
};

/// A facet faces a component from this share of its area on.
constexpr double faces_component = 1e-6;

/// The held face that each facet is of, or -1 (facet_count).
template <class Area>
std::vector<int> heldFaces(const std::vector<std::array<int, 3>>& facets, const std::vector<std::uint8_t>& imposed,
                           bool loaded, const Area& area) {
  constexpr double least_cosine = 0.5;
  std::vector<int> first(facets.size(), -1);  // another facet of the face, itself at the root
  const auto root = [&](int k) {
    while (first[k] != k) k = first[k] = first[first[k]];
    return k;
  };
  std::map<std::pair<int, int>, int> across;  // the facet at an edge
  for (int k = 0; k < static_cast<int>(facets.size()); ++k) {
    const std::array<int, 3>& f = facets[k];
    const Vec3 n = area(f).normalized();
    const int held = imposed[f[0]] & imposed[f[1]] & imposed[f[2]];
    int wanted = loaded ? 7 : 0;
    for (int c = 0; c < 3; ++c)
      if (std::abs(n[c]) > faces_component) wanted |= 1 << c;
    if ((held & wanted) != wanted) continue;
    first[k] = k;
    for (int e = 0; e < 3; ++e) {
      const auto [other, is_new] = across.try_emplace(std::minmax(f[e], f[(e + 1) % 3]), k);
      if (is_new || n.dot(area(facets[other->second]).normalized()) < least_cosine) continue;
      first[root(k)] = root(other->second);
    }
  }
  for (int k = 0; k < static_cast<int>(facets.size()); ++k)
    if (first[k] >= 0) first[k] = root(k);
  return first;
}

}  // namespace

void BoundaryPoints::add(const Vec3& at, const Vec3& its_area, int its_node) {
  X.push_back(at);
  area.push_back(its_area);
  node.push_back(its_node);
  face.push_back(-1);
  of_held.emplace_back(Vec3::Zero());
}

void BoundaryPoints::append(const BoundaryPoints& other, std::size_t begin, std::size_t end) {
  const auto join = [&](auto& to, const auto& from) {
    const auto first = from.begin() + static_cast<std::ptrdiff_t>(begin);
    to.insert(to.end(), first, first + static_cast<std::ptrdiff_t>(end - begin));
  };
  join(X, other.X);
  join(area, other.area);
  join(node, other.node);
  join(face, other.face);
  join(of_held, other.of_held);
}

BoundaryPoints boundaryPoints(const std::vector<Vec3>& X, const std::vector<std::array<int, 3>>& facets,
                              const std::vector<std::uint8_t>& imposed, bool loaded) {
  const auto area = [&](const std::array<int, 3>& f) { return Vec3((X[f[1]] - X[f[0]]).cross(X[f[2]] - X[f[0]]) / 2); };
  const std::vector<int> face = heldFaces(facets, imposed, loaded, area);
  BoundaryPoints samples;
  std::map<std::pair<int, int>, Vec3> thirds;  // of face and node
  for (std::size_t k = 0; k < facets.size(); ++k) {
    const std::array<int, 3>& f = facets[k];
    const bool lumped = std::all_of(f.begin(), f.end(), [&](int i) { return imposed[i] != 0; });
    if (lumped)
      for (const int i : f) thirds.try_emplace({face[k], i}, Vec3::Zero()).first->second += area(f) / 3;
    if (lumped && face[k] < 0) continue;
    for (int s = 0; s < FacetRule::size; ++s) {
      const Vec3 part = FacetRule::weight(s) * area(f);
      samples.add(FacetRule::point(s, X[f[0]], X[f[1]], X[f[2]]), lumped ? Vec3(Vec3::Zero()) : part);
      samples.face.back() = face[k];
      if (lumped) samples.of_held.back() = part;
    }
  }
  for (const auto& [where, sum] : thirds) {
    samples.add(X[where.second], sum, where.second);
    samples.face.back() = where.first;
  }
  return samples;
}

void balanceNodes(BoundaryPoints& boundary, const ShapeTable& at_boundary) {
  if (at_boundary.node.empty()) return;
  const Eigen::Index node_count = 1 + *std::max_element(at_boundary.node.begin(), at_boundary.node.end());
  std::map<int, std::vector<int>> faces;  // samples of each
  for (std::size_t k = 0; k < boundary.X.size(); ++k)
    if (boundary.face[k] >= 0) faces[boundary.face[k]].push_back(static_cast<int>(k));
  for (const auto& [number, samples] : faces)
    for (int c = 0; c < 3; ++c) {
      // A node that has none of this component may not be imposed in it, either.
      std::vector<int> rows;
      for (const int k : samples)
        if (boundary.node[k] >= 0 && std::abs(boundary.area[k][c]) > faces_component * boundary.area[k].norm())
          rows.push_back(k);
      if (rows.empty()) continue;
      Eigen::VectorXd r = Eigen::VectorXd::Zero(node_count);
      for (const int k : samples)
        for (int e = at_boundary.begin[k]; e < at_boundary.begin[k + 1]; ++e)
          r[at_boundary.node[e]] += (boundary.of_held[k][c] - boundary.area[k][c]) * at_boundary.N[e];
      const Eigen::VectorXd change = LeastSquares(at_boundary, rows, boundary).solve(r);
      for (std::size_t j = 0; j < rows.size(); ++j) boundary.area[rows[j]][c] += change[static_cast<Eigen::Index>(j)];
    }
}

}  // namespace palpate
