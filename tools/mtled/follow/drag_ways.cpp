#include "mtled/follow/drag_ways.h"

#include <algorithm>
#include <cmath>

#include "base/turn.h"
#include "discretization/surface/surface_geometry.h"
#include "scene/scene_regions.h"

namespace palpate::tools {
namespace {

constexpr int grid = 24;  // starts tried along either side of the organ
constexpr int headings = 8;
constexpr double sample = 1e-3;   // m, along the line
constexpr double steepest = 0.7;  // cosine of the skin's normal with the tool's axis: 45 degrees
constexpr double smooth = 4e-3;   // m to both sides, over which the skin's height is averaged
constexpr double down_seconds = 0.5;

/// Height of the skin along -axis over a line; empty where the line leaves what may be dragged over.
std::vector<Vec3> skinAlong(const Scene& scene, const SurfaceTree& organ, const Vec3& start, const Vec3& heading,
                            double length) {
  const Vec3 axis = scene.tools[0].direction;
  const double far = boundingBox(organ.surface()).diagonal().norm();
  std::vector<Vec3> line;
  // A tool radius beyond both ends, so that the whole tool is over skin.
  const int beyond = static_cast<int>(std::ceil(scene.tools[0].shape.radius / sample));
  const int last = static_cast<int>(std::lround(length / sample));
  for (int k = -beyond; k <= last + beyond; ++k) {
    const auto hit = organ.firstHit(start + k * sample * heading - far * axis, axis, 2 * far);
    if (!hit || -areaVector(organ.surface(), hit->triangle).normalized().dot(axis) < steepest) return {};
    const bool imposed = std::any_of(scene.boundaries.begin(), scene.boundaries.end(), [&](const BoundarySpec& b) {
      return contains(b.region, hit->point, organ) ||
             contains(b.region, hit->point + 2 * scene.tools[0].shape.radius * axis, organ);
    });
    if (imposed) return {};
    if (k >= 0 && k <= last) line.push_back(hit->point);
  }
  return line;
}

}  // namespace

std::vector<DragWay> dragWays(const Scene& scene, const SurfaceTree& organ, const DragSettings& settings) {
  const Vec3 axis = scene.tools[0].direction, e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
  const Box3 box = boundingBox(organ.surface());
  const double half = box.diagonal().norm() / 2;
  const int width = static_cast<int>(std::lround(smooth / sample));
  std::vector<DragWay> all;
  for (double length = settings.length; all.empty() && length >= settings.length / 2; length -= 0.01) {
    for (int i = 0; i <= grid; ++i)
      for (int j = 0; j <= grid; ++j)
        for (int h = 0; h < headings; ++h) {
          const Vec3 start = box.center() + half * ((2.0 * i / grid - 1) * e1 + (2.0 * j / grid - 1) * e2);
          const double angle = 2 * M_PI * h / headings;
          const auto line = skinAlong(scene, organ, start, std::cos(angle) * e1 + std::sin(angle) * e2, length);
          if (line.empty()) continue;
          DragWay way{line.front(), line.back(), length, {}};
          const int last = static_cast<int>(line.size()) - 1;
          for (int k = 0; k <= last; ++k) {
            const int reach = std::min({width, k, last - k});
            double height = 0;
            for (int n = k - reach; n <= k + reach; ++n) height += (line[n] - line[k]).dot(axis) / (2 * reach + 1);
            way.tip.push_back(line[k] + (height + settings.depth * scene.tools[0].shape.radius) * axis);
          }
          all.push_back(std::move(way));
        }
  }
  // The first goes nearest to below the tool's start, the others as far from those before as can be.
  const auto middle = [](const DragWay& way) { return Vec3((way.from + way.to) / 2); };
  std::vector<DragWay> chosen;
  while (!all.empty() && static_cast<int>(chosen.size()) < settings.count) {
    std::size_t best = 0;
    double largest = -INFINITY;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const Vec3 apart = middle(all[k]) - scene.tools[0].position;
      double value = chosen.empty() ? -(apart - apart.dot(axis) * axis).norm() : INFINITY;
      for (const DragWay& other : chosen) value = std::min(value, (middle(all[k]) - middle(other)).norm());
      if (value > largest) largest = value, best = k;
    }
    chosen.push_back(all[best]);
    all.erase(all.begin() + static_cast<std::ptrdiff_t>(best));
  }
  return chosen;
}

std::vector<ToolPosture> posturesOn(const DragWay& way, const Scene& scene, const DragSettings& settings) {
  std::vector<ToolPosture> postures;
  Pose pose{way.tip.front(), uprightOn(-scene.tools[0].direction)};
  const int down = static_cast<int>(std::lround(down_seconds * scene.dynamics.rate_hz));
  const double above = (settings.depth + 0.5) * scene.tools[0].shape.radius;
  for (int k = 0; k <= down; ++k) {
    const double s = static_cast<double>(k) / down;
    pose.position = way.tip.front() - (1 - s * s * (3 - 2 * s)) * above * scene.tools[0].direction;
    postures.push_back({pose, 0});
  }
  const int ticks = static_cast<int>(std::lround(way.length / settings.speed * scene.dynamics.rate_hz));
  for (int k = 1; k <= ticks; ++k) {
    const double at = static_cast<double>(k) / ticks * static_cast<double>(way.tip.size() - 1);
    const auto n = std::min(static_cast<std::size_t>(at), way.tip.size() - 2);
    pose.position = way.tip[n] + (at - static_cast<double>(n)) * (way.tip[n + 1] - way.tip[n]);
    postures.push_back({pose, 0});
  }
  return postures;
}

}  // namespace palpate::tools
