#include "setup/point_boundaries.h"

#include <algorithm>
#include <cmath>

#include "base/number_text.h"
#include "scene/scene_messages.h"
#include "scene/scene_regions.h"
#include "setup/sheet.h"

namespace palpate {
namespace {

constexpr double farthest = 0.04;  // m from the surface: no electrode is, but in a wrong frame they are

/// Measured points as places on the organ, and where these go.
struct MovedPoint {
  Vec3 X, u;
  SourceLocation place;
  int count = 1;  // points that were joined
};

std::vector<MovedPoint> movedPoints(const PointLoad& load, const SurfaceTree& organ) {
  std::vector<MovedPoint> moved;
  for (std::size_t k = 0; k < load.after.size(); ++k) {
    const bool has_before = !load.before.empty();
    const Vec3& measured = has_before ? load.before[k] : load.after[k];
    const SurfaceTree::Closest closest = organ.closest(measured);
    const SourceLocation place{load.file, k < load.line.size() ? load.line[k] : 0};
    if (!(closest.distance <= farthest))
      throw InputError(place,
                       "this point is " + format("%.0f mm", 1e3 * closest.distance) + " from the organ's surface",
                       "is its frame (\"ras\" or \"lps\") or its unit another one?");
    moved.push_back({closest.point, load.after[k] - (has_before ? measured : closest.point), place});
  }
  return moved;
}

/// Joins points that are nearer to an earlier one than `nearest`, in their order, until none are.
std::vector<MovedPoint> joined(std::vector<MovedPoint> points, double nearest) {
  for (;;) {
    std::vector<MovedPoint> result;
    for (const MovedPoint& point : points) {
      const auto near = std::find_if(result.begin(), result.end(),
                                     [&](const MovedPoint& other) { return (other.X - point.X).norm() < nearest; });
      if (near == result.end()) {
        result.push_back(point);
        continue;
      }
      near->count += point.count;
      const double share = static_cast<double>(point.count) / near->count;
      near->X += share * (point.X - near->X);
      near->u += share * (point.u - near->u);
    }
    if (result.size() == points.size()) return result;
    points = std::move(result);  // their middles may be nearer to each other than they were
  }
}

/// Refuses points in what other boundaries hold or move, before that has nodes.
void refuseHeld(const Scene& scene, const BoundarySpec& spec, const std::vector<MovedPoint>& points,
                const SurfaceTree& organ) {
  for (const BoundarySpec& other : scene.boundaries) {
    if (other.points || other.surface_only) continue;
    std::string also;
    const MovedPoint* first = nullptr;
    for (const MovedPoint& point : points) {
      if (!contains(other.region, point.X, organ)) continue;
      if (first)
        also += (also.empty() ? " (and so are those of lines " : ", ") + std::to_string(point.place.line);
      else
        first = &point;
    }
    if (first)
      throw InputError(first->place.file.empty() ? spec.place : first->place,
                       "this point, " + coordinates(first->X) + " on the organ, is in what " +
                           (other.duration == 0 ? "is held" : "is moved") + " at " + other.place.text() +
                           (also.empty() ? "" : also + ")"),
                       "make that region smaller, or leave the point out");
  }
}

}  // namespace

Scene withPointBoundaries(const Scene& scene, const SurfaceTree& organ,
                          const std::function<void(const std::string&)>& warn) {
  Scene result = scene;
  result.boundaries.clear();
  for (const BoundarySpec& spec : scene.boundaries) {
    if (!spec.points) {
      result.boundaries.push_back(spec);
      continue;
    }
    const std::vector<MovedPoint> all = movedPoints(*spec.points, organ);
    refuseHeld(scene, spec, all, organ);
    const std::vector<MovedPoint> kept = joined(all, 0.5 * scene.discretization.spacing);
    if (kept.size() < all.size() && warn)
      warn(spec.place.text() + ": of " + std::to_string(all.size()) + " points " + std::to_string(kept.size()) +
           " are left: those nearer to each other than half the spacing were joined");
    const auto add = [&](const std::string& name, const Vec3& X, const Vec3& u, const SourceLocation& place) {
      BoundarySpec& point = result.boundaries.emplace_back(spec);
      point.points.reset();
      point.name = name;
      point.region.kind = Region::Kind::Point;
      point.region.point = X;
      point.region.place = place;
      point.translation = u;
    };
    MovedPoints measured;
    for (std::size_t k = 0; k < kept.size(); ++k) {
      add(spec.name + " " + std::to_string(k + 1), kept[k].X, kept[k].u, kept[k].place);
      measured.X.push_back(kept[k].X), measured.u.push_back(kept[k].u);
    }
    if (!spec.points->sheet) continue;
    const MovedPoints between = sheetBetween(measured, organ, scene.discretization.spacing);
    for (std::size_t k = 0; k < between.X.size(); ++k)
      add(spec.name + " sheet " + std::to_string(k + 1), between.X[k], between.u[k], {});
  }
  return result;
}

}  // namespace palpate
