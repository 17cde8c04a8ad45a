#include "imaging/signed_field.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "base/parallel_for.h"

namespace palpate {
namespace {

constexpr int margin = 3;      // cells around the surface
constexpr double band = 3;     // cells: further off the distance is cut off
constexpr int block_size = 8;  // nodes along a side of the blocks that are asked first; a power of two

// A block without surface nearby is on one side as a whole where the winding number at its centre is at least so far
// from 1/2 (Harnack: a harmonic function can't come back from there within half its free ball).
constexpr double sure_winding = 0.42;
// The distance counts in full where the winding number is this far from 1/2, and fades to 0 at 1/2: so gaps are closed
// smoothly.
constexpr double full_winding = 0.25;

// Nodes nearer to the surface than this many cells count as on it.
constexpr double on_surface = 1e-4;
// Winding number on a face, the mean of both sides: 1/2 where one of them is outside, 1 where none is.
constexpr double inner_wall = 0.75;

/// Fills a cubic block of nodes with its corner at `low`.
class Blocks {
 public:
  Blocks(const SurfaceTree& surface, SampledField& field) : surface_(surface), field_(field) {}

  void fill(const std::array<int, 3>& low, int size) {
    std::array<int, 3> end{};
    for (int a = 0; a < 3; ++a) {
      end[a] = std::min(low[a] + size, field_.count[a]);
      if (low[a] >= end[a]) return;
    }
    const Vec3 first = at(low), last = at({end[0] - 1, end[1] - 1, end[2] - 1});
    const Vec3 centre = 0.5 * (first + last);
    const double radius = 0.5 * (last - first).norm(), reach = band * field_.cell;
    const double free = 2 * radius + reach;
    const auto foot = surface_.closest(centre, free);
    if (size == 1) {
      const double distance = std::min(foot.triangle < 0 ? reach : foot.distance, reach);
      if (distance < on_surface * field_.cell) {
        // Either side would do, but not specks of both; a wall between two parts that touch is inside.
        const Vec3 off = 0.01 * field_.cell * areaVector(surface_.surface(), foot.triangle).stableNormalized();
        const double both = 0.5 * (surface_.windingNumber(centre + off) + surface_.windingNumber(centre - off));
        value(low) = (both > inner_wall ? -on_surface : on_surface) * field_.cell;
        return;
      }
      const double w = surface_.windingNumber(centre);
      value(low) = distance * std::clamp((0.5 - w) / full_winding, -1.0, 1.0);
      return;
    }
    if (foot.triangle < 0) {
      const double w = surface_.windingNumber(centre);
      if (std::abs(w - 0.5) > sure_winding) {
        for (int k = low[2]; k < end[2]; ++k)
          for (int j = low[1]; j < end[1]; ++j)
            for (int i = low[0]; i < end[0]; ++i) value({i, j, k}) = w > 0.5 ? -reach : reach;
        return;
      }
    }
    const int half = size / 2;
    for (int part = 0; part < 8; ++part)
      fill({low[0] + half * (part % 2), low[1] + half * (part / 2 % 2), low[2] + half * (part / 4)}, half);
  }

 private:
  Vec3 at(const std::array<int, 3>& n) const { return field_.position(field_.node(n[0], n[1], n[2])); }
  double& value(const std::array<int, 3>& n) { return field_.value[field_.node(n[0], n[1], n[2])]; }

  const SurfaceTree& surface_;
  SampledField& field_;
};

/// Numbers the regions of nodes on one side, joined along the axes; those of the other side are -1.
std::vector<int> regionsOf(const SampledField& field, bool inner, std::vector<int>& size, std::vector<char>& on_box) {
  const auto& [nx, ny, nz] = field.count;
  std::vector<int> region(field.value.size(), -1), open;
  for (int seed = 0; seed < static_cast<int>(field.value.size()); ++seed) {
    if (region[seed] >= 0 || (field.value[seed] < 0) != inner) continue;
    const int number = static_cast<int>(size.size());
    size.push_back(0);
    on_box.push_back(0);
    region[seed] = number;
    open.assign(1, seed);
    while (!open.empty()) {
      const int n = open.back();
      open.pop_back();
      ++size[number];
      const int i = n % nx, j = n / nx % ny, k = n / nx / ny;
      if (field.onBox(i, j, k)) on_box[number] = 1;
      const auto visit = [&](bool there, int m) {
        if (!there || region[m] >= 0 || (field.value[m] < 0) != inner) return;
        region[m] = number;
        open.push_back(m);
      };
      visit(i > 0, n - 1), visit(i + 1 < nx, n + 1);
      visit(j > 0, n - nx), visit(j + 1 < ny, n + nx);
      visit(k > 0, n - nx * ny), visit(k + 1 < nz, n + nx * ny);
    }
  }
  return region;
}

}  // namespace

double fieldNodes(const Box3& box, double cell) {
  double nodes = 1;
  for (int a = 0; a < 3; ++a) nodes *= std::floor(box.sizes()[a] / cell) + 2 + 2 * margin;
  return nodes;
}

SampledField signedField(const SurfaceTree& surface, double cell, const Share& progress) {
  const Box3 box = boundingBox(surface.surface());
  SampledField field{box.min() - Vec3::Constant(margin * cell), cell};
  for (int a = 0; a < 3; ++a) field.count[a] = static_cast<int>(std::floor(box.sizes()[a] / cell)) + 2 + 2 * margin;
  field.value.assign(static_cast<std::size_t>(field.count[0]) * field.count[1] * field.count[2], 0);
  std::array<int, 3> blocks{};
  for (int a = 0; a < 3; ++a) blocks[a] = (field.count[a] + block_size - 1) / block_size;
  const int count = blocks[0] * blocks[1] * blocks[2];
  Blocks filler(surface, field);
  // In turns, so that progress and an interruption come through.
  const int turns = std::clamp(count / 64, 1, 20);
  for (int turn = 0; turn < turns; ++turn) {
    const int from = static_cast<int>(static_cast<long long>(count) * turn / turns);
    const int to = static_cast<int>(static_cast<long long>(count) * (turn + 1) / turns);
    parallelFor(
        to - from,
        [&](int begin, int end) {
          for (int b = from + begin; b < from + end; ++b)
            filler.fill({block_size * (b % blocks[0]), block_size * (b / blocks[0] % blocks[1]),
                         block_size * (b / blocks[0] / blocks[1])},
                        block_size);
        },
        4);
    if (progress) progress((turn + 1.0) / turns);
  }
  // The winding number of a large opening may reach the box: the body ends before it.
  const auto& [nx, ny, nz] = field.count;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        if (field.onBox(i, j, k)) {
          double& value = field.value[field.node(i, j, k)];
          value = std::max(value, 0.01 * cell);
        }
  return field;
}

SmallRegions removeSmallRegions(SampledField& field, double least_part, double least_hollow) {
  SmallRegions removed;
  for (const bool inner : {true, false}) {
    std::vector<int> size;
    std::vector<char> on_box;
    const std::vector<int> region = regionsOf(field, inner, size, on_box);
    std::vector<int> body;
    if (inner) body = size;
    int largest = 0, all = 0;
    if (inner) {
      for (const int s : size) largest = std::max(largest, s), all += s;
    } else {
      for (std::size_t n = 0; n < region.size(); ++n) largest += region[n] < 0 ? 1 : 0;  // the body's nodes
    }
    std::vector<char> goes(size.size(), 0);
    for (std::size_t r = 0; r < size.size(); ++r) {
      goes[r] = inner ? size[r] < least_part * largest : !on_box[r] && size[r] < least_hollow * largest;
      if (!goes[r]) continue;
      ++(inner ? removed.parts : removed.hollows);
      if (inner) removed.part_share += static_cast<double>(size[r]) / all;
    }
    for (std::size_t n = 0; n < region.size(); ++n) {
      if (region[n] < 0 || !goes[region[n]]) continue;
      // 0 counts as outside.
      const double least = 1e-3 * field.cell;
      field.value[n] = inner ? std::max(std::abs(field.value[n]), least) : -std::max(std::abs(field.value[n]), least);
    }
  }
  return removed;
}

}  // namespace palpate
