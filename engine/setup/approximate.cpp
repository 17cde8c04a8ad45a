#include "setup/approximate.h"

#include <algorithm>
#include <optional>
#include <tuple>

#include "approximation/shape_functions.h"
#include "base/place_hash.h"
#include "discretization/cells/adaptive_quadrature.h"
#include "discretization/cells/cell_pairs.h"
#include "discretization/gradients/gradient_energy.h"
#include "scene/scene_messages.h"

namespace palpate {
namespace {

constexpr int max_enlargements = 8;  // by 1.15 each: a support radius grows at most threefold
/// Beside narrow air what is not carried then follows a point. (A block with slits under a ball of 12 mm: 9 % too soft,
/// with 2 as well; with 8 22 %.)
constexpr int enlargements_by_air = 4;

/// What rows of nodes depend on besides their places and radii (node_count), or nothing: groups, cells beside gaps, and
/// whether they take part.
std::vector<std::uint64_t> marksOf(const std::vector<std::uint64_t>& groups, const Sight& sight,
                                   const std::vector<Vec3>& X) {
  std::vector<std::uint64_t> mark = groups;
  if (!sight.joined.empty() || !sight.lonely.empty()) mark.resize(X.size());
  for (std::size_t i = 0; i < sight.joined.size(); ++i)
    for (const int j : sight.joined[i]) mark[i] = hashOf(X[j], mark[i]);
  for (std::size_t i = 0; i < sight.lonely.size(); ++i)
    if (sight.lonely[i] != 0) mark[i] = ~mark[i];
  return mark;
}

InputError unsupportedAt(const Scene& scene, const Vec3& point, int node_count, const SurfaceGaps& gaps) {
  const bool by_air = gaps.areNear(point, 2 * scene.discretization.spacing);
  return {placeOf(scene, by_air ? "discretization.spacing" : "discretization.support_factor"),
          "the support of the point at " + coordinates(point) + " is inadmissible (" + std::to_string(node_count) +
              " nodes)" + (by_air ? ", as supports end at the narrow air beside it" : ""),
          by_air
              ? "give discretization.spacing, no wider than the air and the tissue beside it, or close the air in the "
                "surface"
              : "raise discretization.support_factor or lower discretization.spacing"};
}

}  // namespace

IntegrationPoints choosePoints(const Scene& scene, const std::vector<Vec3>& X, const BackgroundCells& cells,
                               const std::vector<int>& cell_material, std::vector<double>& radius,
                               const double* pair_moment) {
  const QuadratureSpec& spec = scene.discretization.quadrature;
  if (spec.cells_per_point != 1 && (spec.points_per_cell != 1 || spec.accuracy > 0))
    throw InputError(placeOf(scene, "discretization.cells_per_point"),
                     "cells can share a point only where each has one", "leave one of the two out");
  if (spec.cells_per_point != 1)
    return makePairedPoints(X, cells,
                            pair_moment ? pairCellsUpTo(X, cells, cell_material, *pair_moment)
                                        : pairCells(X, cells, cell_material, spec.cells_per_point));
  if (spec.accuracy == 0) return makeIntegrationPoints(X, cells.cells, cells.volume, spec.points_per_cell);
  AdaptiveOptions options;
  options.accuracy = spec.accuracy;
  options.points_per_cell = spec.points_per_cell;
  options.division = spec.division;
  options.max_depth = spec.max_depth;
  for (int attempt = 0;; ++attempt) {
    const Neighbours neighbours(X, radius);
    try {
      auto adaptive = makeAdaptivePoints(
          X, cells.cells, cells.volume, options,
          GradientEnergy(X, radius, neighbours, {scene.discretization.basis_degree, scene.discretization.mmls_weight}));
      if (adaptive.not_finite.empty() || attempt == max_enlargements) return std::move(adaptive.points);
      std::vector<InadmissibleSupport> failed;
      for (int k = 0; k < static_cast<int>(adaptive.not_finite.size()); ++k) {
        failed.emplace_back();
        failed.back().row = k;
      }
      std::vector<double> enlarged = radius;
      enlargeSupports(adaptive.not_finite, failed, neighbours, enlarged);
      radius = std::move(enlarged);
    } catch (const InputError& error) {
      throw InputError(placeOf(scene, "discretization.quadrature_accuracy"), error.what(), "");
    }
  }
}

SurfaceGaps gapsOf(const Scene& scene, const TriangleSurface& skin, const SurfaceTree& body) {
  constexpr double widest = 2;  // support radii, which grow where they must
  return {skin, body, widest * scene.discretization.support_factor * scene.discretization.spacing};
}

std::vector<std::uint8_t> lonelyNodes(const ShapeTable& rows, std::size_t node_count) {
  std::vector<std::uint8_t> lonely(node_count, 1);
  for (const int j : rows.node) lonely[j] = 0;
  if (std::count(lonely.begin(), lonely.end(), 1) == 0) lonely.clear();
  return lonely;
}

Sight::Sight(const SurfaceGaps& its_gaps, std::size_t node_count, const std::vector<std::array<int, 4>>& cells)
    : gaps(its_gaps) {
  if (gaps.empty()) return;
  joined.resize(node_count);
  for (const auto& cell : cells)
    for (const int i : cell) joined[i].insert(joined[i].end(), cell.begin(), cell.end());
  for (std::vector<int>& others : joined) {
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
  }
}

SupportLimit Sight::limit() const {
  return [this](const Vec3& x, const std::vector<Vec3>& nodes, std::vector<int>& support) {
    constexpr std::size_t least = 4;  // nodes that can carry anything (8 and 16: the same organs open)
    if (!lonely.empty()) std::erase_if(support, [&](int j) { return lonely[j] != 0; });
    if (support.empty() || gaps.empty()) return;
    const auto distance = [&](int j) { return (nodes[j] - x).norm(); };
    double furthest = 0;
    for (const int j : support) furthest = std::max(furthest, distance(j));
    if (!gaps.areNear(x, furthest)) return;
    const auto seenFrom = [&](const Vec3& eye, const std::vector<int>& anyway) {
      std::vector<int> seen = support;
      std::erase_if(seen, [&](int j) {
        return !std::binary_search(anyway.begin(), anyway.end(), j) && gaps.areBetween(eye, nodes[j]);
      });
      return seen;
    };
    std::vector<int> seen = seenFrom(x, {});
    if (seen.size() < least) {
      const std::vector<int>& near = seen.empty() ? support : seen;
      const int i = *std::min_element(near.begin(), near.end(),
                                      [&](int one, int other) { return distance(one) < distance(other); });
      std::vector<int> followed = seenFrom(nodes[i], {i});
      if (followed.size() < least) followed = seenFrom(nodes[i], joined[i]);
      if (followed.size() > seen.size()) seen = std::move(followed);
    }
    support = std::move(seen);
  };
}

std::vector<InadmissibleSupport> followPoints(const std::vector<Vec3>& at,
                                              const std::vector<InadmissibleSupport>& failed,
                                              const std::vector<Vec3>& point_X, const ShapeTable& points,
                                              const std::function<bool(int, int)>& mayFollow, const SurfaceGaps& gaps,
                                              ShapeTable& table) {
  const auto nearestTo = [&](int row, bool in_sight) {
    const Vec3& x = at[static_cast<std::size_t>(row)];
    int nearest = -1;
    double least2 = std::numeric_limits<double>::infinity();
    for (int q = 0; q < points.rowCount(); ++q) {
      const Vec3& X = point_X[static_cast<std::size_t>(q)];
      const double distance2 = (X - x).squaredNorm();
      if (distance2 >= least2 || points.begin[q] == points.begin[q + 1] || !mayFollow(row, q)) continue;
      if (in_sight && gaps.areBetween(x, X)) continue;
      nearest = q;
      least2 = distance2;
    }
    return nearest;
  };
  std::vector<InadmissibleSupport> left;
  ShapeTable whole;
  whole.begin.assign(1, 0);
  auto next = failed.begin();
  for (int row = 0; row < table.rowCount(); ++row) {
    if (next == failed.end() || next->row != row) {
      whole.append(table, row);
      continue;
    }
    int q = nearestTo(row, true);
    if (q < 0) q = nearestTo(row, false);
    if (q < 0) {
      left.push_back(*next);
      whole.append(table, row);
    } else {
      whole.append(points, q, at[static_cast<std::size_t>(row)] - point_X[static_cast<std::size_t>(q)]);
    }
    ++next;
  }
  if (table.gradN.empty()) whole.gradN.clear();
  table = std::move(whole);
  return left;
}

Approximation approximate(const Scene& scene, const std::vector<Vec3>& X, std::vector<double> radius,
                          const std::vector<Vec3>& point_X, const std::vector<Vec3>& skin_X,
                          const std::vector<Vec3>& facet_X, const std::vector<Vec3>& boundary_X,
                          const SurfaceGaps& gaps, const std::vector<std::array<int, 4>>& cells,
                          const ApproximationGroups& groups, std::vector<Unsupported>* unsupported,
                          const RowMemory* memory) {
  const MmlsOptions options{scene.discretization.basis_degree, scene.discretization.mmls_weight};
  Approximation a;
  Sight sight(gaps, X.size(), cells);
  std::vector<Unsupported> left;
  int first_count = 0;   // nodes
  bool follows = false;  // some row a point's
  const int most = gaps.empty() ? max_enlargements : enlargements_by_air;
  for (int attempt = 0;; ++attempt) {
    const Neighbours neighbours(X, radius, sight.limit());
    const std::tuple<const std::vector<Vec3>*, const std::vector<std::uint64_t>*, ShapeTable*> parts[] = {
        {&point_X, &groups.points, &a.points},
        {&skin_X, &groups.skin, &a.skin},
        {&X, &groups.nodes, &a.nodes},
        {&facet_X, &groups.facets, &a.facets},
        {&boundary_X, &groups.boundary, &a.boundary}};
    bool admissible = true;
    std::vector<double> enlarged = radius;
    std::optional<RowsAtHand> at_hand;
    std::vector<std::uint64_t> mark;  // what rows of a node depend on besides its place and radius
    KnownPart known;
    sight.lonely.clear();
    for (const auto& [at, rows, table] : parts) {
      const bool values = table != &a.points;
      std::vector<InadmissibleSupport> failed;
      *table = shapeFunctions(*at, X, radius, neighbours, options, failed, {groups.of_nodes, *rows}, known,
                              values ? Wanted::Values : Wanted::Gradients);
      if (attempt == most && !gaps.empty() && !failed.empty()) {
        const auto mayFollow = [&](int row, int q) { return rows->empty() || ((*rows)[row] & groups.points[q]) != 0; };
        failed = followPoints(*at, failed, point_X, a.points, mayFollow, gaps, *table);
        follows = true;
      }
      if (!values) {
        if (failed.empty()) sight.lonely = lonelyNodes(a.points, X.size());
        if (memory != nullptr) {
          mark = marksOf(groups.of_nodes, sight, X);
          known.rows = &at_hand.emplace(memory->rows, memory->number, X, radius, mark);
        }
      }
      known.part += values;
      if (failed.empty()) continue;
      admissible = false;
      if (attempt == most) {
        if (left.empty()) first_count = failed.front().support_count;
        for (const auto& f : failed) left.push_back({(*at)[f.row], rows->empty() ? 0 : (*rows)[f.row]});
        continue;
      }
      std::vector<double> mine = radius;
      enlargeSupports(*at, failed, neighbours, mine, {groups.of_nodes, *rows});
      for (std::size_t i = 0; i < mine.size(); ++i) enlarged[i] = std::max(enlarged[i], mine[i]);
    }
    if (!left.empty() && unsupported == nullptr) throw unsupportedAt(scene, left.front().at, first_count, gaps);
    at_hand.reset();
    if (memory != nullptr) memory->rows = {};
    if (memory != nullptr && !follows) {  // rows that follow others depend on them, too
      KnownRows& found = memory->rows = {memory->number, X, radius, mark, {}};
      auto part = found.part.begin();
      for (const auto& [at, rows, table] : parts)
        if (table != &a.points) *part++ = {*at, *rows, *table};
    }
    if (admissible || attempt == most) break;
    radius = enlarged;
  }
  if (unsupported != nullptr) *unsupported = std::move(left);
  a.radius = radius;
  return a;
}

}  // namespace palpate
