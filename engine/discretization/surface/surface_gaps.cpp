#include "discretization/surface/surface_gaps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "base/parallel_for.h"

namespace palpate {
namespace {

// Swept on a flap above even and on one above wedge-shaped air, nodes 4 mm apart: what points follow does not change
// with `facing` from 0.25 to 0.8, `inward` from 0.005 to 0.1, `at_ends` from 1e-4 to 1e-2. With `screen_at` a fifth the
// flap is 7 % slower to come back, with a half 3 % faster, of which finer clouds have nearly as much.
constexpr double facing = 0.5;         // cosine between a face's normal and that of what it looks at, turned round
constexpr double lift_of_edge = 1e-4;  // of a face's size, off the face: rays don't meet the face that they are from
constexpr double screen_at = 1.0 / 3;  // of the way across: what is hollow has a screen, too, that is no line
constexpr double inward = 0.02;   // of the way to a face's middle, so that rays from an edge meet what is over the face
constexpr double at_ends = 1e-3;  // of a way, at its ends: skin where a gap ends may lie on a screen

/// From a face along its normal or against it to what looks at it, m; 0: nothing does.
double wayAcross(const SurfaceTree& body, const Vec3& from, const Vec3& along, double lift, double furthest) {
  const auto hit = body.firstHit(from + lift * along, along, furthest);
  if (!hit) return 0;
  const Vec3 opposite = areaVector(body.surface(), hit->triangle);
  return std::abs(opposite.dot(along)) > facing * opposite.norm() ? hit->distance + lift : 0;
}

}  // namespace

std::vector<Vec3> acrossAir(const SurfaceTree& body, const Vec3& x, double widest) {
  const TriangleSurface& skin = body.surface();
  const double rounding = 1e-6 * widest;
  std::vector<int> faces;
  body.facesNear(Box3(x - Vec3::Constant(rounding), x + Vec3::Constant(rounding)), faces);
  std::sort(faces.begin(), faces.end());
  std::vector<Vec3> found;
  for (const int t : faces) {
    const Vec3 area = areaVector(skin, t), normal = area.normalized();
    if (!(area.squaredNorm() > 0) || std::abs(normal.dot(x - skin.vertices[skin.triangles[t][0]])) > rounding) continue;
    const auto& [a, b, c] = skin.triangles[t];
    const Vec3 inward_way = (skin.vertices[a] + skin.vertices[b] + skin.vertices[c]) / 3 - x;
    const Vec3 from = x + std::min(inward, inward * widest / std::max(inward_way.norm(), widest)) * inward_way;
    const double way = wayAcross(body, from, normal, lift_of_edge * widest, widest);
    if (way == 0) continue;
    const SurfaceTree::Closest foot = body.closest(x + way * normal, inward * widest);
    const bool is_new = std::none_of(found.begin(), found.end(),
                                     [&](const Vec3& y) { return (y - foot.point).norm() < inward * widest; });
    if (foot.triangle >= 0 && is_new) found.push_back(foot.point);
  }
  return found;
}

std::vector<double> thicknesses(const TriangleSurface& skin, const SurfaceTree& body) {
  std::vector<double> thickness(skin.triangles.size(), std::numeric_limits<double>::infinity());
  parallelFor(static_cast<int>(thickness.size()), [&](int first, int last) {
    for (int t = first; t < last; ++t) {
      const Vec3 area = areaVector(skin, t);
      if (!(area.squaredNorm() > 0)) continue;
      const auto& [a, b, c] = skin.triangles[t];
      const Vec3 middle = (skin.vertices[a] + skin.vertices[b] + skin.vertices[c]) / 3;
      const double way = wayAcross(body, middle, -area.normalized(), lift_of_edge * std::sqrt(area.norm()),
                                   std::numeric_limits<double>::infinity());
      if (way > 0) thickness[t] = way;
    }
  });
  return thickness;
}

double thicknessOf(const SurfaceTree& body, double share) {
  const std::vector<double> thickness = thicknesses(body.surface(), body);
  std::vector<std::pair<double, double>> thin;  // m, m^2
  for (std::size_t t = 0; t < thickness.size(); ++t)
    thin.emplace_back(thickness[t], areaVector(body.surface(), static_cast<int>(t)).norm());
  std::sort(thin.begin(), thin.end());
  double left = share * surfaceArea(body.surface());
  for (const auto& [across, area] : thin)
    if ((left -= area) <= 0) return across;
  return std::numeric_limits<double>::infinity();
}

namespace {

/// What looks at each other across a gap, m.
struct Screen {
  std::array<Vec3, 3> corner;
  std::array<double, 3> gap{};
  bool exists = false;
};

/// The screen before a face, which exists where all of the face looks at skin.
Screen screenBefore(const SurfaceTree& body, const std::array<Vec3, 3>& face, double widest) {
  const auto& [a, b, c] = face;
  const Vec3 area = (b - a).cross(c - a), middle = (a + b + c) / 3;
  Screen screen;
  if (!(area.squaredNorm() > 0)) return screen;
  const Vec3 normal = area.normalized();
  const double lift = lift_of_edge * std::sqrt(area.norm());
  const auto across = [&](const Vec3& from) { return wayAcross(body, from, normal, lift, widest); };
  screen.exists = across(middle) > 0;
  for (std::size_t k = 0; screen.exists && k < 3; ++k) {
    screen.gap[k] = across(face[k] + inward * (middle - face[k]));
    screen.exists = screen.gap[k] > 0;
    screen.corner[k] = face[k] + screen_at * screen.gap[k] * normal;
  }
  return screen;
}

void add(const std::array<Vec3, 3>& corners, TriangleSurface& screens) {
  const int at = static_cast<int>(screens.vertices.size());
  screens.vertices.insert(screens.vertices.end(), corners.begin(), corners.end());
  screens.triangles.push_back({at, at + 1, at + 2});
}

}  // namespace

SurfaceGaps::SurfaceGaps(const TriangleSurface& skin, const SurfaceTree& body, double widest) {
  const int count = static_cast<int>(skin.triangles.size());
  std::vector<Screen> screen(static_cast<std::size_t>(count));
  parallelFor(count, [&](int first, int last) {
    for (int t = first; t < last; ++t) {
      const auto& [a, b, c] = skin.triangles[t];
      screen[t] = screenBefore(body, {skin.vertices[a], skin.vertices[b], skin.vertices[c]}, widest);
    }
  });
  using Edge = std::pair<int, int>;
  std::set<Edge> edges;  // as the screens' faces turn
  const auto edgeOf = [&](int t, std::size_t k) { return Edge{skin.triangles[t][k], skin.triangles[t][(k + 1) % 3]}; };
  for (int t = 0; t < count; ++t)
    for (std::size_t k = 0; screen[t].exists && k < 3; ++k) edges.insert(edgeOf(t, k));
  TriangleSurface screens;
  for (int t = 0; t < count; ++t) {
    if (!screen[t].exists) continue;
    const auto& [corner, gap, exists] = screen[t];
    add(corner, screens);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [from, to] = edgeOf(t, k);
      if (edges.contains({to, from})) continue;
      // Where a gap opens, its screen goes on as far as it is wide, or lips would hold each other along their rims.
      const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
      const Vec3 along = (corner[l] - corner[k]).normalized(), back = corner[m] - corner[k];
      const Vec3 out = -(back - back.dot(along) * along).normalized();
      const Vec3 p = corner[k] + gap[k] * out, q = corner[l] + gap[l] * out, from_middle = (corner[k] + corner[l]) / 2;
      const auto inTissue = [&](double share) {
        return body.inside(from_middle + share * ((p + q) / 2 - from_middle));
      };
      if (inTissue(inward) || inTissue(0.5) || inTissue(1)) continue;
      add({corner[k], p, q}, screens);
      add({corner[k], q, corner[l]}, screens);
    }
  }
  if (!screens.triangles.empty()) screens_.emplace(std::move(screens));
}

bool SurfaceGaps::areBetween(const Vec3& a, const Vec3& b) const {
  const Vec3 way = b - a;
  return screens_ && screens_->firstHit(a + at_ends * way, way, (1 - 2 * at_ends) * way.norm()).has_value();
}

}  // namespace palpate
