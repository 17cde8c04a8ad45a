#include "approximation/known_rows.h"

#include <cstring>

#include "base/place_hash.h"

namespace palpate {
namespace {

bool sameBits(const Vec3& a, const Vec3& b) { return std::memcmp(a.data(), b.data(), sizeof(double) * 3) == 0; }

std::uint64_t groupOf(const std::vector<std::uint64_t>& group, std::size_t k) { return group.empty() ? 0 : group[k]; }

}  // namespace

KnownRows::Part::Part(const std::vector<Vec3>& its_at, const std::vector<std::uint64_t>& its_group,
                      const ShapeTable& its_rows)
    : at(its_at), group(its_group), rows(its_rows) {
  row.reserve(at.size());
  for (std::size_t r = 0; r < at.size(); ++r) row.try_emplace(hashOf(at[r]), static_cast<int>(r));
}

int KnownRows::Part::find(const Vec3& x) const {
  const auto found = row.find(hashOf(x));
  return found != row.end() && sameBits(at[static_cast<std::size_t>(found->second)], x) ? found->second : -1;
}

RowsAtHand::Changed RowsAtHand::compare(const KnownRows& known, const std::vector<int>& number,
                                        const std::vector<Vec3>& X, const std::vector<double>& radius,
                                        const std::vector<std::uint64_t>& group, std::vector<int>& now) {
  now.assign(known.number.size(), -1);
  Changed changed;
  std::size_t k = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    while (k < known.number.size() && known.number[k] < number[i]) ++k;
    if (k < known.number.size() && known.number[k] == number[i] && sameBits(known.X[k], X[i]) &&
        known.radius[k] == radius[i] && groupOf(known.group, k) == groupOf(group, i)) {
      now[k] = static_cast<int>(i);
    } else {
      changed.X.push_back(X[i]);
      changed.radius.push_back(radius[i]);
    }
  }
  return changed;
}

RowsAtHand::RowsAtHand(const KnownRows& known, const std::vector<int>& number, const std::vector<Vec3>& X,
                       const std::vector<double>& radius, const std::vector<std::uint64_t>& group)
    : known_(known), changed_(compare(known, number, X, radius, group, now_)), near_(changed_.X, changed_.radius) {}

bool RowsAtHand::copy(std::size_t part, const Vec3& at, std::uint64_t group, std::vector<int>& node,
                      std::vector<double>& N) const {
  const KnownRows::Part& from = known_.part[part];
  const int r = from.find(at);
  if (r < 0 || groupOf(from.group, static_cast<std::size_t>(r)) != group) return false;
  const int begin = from.rows.begin[r], end = from.rows.begin[r + 1];
  if (begin == end) return false;
  for (int e = begin; e < end; ++e)
    if (now_[from.rows.node[e]] < 0) return false;
  near_.find(at, node);
  const bool is_same = node.empty();
  node.clear();
  if (!is_same) return false;
  for (int e = begin; e < end; ++e) node.push_back(now_[from.rows.node[e]]);
  N.assign(from.rows.N.begin() + begin, from.rows.N.begin() + end);
  return true;
}

}  // namespace palpate
