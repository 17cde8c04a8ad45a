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

}  // namespace palpate::app
