#include "app/render/pick.h"

#include <limits>

#include "app/render/field.h"

namespace palpate::app {
namespace {

/// Distance along the ray to a triangle seen from outside, or infinity (Moeller and Trumbore 1997).
double meet(const Ray& ray, const Vec3& a, const Vec3& b, const Vec3& c) {
  constexpr double miss = std::numeric_limits<double>::infinity();
  const Vec3 ab = b - a, ac = c - a, across = ray.direction.cross(ac);
  const double det = ab.dot(across);
  if (!(det > 0)) return miss;  // from behind, edge-on or degenerate
  const Vec3 from_a = ray.origin - a;
  const double s = from_a.dot(across);
  if (s < 0 || s > det) return miss;
  const Vec3 q = from_a.cross(ab);
  const double t = ray.direction.dot(q);
  if (t < 0 || s + t > det) return miss;
  const double distance = ac.dot(q) / det;
  return distance >= 0 ? distance : miss;
}

}  // namespace

std::optional<SkinHit> pickSkin(const TriangleSurface& surface, const std::vector<Vec3f>& positions, const Ray& ray) {
  SkinHit hit;
  hit.distance = std::numeric_limits<double>::infinity();
  const std::array<int, 3>* met = nullptr;
  for (const auto& t : surface.triangles) {
    const double distance =
        meet(ray, positions[t[0]].cast<double>(), positions[t[1]].cast<double>(), positions[t[2]].cast<double>());
    if (distance < hit.distance) {
      hit.distance = distance;
      met = &t;
    }
  }
  if (!met) return std::nullopt;
  hit.position = ray.origin + hit.distance * ray.direction;
  double nearest = std::numeric_limits<double>::infinity();
  for (const int v : *met) {
    const double d = (positions[v].cast<double>() - hit.position).norm();
    if (d < nearest) {
      nearest = d;
      hit.vertex = v;
    }
  }
  return hit;
}

int pickPoint(const Body& model, const Snapshot& snapshot, const Ray& ray, double tolerance) {
  const std::vector<Vec3f> x = deformed(model.point_X, model.point_shape, snapshot.u);
  int picked = -1;
  double nearest = tolerance;
  for (std::size_t q = 0; q < x.size(); ++q) {
    const Vec3 d = x[q].cast<double>() - ray.origin;
    const double along = d.dot(ray.direction), aside = (d - along * ray.direction).norm();
    if (along > 0 && aside <= nearest) {
      nearest = aside;
      picked = static_cast<int>(q);
    }
  }
  return picked;
}

bool isSeen(const TriangleSurface& surface, const std::vector<Vec3f>& positions, const Camera& camera,
            const Eigen::AlignedBox2d& part, int width, int height) {
  constexpr std::size_t enough = 4000;  // triangles of a finer skin: every n-th
  constexpr double least_pixels = 30;   // across; less is a speck
  if (surface.triangles.empty()) return true;
  const Vec3 eye = camera.eye();
  const std::size_t every = 1 + surface.triangles.size() / enough;
  Eigen::AlignedBox2d seen;
  for (std::size_t k = 0; k < surface.triangles.size(); k += every) {
    const auto& [i, j, l] = surface.triangles[k];
    const Vec3 a = positions[i].cast<double>(), b = positions[j].cast<double>(), c = positions[l].cast<double>();
    if ((b - a).cross(c - a).dot(eye - a) <= 0) continue;
    const Vec3 at = camera.project((a + b + c) / 3, width, height);
    if (at.z() > 0 && part.contains(Eigen::Vector2d(at.head<2>()))) seen.extend(Eigen::Vector2d(at.head<2>()));
  }
  if (!seen.isEmpty()) return seen.diagonal().maxCoeff() >= least_pixels;
  // So near that no triangle's middle lies in it?
  const Eigen::Vector2d middle = part.center();
  return pickSkin(surface, positions, camera.rayThrough(middle.x(), middle.y(), width, height)).has_value();
}

}  // namespace palpate::app
