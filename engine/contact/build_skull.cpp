#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/parallel_for.h"
#include "contact/skull.h"

namespace palpate {
namespace {

/// A pressure of one Young's modulus presses the skin so deep into the skull, m: a tenth of what is promised, at ten
/// times the pressure of a brain's weight.
constexpr double layer_depth = 1e-5;

/// Apart from each other, per spacing of the nodes, are the points that touch.
constexpr double point_distance = 0.5;

constexpr double cells_per_spacing = 3;
constexpr double largest_cell = 2e-3;  // m: the distance to a ball of 30 mm is within 0.03 mm then
constexpr double most_nodes = 4e6;     // of the grid: 16 MB

/// Vertices of the skin that are no nearer to each other than `apart`, in their order.
std::vector<int> thinned(const std::vector<Vec3>& X, double apart) {
  using Cell = std::array<int, 3>;
  std::map<Cell, std::vector<int>> kept;
  std::vector<int> result;
  for (int v = 0; v < static_cast<int>(X.size()); ++v) {
    Cell at{};
    for (int a = 0; a < 3; ++a) at[static_cast<std::size_t>(a)] = static_cast<int>(std::floor(X[v][a] / apart));
    bool free = true;
    for (int n = 0; n < 27 && free; ++n) {
      const auto cell = kept.find({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1});
      if (cell == kept.end()) continue;
      for (const int w : cell->second) free = free && (X[w] - X[v]).squaredNorm() >= apart * apart;
    }
    if (!free) continue;
    kept[at].push_back(v);
    result.push_back(v);
  }
  return result;
}

/// Shares the skin's area out to the nearest points.
std::vector<float> areasOf(const SkinModel& skin, const std::vector<int>& points, double apart) {
  using Cell = std::array<int, 3>;
  const std::vector<Vec3>& X = skin.surface.vertices;
  const auto cellOf = [&](const Vec3& x) {
    Cell at{};
    for (int a = 0; a < 3; ++a) at[static_cast<std::size_t>(a)] = static_cast<int>(std::floor(x[a] / apart));
    return at;
  };
  std::map<Cell, std::vector<int>> place;  // numbers of points
  for (std::size_t p = 0; p < points.size(); ++p) place[cellOf(X[points[p]])].push_back(static_cast<int>(p));
  std::vector<double> area(points.size(), 0);
  for (std::size_t v = 0; v < X.size(); ++v) {
    const Cell at = cellOf(X[v]);
    int nearest = -1;
    double distance = std::numeric_limits<double>::infinity();
    for (int n = 0; n < 27; ++n) {
      const auto cell = place.find({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1});
      if (cell == place.end()) continue;
      for (const int p : cell->second)
        if (const double d = (X[points[p]] - X[v]).squaredNorm(); d < distance) distance = d, nearest = p;
    }
    if (nearest >= 0) area[nearest] += skin.area[v];  // always: each vertex is nearer than `apart` to one
  }
  return {area.begin(), area.end()};
}

/// Fills a row of the grid: distances are asked for near the surface, and as often as needed to get there.
void fillRow(const SurfaceTree& surface, const SkullOptions& options, int j, int k, Skull& skull) {
  const double inner = 3 * skull.cell, outer = Skull::farthest_out + options.clearance + 2 * skull.cell;
  bool inside = false, sure = false;
  for (int i = 0; i < skull.count[0];) {
    const Vec3 x = skull.origin + skull.cell * Vec3(i, j, k);
    const double distance = surface.closest(x).distance;
    if (!sure) inside = surface.inside(x);
    const double signed_distance = inside ? -distance : distance;
    const double gap = options.clearance - signed_distance;
    const bool near = gap < inner && signed_distance < outer;
    if (near && !(options.open && options.open(x)))
      skull.gap[static_cast<std::size_t>(i) +
                static_cast<std::size_t>(skull.count[0]) *
                    (static_cast<std::size_t>(j) +
                     static_cast<std::size_t>(skull.count[1]) * static_cast<std::size_t>(k))] = static_cast<float>(gap);
    // No surface within `distance`: the next nodes there are on the same side, and far ones are not looked at.
    const double beyond = near ? 0 : inside ? gap - inner : signed_distance - outer;
    const int steps = std::max(1, static_cast<int>(beyond / skull.cell));
    sure = distance > steps * skull.cell;
    i += steps;
  }
}

}  // namespace

Skull buildSkull(const SurfaceTree& surface, const SkinModel& skin, const SkullOptions& options) {
  Skull skull;
  const double apart = point_distance * options.spacing;
  skull.vertex = thinned(skin.surface.vertices, apart);
  skull.area = areasOf(skin, skull.vertex, apart);
  skull.stiffness = options.young_modulus / layer_depth;

  const Box3 box = boundingBox(surface.surface());
  skull.cell = std::min(options.spacing / cells_per_spacing, largest_cell);
  const auto margin = [&] { return options.clearance + Skull::farthest_out + 3 * skull.cell; };
  const auto nodes = [&] { return ((box.sizes().array() + 2 * margin()) / skull.cell + 2).prod(); };
  while (nodes() > most_nodes) skull.cell *= 1.1;
  skull.origin = box.min().array() - margin();
  for (int a = 0; a < 3; ++a)
    skull.count[static_cast<std::size_t>(a)] = 2 + static_cast<int>((box.sizes()[a] + 2 * margin()) / skull.cell);
  skull.gap.assign(static_cast<std::size_t>(skull.count[0]) * static_cast<std::size_t>(skull.count[1]) *
                       static_cast<std::size_t>(skull.count[2]),
                   Skull::away);
  parallelFor(
      skull.count[1] * skull.count[2],
      [&](int first, int last) {
        for (int row = first; row < last; ++row)
          fillRow(surface, options, row % skull.count[1], row / skull.count[1], skull);
      },
      1);

  for (const int v : skull.vertex) {
    Vec3 normal;
    const double gap = skull.at(skin.surface.vertices[v], normal);
    const bool exact = options.of_organ && gap < static_cast<double>(Skull::away);
    skull.correction.push_back(exact ? static_cast<float>(options.clearance - gap) : 0.0F);
  }
  return skull;
}

}  // namespace palpate
