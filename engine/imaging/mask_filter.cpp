#include "imaging/mask_filter.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "base/parallel_for.h"

namespace palpate {
namespace {

/// Voxels of equal value beside each other in a row.
struct Run {
  int begin, end;      // i
  std::int32_t first;  // the run, this or an earlier one, that it is known to be joined with
};

/// The first of the runs that are joined with this one.
std::int32_t firstOf(std::vector<Run>& run, std::int32_t r) {
  const auto at = [&](std::int32_t n) -> Run& { return run[static_cast<std::size_t>(n)]; };
  while (at(r).first != r) r = at(r).first = at(at(r).first).first;
  return r;
}

/// Joins the runs of two rows that touch. @param a, b  the first run of each row, and the one behind its last
void joinRows(std::vector<Run>& run, std::pair<std::int32_t, std::int32_t> a, std::pair<std::int32_t, std::int32_t> b) {
  while (a.first < a.second && b.first < b.second) {
    const Run &p = run[static_cast<std::size_t>(a.first)], &q = run[static_cast<std::size_t>(b.first)];
    const bool p_ends_first = p.end < q.end;
    if (p.begin < q.end && q.begin < p.end) {
      const std::int32_t u = firstOf(run, a.first), v = firstOf(run, b.first);
      run[static_cast<std::size_t>(std::max(u, v))].first = std::min(u, v);
    }
    ++(p_ends_first ? a.first : b.first);
  }
}

/// Numbers all voxels of a value, those joined across faces alike, from 1 on in the order of their first voxels; the
/// others get 0. Returns the counts of voxels, part by part.
std::vector<std::size_t> numberParts(const Mask& mask, std::uint8_t of, std::vector<std::int32_t>& number) {
  const auto [nx, ny, nz] = mask.grid.size;
  std::vector<Run> run;
  std::vector<std::int32_t> row_begin{0};  // the first run of each row; (ny * nz + 1)
  for (int row = 0; row < ny * nz; ++row) {
    const std::uint8_t* value = mask.value.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(nx);
    for (int i = 0; i < nx; ++i) {
      if (value[i] != of) continue;
      const int begin = i;
      while (i < nx && value[i] == of) ++i;
      run.push_back({begin, i, static_cast<std::int32_t>(run.size())});
    }
    row_begin.push_back(static_cast<std::int32_t>(run.size()));
    const auto runsOf = [&](int r) {
      return std::pair(row_begin[static_cast<std::size_t>(r)], row_begin[static_cast<std::size_t>(r) + 1]);
    };
    if (row % ny > 0) joinRows(run, runsOf(row - 1), runsOf(row));
    if (row >= ny) joinRows(run, runsOf(row - ny), runsOf(row));
  }
  std::vector<std::size_t> counts;
  std::vector<std::int32_t> name(run.size());
  for (std::size_t r = 0; r < run.size(); ++r) {
    const auto first = static_cast<std::size_t>(firstOf(run, static_cast<std::int32_t>(r)));
    if (first == r) {
      counts.push_back(0);
      name[r] = static_cast<std::int32_t>(counts.size());
    }
    name[r] = name[first];
    counts[static_cast<std::size_t>(name[r]) - 1] += static_cast<std::size_t>(run[r].end - run[r].begin);
  }
  number.assign(mask.value.size(), 0);
  for (std::size_t row = 0; row + 1 < row_begin.size(); ++row)
    for (auto r = static_cast<std::size_t>(row_begin[row]); r < static_cast<std::size_t>(row_begin[row + 1]); ++r)
      std::fill_n(number.begin() + static_cast<std::ptrdiff_t>(row) * nx + run[r].begin, run[r].end - run[r].begin,
                  name[r]);
  return counts;
}

/// Calls each(start, stride, count) for all rows of voxels along an axis, on all cores.
template <class Each>
void forRows(const ImageGrid& grid, int axis, Each each) {
  const int b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
  std::array<int, 3> step{0, 0, 0};
  step[static_cast<std::size_t>(axis)] = 1;
  const std::size_t stride = grid.size[static_cast<std::size_t>(axis)] > 1 ? grid.at(step[0], step[1], step[2]) : 1;
  parallelFor(
      grid.size[static_cast<std::size_t>(c)],
      [&](int first, int last) {
        for (int q = first; q < last; ++q)
          for (int p = 0; p < grid.size[static_cast<std::size_t>(b)]; ++p) {
            std::array<int, 3> at{0, 0, 0};
            at[static_cast<std::size_t>(b)] = p;
            at[static_cast<std::size_t>(c)] = q;
            each(grid.at(at[0], at[1], at[2]), stride, grid.size[static_cast<std::size_t>(axis)]);
          }
      },
      1);
}

constexpr float far_away = std::numeric_limits<float>::max() / 4;  // m^2

/// The lower envelope of parabolas f[q] + (h (p - q))^2 along a row: squared distances, in place.
void distanceAlongRow(float* value, std::size_t stride, int count, double h) {
  std::vector<float> f(static_cast<std::size_t>(count));
  std::vector<int> site(static_cast<std::size_t>(count));
  std::vector<double> border(static_cast<std::size_t>(count) + 1);
  for (int p = 0; p < count; ++p) f[static_cast<std::size_t>(p)] = value[static_cast<std::size_t>(p) * stride];
  int last = -1;
  const double h2 = h * h;
  for (int q = 0; q < count; ++q) {
    if (f[static_cast<std::size_t>(q)] >= far_away) continue;
    double s = -std::numeric_limits<double>::infinity();
    while (last >= 0) {
      const int v = site[static_cast<std::size_t>(last)];
      s = ((f[static_cast<std::size_t>(q)] + h2 * q * q) - (f[static_cast<std::size_t>(v)] + h2 * v * v)) /
          (2 * h2 * (q - v));
      if (s > border[static_cast<std::size_t>(last)]) break;
      --last;
    }
    if (last < 0) s = -std::numeric_limits<double>::infinity();
    ++last;
    site[static_cast<std::size_t>(last)] = q;
    border[static_cast<std::size_t>(last)] = s;
  }
  if (last < 0) return;
  int k = 0;
  for (int p = 0; p < count; ++p) {
    while (k < last && border[static_cast<std::size_t>(k) + 1] < p) ++k;
    const int v = site[static_cast<std::size_t>(k)];
    value[static_cast<std::size_t>(p) * stride] =
        static_cast<float>(h2 * (p - v) * (p - v)) + f[static_cast<std::size_t>(v)];
  }
}

/// Squared distances to the voxels of value `of`, m^2.
Image squaredDistance(const Mask& mask, std::uint8_t of) {
  Image d(mask.grid, far_away);
  for (std::size_t v = 0; v < mask.value.size(); ++v)
    if (mask.value[v] == of) d.value[v] = 0;
  const Vec3 h = mask.grid.spacing();
  for (int axis = 0; axis < 3; ++axis)
    forRows(mask.grid, axis, [&](std::size_t start, std::size_t stride, int count) {
      distanceAlongRow(&d.value[start], stride, count, h[axis]);
    });
  return d;
}

}  // namespace

Mask keepLargestPart(const Mask& mask, MaskParts& parts) {
  parts = {};
  Mask kept(mask.grid);
  std::vector<std::int32_t> number;
  const auto counts = numberParts(mask, 1, number);
  parts.part_count = static_cast<int>(counts.size());
  if (counts.empty()) return kept;
  const auto largest = static_cast<std::int32_t>(1 + (std::max_element(counts.begin(), counts.end()) - counts.begin()));
  for (std::size_t v = 0; v < number.size(); ++v) {
    kept.value[v] = number[v] == largest;
    parts.dropped_voxels += mask.value[v] && number[v] != largest;
  }
  // Of what is outside, only parts that reach the image's edge are.
  const auto outside_counts = numberParts(kept, 0, number);
  std::vector<char> open(outside_counts.size() + 1, 0);
  const auto& size = mask.grid.size;
  forVoxels(mask.grid, [&](int i, int j, int k) {
    if (i == 0 || j == 0 || k == 0 || i == size[0] - 1 || j == size[1] - 1 || k == size[2] - 1)
      open[static_cast<std::size_t>(number[mask.grid.at(i, j, k)])] = 1;
  });
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] != 0 && !open[static_cast<std::size_t>(number[v])]) {
      kept.value[v] = 1;
      ++parts.filled_voxels;
    }
  return kept;
}

Mask withoutTails(const Mask& mask, double radius, double reach) {
  const Mask near = croppedTo(mask, 0);
  const Image to_outside = squaredDistance(near, 0);
  const double half = 0.5 * std::cbrt(mask.grid.voxelVolume());
  Mask core(near.grid);  // the ball's middles
  for (std::size_t v = 0; v < core.value.size(); ++v)
    core.value[v] = std::sqrt(static_cast<double>(to_outside.value[v])) - half >= radius;
  const Image to_core = squaredDistance(core, 1);
  const Vec3 low = mask.grid.indexOf(near.grid.origin);
  Mask kept = mask;
  forVoxels(near.grid, [&](int i, int j, int k) {
    if (near(i, j, k) && std::sqrt(static_cast<double>(to_core(i, j, k))) > radius + half + reach)
      kept(i + static_cast<int>(std::lround(low.x())), j + static_cast<int>(std::lround(low.y())),
           k + static_cast<int>(std::lround(low.z()))) = 0;
  });
  return kept;
}

Image signedDistance(const Mask& mask) {
  Image outside = squaredDistance(mask, 1);
  const Image inside = squaredDistance(mask, 0);
  const auto half = static_cast<float>(0.5 * std::cbrt(mask.grid.voxelVolume()));
  for (std::size_t v = 0; v < outside.value.size(); ++v)
    outside.value[v] = mask.value[v] ? half - std::sqrt(inside.value[v]) : std::sqrt(outside.value[v]) - half;
  return outside;
}

void smooth(Image& image, double sigma) {
  const Vec3 h = image.grid.spacing();
  for (int axis = 0; axis < 3; ++axis) {
    const double s = sigma / h[axis];  // voxels
    const int reach = static_cast<int>(std::ceil(3 * s));
    if (s < 0.1 || image.grid.size[static_cast<std::size_t>(axis)] < 2) continue;
    std::vector<float> weight;
    float sum = 0;
    for (int d = -reach; d <= reach; ++d)
      sum += weight.emplace_back(static_cast<float>(std::exp(-d * d / (2 * s * s))));
    for (float& w : weight) w /= sum;
    forRows(image.grid, axis, [&](std::size_t start, std::size_t stride, int count) {
      std::vector<float> padded(static_cast<std::size_t>(count + 2 * reach));
      for (int p = 0; p < count + 2 * reach; ++p)
        padded[static_cast<std::size_t>(p)] =
            image.value[start + stride * static_cast<std::size_t>(std::clamp(p - reach, 0, count - 1))];
      for (int p = 0; p < count; ++p) {
        float total = 0;
        for (std::size_t d = 0; d < weight.size(); ++d) total += weight[d] * padded[static_cast<std::size_t>(p) + d];
        image.value[start + stride * static_cast<std::size_t>(p)] = total;
      }
    });
  }
}

Mask croppedTo(const Mask& mask, double margin) {
  std::array<int, 3> low = mask.grid.size, high{-1, -1, -1};
  forVoxels(mask.grid, [&](int i, int j, int k) {
    const int at[3] = {i, j, k};
    for (std::size_t a = 0; a < 3 && mask(i, j, k); ++a) {
      low[a] = std::min(low[a], at[a]);
      high[a] = std::max(high[a], at[a]);
    }
  });
  const Vec3 h = mask.grid.spacing();
  std::array<int, 3> size{};
  for (std::size_t a = 0; a < 3; ++a) {
    const int more = 1 + static_cast<int>(std::ceil(margin / h[static_cast<Eigen::Index>(a)]));
    low[a] -= more;
    size[a] = std::max(1, high[a] + more - low[a] + 1);
  }
  Mask cropped(ImageGrid(size, mask.grid.axes, mask.grid.worldOf(low[0], low[1], low[2])));
  forVoxels(cropped.grid, [&](int i, int j, int k) {
    const int x = i + low[0], y = j + low[1], z = k + low[2];
    if (x >= 0 && y >= 0 && z >= 0 && x < mask.grid.size[0] && y < mask.grid.size[1] && z < mask.grid.size[2])
      cropped(i, j, k) = mask(x, y, z);
  });
  return cropped;
}

}  // namespace palpate
