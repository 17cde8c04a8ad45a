#include "approximation/shape_functions.h"

#include <algorithm>
#include <bit>

#include "base/parallel_for.h"

namespace palpate {

ShapeTable shapeFunctions(const std::vector<Vec3>& points, const std::vector<Vec3>& X,
                          const std::vector<double>& radius, const Neighbours& neighbours, const MmlsOptions& options,
                          std::vector<InadmissibleSupport>& failed, const SupportGroups& groups, const KnownPart& known,
                          Wanted wanted) {
  const bool gradients = wanted == Wanted::Gradients;
  const int rows = static_cast<int>(points.size());
  struct Row {
    std::vector<int> node;
    std::vector<double> N;
    std::vector<Vec3> gradN;
  };
  std::vector<Row> row(rows);
  std::vector<InadmissibleSupport> bad(rows);

  parallelFor(rows, [&](int begin, int end) {
    Mmls<3> mmls(options);
    std::vector<Vec3> support_X;
    std::vector<double> support_radius;
    std::vector<std::uint8_t> pinned;
    for (int r = begin; r < end; ++r) {
      if (known.rows != nullptr &&
          known.rows->copy(known.part, points[r], groups.row.empty() ? 0 : groups.row[r], row[r].node, row[r].N))
        continue;
      neighbours.find(points[r], row[r].node);
      if (!groups.row.empty()) std::erase_if(row[r].node, [&](int j) { return (groups.node[j] & groups.row[r]) == 0; });
      support_X.clear();
      support_radius.clear();
      pinned.clear();
      for (int j : row[r].node) {
        support_X.push_back(X[j]);
        support_radius.push_back(radius[j]);
        if (!groups.row.empty()) pinned.push_back(std::popcount(groups.node[j]) > 1);
      }
      const int count = static_cast<int>(row[r].node.size());
      if (mmls.evaluate(points[r], support_X.data(), support_radius.data(), count,
                        pinned.empty() ? nullptr : pinned.data(), gradients) &&
          AdmissibilityLimits{}.admit(mmls.quality())) {
        row[r].N = mmls.N();
        if (gradients) row[r].gradN = mmls.gradN();
      } else {
        bad[r] = {r, count, mmls.quality()};
        row[r].node.clear();
      }
    }
  });

  ShapeTable table;
  table.begin.assign(1, 0);
  failed.clear();
  for (int r = 0; r < rows; ++r) {
    if (bad[r].row >= 0) failed.push_back(bad[r]);
    table.begin.push_back(table.begin.back() + static_cast<int>(row[r].node.size()));
  }
  table.node.resize(table.begin.back());
  table.N.resize(table.begin.back());
  if (gradients) table.gradN.resize(table.begin.back());
  parallelFor(rows, [&](int first, int last) {
    for (int r = first; r < last; ++r) {
      std::copy(row[r].node.begin(), row[r].node.end(), table.node.begin() + table.begin[r]);
      std::copy(row[r].N.begin(), row[r].N.end(), table.N.begin() + table.begin[r]);
      if (gradients) std::copy(row[r].gradN.begin(), row[r].gradN.end(), table.gradN.begin() + table.begin[r]);
      row[r] = {};
    }
  });
  return table;
}

std::vector<int> enlargeSupports(const std::vector<Vec3>& points, const std::vector<InadmissibleSupport>& failed,
                                 const Neighbours& neighbours, std::vector<double>& radius,
                                 const SupportGroups& groups) {
  constexpr int grown = 8;
  std::vector<int> changed;
  for (const auto& f : failed) {
    std::vector<int> near;
    for (int looked = grown; static_cast<int>(near.size()) < grown; looked *= 2) {
      near = neighbours.nearest(points[f.row], looked);
      const bool all = near.size() == radius.size();
      if (!groups.row.empty()) std::erase_if(near, [&](int j) { return (groups.node[j] & groups.row[f.row]) == 0; });
      if (all) break;
    }
    near.resize(std::min<std::size_t>(near.size(), grown));
    changed.insert(changed.end(), near.begin(), near.end());
  }
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  for (int j : changed) radius[j] *= 1.15;
  return changed;
}

}  // namespace palpate
