#include "imaging/membership.h"

#include <algorithm>
#include <cmath>

#include "base/key.h"

namespace palpate {
namespace {

bool isKnown(const Membership& m, const Vec3& index) {
  if (!m.share.grid.holds(index)) return false;
  const auto at = [&](int a) { return static_cast<int>(std::lround(index[a])); };
  return !m.mask || (*m.mask)(at(0), at(1), at(2)) != 0;
}

}  // namespace

double meanShare(const Membership& membership, const std::array<Vec3, 4>& corners) {
  constexpr int most = 12;  // lattice points along an edge: cells of more than a dozen voxels average well enough
  std::array<Vec3, 4> index;
  double longest = 0;
  for (std::size_t a = 0; a < 4; ++a) {
    index[a] = membership.share.grid.indexOf(corners[a]);
    for (std::size_t b = 0; b < a; ++b) longest = std::max(longest, (index[a] - index[b]).norm());
  }
  const int n = std::clamp(static_cast<int>(std::ceil(longest)), 2, most);
  double sum = 0;
  int count = 0;
  // Barycentric (i + 1/4, j + 1/4, k + 1/4, l + 1/4) / n with i + j + k + l = n - 1: n (n + 1) (n + 2) / 6 points.
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j)
      for (int k = 0; i + j + k < n; ++k) {
        const double l = n - 1 - i - j - k + 0.25;
        const Vec3 at = ((i + 0.25) * index[0] + (j + 0.25) * index[1] + (k + 0.25) * index[2] + l * index[3]) / n;
        if (!isKnown(membership, at)) continue;
        sum += linearValue(membership.share, at);
        ++count;
      }
  const Vec3 middle = (index[0] + index[1] + index[2] + index[3]) / 4;
  const double mean = count > 0 ? sum / count : nearestValue(membership.share, middle);
  return std::clamp(mean, 0.0, 1.0);
}

std::optional<double> shareAt(const Membership& membership, const Vec3& x) {
  const Vec3 index = membership.share.grid.indexOf(x);
  if (!isKnown(membership, index)) return {};
  return std::clamp(static_cast<double>(linearValue(membership.share, index)), 0.0, 1.0);
}

std::string identityOf(const Membership& m) {
  ByteKey key;
  key.add(m.share.grid.size, m.share.grid.origin);
  for (int a = 0; a < 3; ++a) key.add(Vec3(m.share.grid.axes.col(a)));
  const auto bytes = [](const auto& values) {
    return std::string_view(reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]);
  };
  key.add(fnv1a(bytes(m.share.value)), m.mask ? fnv1a(bytes(m.mask->value)) : 0);
  return key.bytes();
}

}  // namespace palpate
