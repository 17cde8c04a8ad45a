#include "mechanics/essential_boundary.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>

#include "base/float4.h"

namespace palpate {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

/// Ratio of the extreme pivots of A = L L^T (squared diagonal of L) beyond which float32 loses the
/// boundary: nodes that (nearly) coincide.
constexpr double max_condition = 1e10;

EssentialBoundary::Set makeSet(const std::vector<int>& rows, const std::vector<ImposedNode>& imposed,
                               const ShapeTable& shape, const std::vector<double>& mass) {
  // A = Phi M^-1 Phi^T over the set's rows.
  const int n = static_cast<int>(rows.size());
  Sparse phi(n, static_cast<Eigen::Index>(mass.size()));
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < n; ++k)
    for (int e = shape.begin[rows[k]]; e < shape.begin[rows[k] + 1]; ++e)
      entries.emplace_back(k, shape.node[e], shape.N[e]);
  phi.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd inverse_mass =
      Eigen::Map<const Eigen::VectorXd>(mass.data(), static_cast<Eigen::Index>(mass.size())).cwiseInverse();
  const Sparse A = phi * inverse_mass.asDiagonal() * Sparse(phi.transpose());

  const Eigen::SimplicialLLT<Sparse, Eigen::Lower, Eigen::AMDOrdering<int>> factor(A);
  if (factor.info() != Eigen::Success)
    throw std::runtime_error("the imposed nodes around node " + std::to_string(imposed[rows[0]].node) +
                             " can't be imposed independently: some coincide");
  const Sparse L = factor.matrixL();
  const auto& order = factor.permutationP().indices();  // row k of A stands at order[k] in L

  EssentialBoundary::Set set;
  set.node.resize(n);
  set.motion.resize(n);
  std::vector<int> source(n);
  for (int k = 0; k < n; ++k) source[order[k]] = rows[k];
  set.phi_begin.push_back(0);
  for (int k = 0; k < n; ++k) {
    set.node[k] = imposed[source[k]].node;
    set.motion[k] = imposed[source[k]].motion;
    for (int c = 0; c < 3; ++c) set.moves |= set.motion[k][c] >= 0;
    for (int e = shape.begin[source[k]]; e < shape.begin[source[k] + 1]; ++e) {
      set.phi_node.push_back(shape.node[e]);
      set.phi.push_back(static_cast<float>(shape.N[e]));
    }
    set.phi_begin.push_back(static_cast<int>(set.phi_node.size()));
  }
  set.l_begin.push_back(0);
  double smallest = 1e300, largest = 0;
  int weakest = 0;
  for (int c = 0; c < n; ++c) {
    for (Sparse::InnerIterator it(L, c); it; ++it) {
      set.l_row.push_back(static_cast<int>(it.row()));
      set.l.push_back(static_cast<float>(it.row() == c ? 1 / it.value() : it.value()));
      if (it.row() != c) continue;
      largest = std::max(largest, it.value());
      if (it.value() < smallest) {
        smallest = it.value();
        weakest = c;
      }
    }
    set.l_begin.push_back(static_cast<int>(set.l_row.size()));
  }
  if (largest * largest > max_condition * smallest * smallest)
    throw std::runtime_error("imposed node " + std::to_string(set.node[weakest]) +
                             " nearly coincides with another imposed node");
  return set;
}

}  // namespace

Vec3 motionAt(const BoundaryMotion& motion, double time_s) {
  if (motion.duration <= 0) return time_s > 0 ? motion.translation : Vec3(Vec3::Zero());
  const double t = std::clamp(time_s / motion.duration, 0.0, 1.0);
  return t * t * t * (10 + t * (-15 + 6 * t)) * motion.translation;
}

EssentialBoundary makeEssentialBoundary(const std::vector<ImposedNode>& imposed,
                                        const std::vector<BoundaryMotion>& motions,
                                        const ShapeTable& boundary_shape, const std::vector<double>& mass) {
  EssentialBoundary boundary;
  boundary.motions = motions;
  std::map<std::vector<int>, std::array<float, 4>> sets;  // rows -> components
  for (int c = 0; c < 3; ++c) {
    std::vector<int> rows;
    for (int k = 0; k < static_cast<int>(imposed.size()); ++k)
      if (imposed[k].component[c]) rows.push_back(k);
    if (!rows.empty()) sets[rows][c] = 1;
  }
  for (const auto& [rows, mask] : sets) {
    boundary.sets.push_back(makeSet(rows, imposed, boundary_shape, mass));
    boundary.sets.back().mask = mask;
  }
  return boundary;
}

BoundaryScratch makeBoundaryScratch(const EssentialBoundary& boundary) {
  std::size_t rows = 0;
  for (const auto& set : boundary.sets) rows = std::max(rows, set.node.size());
  return {AlignedVector<Float4>(rows)};
}

namespace {

/// What the motions of one node's components travel in the step that ends at `time_s`.
Vec3 imposedIncrement(const EssentialBoundary& boundary, const std::array<int, 3>& motion, double time_s, double dt) {
  Vec3 increment = Vec3::Zero();
  for (int c = 0; c < 3; ++c) {
    if (motion[c] < 0) continue;
    const auto& m = boundary.motions[motion[c]];
    increment[c] = motionAt(m, time_s)[c] - motionAt(m, time_s - dt)[c];
  }
  return increment;
}

}  // namespace

Vec3 imposeBoundary(const EssentialBoundary& boundary, double time_s, double dt, double alpha,
                    const float* inverse_mass, Float4* du, BoundaryScratch& scratch) {
  Vec3 reaction = Vec3::Zero();
  for (const auto& set : boundary.sets) {
    Float4* r = scratch.rhs.data();
    const int n = static_cast<int>(set.node.size());
    // r = du_bar - Phi du                                        (bracket of eq. 24)
    for (int k = 0; k < n; ++k) {
      r[k] = {};
      for (int e = set.phi_begin[k]; e < set.phi_begin[k + 1]; ++e) addScaled(r[k], -set.phi[e], du[set.phi_node[e]]);
      if (set.moves) addScaled(r[k], 1, toFloat4(imposedIncrement(boundary, set.motion[k], time_s, dt)));
    }
    // A^-1 r = L^-T L^-1 r
    for (int c = 0; c < n; ++c) {
      scale(r[c], set.l[set.l_begin[c]]);
      const Float4 x = r[c];
      for (int e = set.l_begin[c] + 1; e < set.l_begin[c + 1]; ++e) addScaled(r[set.l_row[e]], -set.l[e], x);
    }
    for (int c = n - 1; c >= 0; --c) {
      Float4 x = r[c];
      for (int e = set.l_begin[c] + 1; e < set.l_begin[c + 1]; ++e) addScaled(x, -set.l[e], r[set.l_row[e]]);
      scale(x, set.l[set.l_begin[c]]);
      r[c] = x;
    }
    // du += M^-1 Phi^T A^-1 r                                    (eqs. 23-25)
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < n; ++k) {
      const Float4 x{r[k].x * set.mask[0], r[k].y * set.mask[1], r[k].z * set.mask[2], 0};
      for (int c = 0; c < 3; ++c)
        if (set.motion[k][c] < 0) sum[c] += (&x.x)[c];
      for (int e = set.phi_begin[k]; e < set.phi_begin[k + 1]; ++e) {
        const int i = set.phi_node[e];
        addScaled(du[i], set.phi[e] * inverse_mass[i], x);
      }
    }
    reaction += sum / alpha;
  }
  return reaction;
}

}  // namespace palpate
