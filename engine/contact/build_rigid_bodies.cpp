#include <algorithm>
#include <cmath>

#include "base/parallel_for.h"
#include "contact/rigid_bodies.h"
#include "contact/skin_points.h"

namespace palpate {
namespace {

/// Apart from each other, per spacing of the nodes there, are the points that touch. (RigidBodies)
constexpr double point_distance = 0.5;

/// The same per radius of what is round, whichever is less: all vertices of a skin that is made for it (edges of a
/// quarter). Two thirds of them press 4 % less than a tool of the same shape, which has all.
constexpr double point_distance_on_round = 0.1;

constexpr double cells_per_spacing = 3;
constexpr double largest_cell = 2e-3;  // m: edges are as sharp as that
/// Per radius of what is round: the distance to a ball is within a thousandth of its radius then, cell^2 / (4 radius).
/// (By the spacing alone a ball of 4 mm was pressed by 10 % less.)
constexpr double cell_on_round = 0.06;
constexpr double most_nodes = 4e6;  // of the grid: 16 MB

/// Fills a row of the grid: distances are asked for near the surface, and as often as needed to get there.
void fillRow(const SurfaceTree& surface, const SurfaceSide& side, int j, int k, GapGrid& grid) {
  const double inner = 3 * grid.cell, outer = RigidShape::farthest_out + 2 * grid.cell;
  bool inside = false, sure = false;
  for (int i = 0; i < grid.count[0];) {
    const Vec3 x = grid.origin + grid.cell * Vec3(i, j, k);
    const double distance = surface.closest(x).distance;
    if (!sure) inside = surface.inside(x);
    const double room = side.inside == inside ? distance : -distance;
    const double gap = side.inside ? side.clearance + room : room - side.clearance;
    const bool near = gap < inner && -gap < outer;
    if (near && !(side.open && side.open(x)))
      grid.gap[static_cast<std::size_t>(i) +
               static_cast<std::size_t>(grid.count[0]) *
                   (static_cast<std::size_t>(j) +
                    static_cast<std::size_t>(grid.count[1]) * static_cast<std::size_t>(k))] = static_cast<float>(gap);
    // No surface within `distance`: the next nodes there are on the same side, and far ones are not looked at.
    const double beyond = near ? 0 : gap > 0 ? gap - inner : -gap - outer;
    const int steps = std::max(1, static_cast<int>(beyond / grid.cell));
    sure = distance > steps * grid.cell;
    i += steps;
  }
}

/// m, apart from each other, where points of the skin touch a body.
double apartOn(const RigidShape& shape, double spacing) {
  const bool round = shape.kind != RigidShape::Kind::HalfSpace && shape.kind != RigidShape::Kind::Box;
  const double by_spacing = point_distance * spacing;
  return round ? std::min(by_spacing, point_distance_on_round * shape.radius) : by_spacing;
}

}  // namespace

RigidShape surfaceShape(const SurfaceTree& surface, const SurfaceSide& side, double spacing) {
  RigidShape shape;
  shape.radius = meanRadius(surface.surface());
  GapGrid& grid = shape.grid;
  const Box3 box = boundingBox(surface.surface());
  grid.cell = std::min({spacing / cells_per_spacing, largest_cell, cell_on_round * shape.radius});
  const auto margin = [&] { return side.clearance + RigidShape::farthest_out + 3 * grid.cell; };
  const auto nodes = [&] { return ((box.sizes().array() + 2 * margin()) / grid.cell + 2).prod(); };
  while (nodes() > most_nodes) grid.cell *= 1.1;
  grid.origin = box.min().array() - margin();
  for (int a = 0; a < 3; ++a)
    grid.count[static_cast<std::size_t>(a)] = 2 + static_cast<int>((box.sizes()[a] + 2 * margin()) / grid.cell);
  grid.gap.assign(static_cast<std::size_t>(grid.count[0]) * static_cast<std::size_t>(grid.count[1]) *
                      static_cast<std::size_t>(grid.count[2]),
                  static_cast<float>(RigidShape::away));
  parallelFor(
      grid.count[1] * grid.count[2],
      [&](int first, int last) {
        for (int row = first; row < last; ++row) fillRow(surface, side, row % grid.count[1], row / grid.count[1], grid);
      },
      1);
  return shape;
}

void addRigidBody(RigidBody body, const SkinModel& skin, const std::vector<int>& of_body, const SpacingField& spacing,
                  std::optional<double> gap_at_rest, RigidBodies& bodies) {
  const auto [points, areas] =
      skinPoints(skin, of_body, [&](const Vec3& X) { return apartOn(body.shape, spacing.at(X)); });
  body.begin = bodies.pointCount();
  bodies.vertex.insert(bodies.vertex.end(), points.begin(), points.end());
  bodies.area.insert(bodies.area.end(), areas.begin(), areas.end());
  body.end = bodies.pointCount();
  for (const int v : points) {
    Vec3 normal;
    const double gap = gap_at_rest ? body.shape.gapAt(skin.surface.vertices[v], normal) : 0;
    const bool exact = gap_at_rest && gap < RigidShape::away;
    bodies.correction.push_back(exact ? static_cast<float>(*gap_at_rest - gap) : 0.0F);
    bodies.row_sum = std::max(bodies.row_sum, rowSum(skin, v));
  }
  bodies.body.push_back(std::move(body));
}

}  // namespace palpate
