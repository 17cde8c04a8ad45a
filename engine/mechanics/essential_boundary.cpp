#include "mechanics/essential_boundary.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>

namespace palpate {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// Ratio of the extreme pivots of A beyond which the boundary is lost to rounding: nodes that (nearly) coincide.
constexpr double max_condition = 1e10;

SparseRows toSparse(int rows, std::size_t columns, const std::vector<Eigen::Triplet<double>>& entries) {
  SparseRows m(rows, static_cast<Eigen::Index>(columns));
  m.setFromTriplets(entries.begin(), entries.end());
  return m;
}

/// V^T of paper eq. 17 for the nodes of `row_of` (-1: not imposed), rows without a facet of their own left empty.
std::vector<Eigen::Triplet<double>> integratedTractions(const EssentialNodes& essential,
                                                        const std::vector<int>& row_of) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t f = 0; f < essential.facets.size(); ++f) {
    const auto& facet = essential.facets[f];
    if (std::any_of(facet.begin(), facet.end(), [&](int node) { return row_of[node] < 0; })) continue;
    for (int i = 0; i < essential.facet_points; ++i) {
      const int point = static_cast<int>(f) * essential.facet_points + i;
      for (int e = essential.facet_phi.begin[point]; e < essential.facet_phi.begin[point + 1]; ++e)
        for (int k = 0; k < 3; ++k)
          entries.emplace_back(row_of[facet[k]], essential.facet_phi.node[e],
                               essential.facet_weight[point][k] * essential.facet_phi.N[e]);
    }
  }
  return entries;
}

/// Where the tractions of these rows act, sum_j V_jk X_j / share = int N^k s dS / int N^k dS: the node where lumped.
std::vector<Vec3> tractionCentres(const EssentialNodes& essential, const std::vector<int>& rows,
                                  const std::vector<int>& row_of) {
  std::vector<Vec3> moment(rows.size(), Vec3::Zero()), centre;
  std::vector<double> area(rows.size(), 0);
  for (std::size_t f = 0; f < essential.facets.size(); ++f) {
    const auto& facet = essential.facets[f];
    if (std::any_of(facet.begin(), facet.end(), [&](int node) { return row_of[node] < 0; })) continue;
    for (int i = 0; i < essential.facet_points; ++i) {
      const Vec3& weight =
          essential.facet_weight[f * static_cast<std::size_t>(essential.facet_points) + static_cast<std::size_t>(i)];
      Vec3 at = Vec3::Zero();
      for (int k = 0; k < 3; ++k) at += weight[k] / weight.sum() * essential.X[rows[row_of[facet[k]]]];
      for (int k = 0; k < 3; ++k) {
        moment[row_of[facet[k]]] += weight[k] * at;
        area[row_of[facet[k]]] += weight[k];
      }
    }
  }
  for (std::size_t k = 0; k < rows.size(); ++k)
    centre.push_back(area[k] > 0 ? Vec3(moment[k] / area[k]) : essential.X[rows[k]]);
  return centre;
}

template <class Real, class RowsOf>
void append(RowsOf& rows, const SparseRows& m, int row) {
  for (SparseRows::InnerIterator it(m, row); it; ++it) {
    rows.column.push_back(static_cast<int>(it.col()));
    rows.value.push_back(static_cast<Real>(it.value()));
  }
  rows.begin.push_back(static_cast<int>(rows.column.size()));
}

/// A = L U without pivoting: A is near to a symmetric positive definite matrix (SEBCIEM: is one).
template <class Real>
void factor(const SparseRows& A, typename EssentialBoundaryOf<Real>::Set& set) {
  const int n = static_cast<int>(A.rows());
  std::vector<std::vector<std::pair<int, double>>> upper(n);
  std::vector<double> pivot(n), work(n, 0.0);
  for (int i = 0; i < n; ++i) {
    int first = i;
    for (SparseRows::InnerIterator it(A, i); it; ++it) {
      work[it.col()] = it.value();
      first = std::min(first, static_cast<int>(it.col()));
    }
    for (int k = first; k < i; ++k) {
      if (work[k] == 0) continue;
      const double l = work[k] / pivot[k];
      for (const auto& [j, a] : upper[k]) work[j] -= l * a;
      set.l.column.push_back(k);
      set.l.value.push_back(static_cast<Real>(l));
      work[k] = 0;
    }
    set.l.begin.push_back(static_cast<int>(set.l.column.size()));
    pivot[i] = work[i];
    set.inverse_pivot.push_back(static_cast<Real>(1 / pivot[i]));
    work[i] = 0;
    for (int j = i + 1; j < n; ++j) {
      if (work[j] == 0) continue;
      upper[i].emplace_back(j, work[j]);
      set.u.column.push_back(j);
      set.u.value.push_back(static_cast<Real>(work[j]));
      work[j] = 0;
    }
    set.u.begin.push_back(static_cast<int>(set.u.column.size()));
    if (!(pivot[i] > 0))
      throw std::runtime_error("the imposed nodes around node " + std::to_string(set.node[i]) +
                               " can't be imposed independently: some coincide");
  }
  const auto weakest = std::min_element(pivot.begin(), pivot.end());
  if (*std::max_element(pivot.begin(), pivot.end()) > max_condition * *weakest)
    throw std::runtime_error("imposed node " + std::to_string(set.node[weakest - pivot.begin()]) +
                             " nearly coincides with another imposed node");
}

template <class Real>
typename EssentialBoundaryOf<Real>::Set makeSet(const std::vector<int>& rows, const std::array<Real, 4>& mask,
                                                const EssentialNodes& essential, const std::vector<double>& mass) {
  const int n = static_cast<int>(rows.size());
  std::vector<int> row_of(mass.size(), -1);
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < n; ++k) {
    if (essential.nodes[rows[k]].node >= 0) row_of[essential.nodes[rows[k]].node] = k;
    for (int e = essential.phi.begin[rows[k]]; e < essential.phi.begin[rows[k] + 1]; ++e)
      entries.emplace_back(k, essential.phi.node[e], essential.phi.N[e]);
  }
  const SparseRows phi = toSparse(n, mass.size(), entries);
  SparseRows v = phi;
  const bool integrated = !essential.facets.empty();
  if (integrated) {
    auto tractions = integratedTractions(essential, row_of);
    std::vector<bool> has_facet(n, false);
    for (const auto& t : tractions) has_facet[t.row()] = true;
    for (const auto& t : entries)
      if (!has_facet[t.row()]) tractions.push_back(t);
    v = toSparse(n, mass.size(), tractions);
  }
  const Eigen::VectorXd inverse_mass =
      Eigen::Map<const Eigen::VectorXd>(mass.data(), static_cast<Eigen::Index>(mass.size())).cwiseInverse();
  const Sparse A = phi * inverse_mass.asDiagonal() * Sparse(v.transpose());

  const std::vector<Vec3> centre = tractionCentres(essential, rows, row_of);
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(A, order);  // of A + A^T
  typename EssentialBoundaryOf<Real>::Set set;
  set.mask = mask;
  for (int k = 0; k < n; ++k) {
    const int from = order.indices()[k];  // the k-th to be eliminated
    const ImposedNode& node = essential.nodes[rows[from]];
    set.node.push_back(node.node);
    set.X.push_back(essential.X[rows[from]]);
    set.boundary.push_back(node.boundary);
    set.whole.push_back(node.boundary);
    for (int c = 0; c < 3; ++c)
      if (mask[c] == 0) set.boundary.back()[c] = -1;
    set.share.push_back(v.row(from).sum());
    set.centre.push_back(centre[from]);
    append<Real>(set.phi, phi, from);
    if (integrated) append<Real>(set.v, v, from);
  }
  // V by nodes, so that threads can share them.
  const SparseRows by_node = Sparse(order.inverse() * v).transpose();
  for (int j = 0; j < static_cast<int>(mass.size()); ++j) {
    if (by_node.outerIndexPtr()[j] == by_node.outerIndexPtr()[j + 1]) continue;
    set.touched.push_back(j);
    append<Real>(set.spread, by_node, j);
  }
  const Sparse reordered = order.inverse() * A * order;
  factor<Real>(SparseRows(reordered), set);
  return set;
}

}  // namespace

Vec3 BoundaryMotion::at(const Vec3& X, double time_s) const {
  const double s = curve.at(time_s, duration);
  const Vec3 arm = X - axis_point;
  return s * translation + Eigen::AngleAxisd(s * angle, axis) * arm - arm;
}

template <class Real>
EssentialBoundaryOf<Real> makeEssentialBoundary(const EssentialNodes& essential, const std::vector<double>& mass) {
  EssentialBoundaryOf<Real> boundary;
  boundary.motions = essential.motions;
  std::map<std::vector<int>, std::array<Real, 4>> sets;  // rows -> components
  for (int c = 0; c < 3; ++c) {
    std::vector<int> rows;
    for (int k = 0; k < static_cast<int>(essential.nodes.size()); ++k)
      if (essential.nodes[k].boundary[c] >= 0) rows.push_back(k);
    if (!rows.empty()) sets[rows][c] = 1;
  }
  for (const auto& [rows, mask] : sets) boundary.sets.push_back(makeSet<Real>(rows, mask, essential, mass));
  return boundary;
}

template <class Real>
BoundaryScratchOf<Real> makeBoundaryScratch(const EssentialBoundaryOf<Real>& boundary) {
  BoundaryScratchOf<Real> scratch;
  for (const auto& set : boundary.sets) scratch.rhs.emplace_back(set.node.size());
  scratch.drift = scratch.first = scratch.rhs;
  const std::size_t boundaries = boundary.motions.size();
  scratch.rotation.assign(boundaries, Mat3::Zero());
  scratch.rotation_before = scratch.rotation;
  scratch.shift.assign(boundaries, Vec3::Zero());
  scratch.shift_before = scratch.shift;
  scratch.reaction.resize(boundaries);
  scratch.moves.resize(boundaries);
  for (auto& part : scratch.part_reaction) part.resize(boundaries);
  return scratch;
}

#define PALPATE_INSTANTIATE(Real)                                                                              \
  template EssentialBoundaryOf<Real> makeEssentialBoundary(const EssentialNodes&, const std::vector<double>&); \
  template BoundaryScratchOf<Real> makeBoundaryScratch(const EssentialBoundaryOf<Real>&);
PALPATE_INSTANTIATE(float)
PALPATE_INSTANTIATE(double)
#undef PALPATE_INSTANTIATE

}  // namespace palpate
