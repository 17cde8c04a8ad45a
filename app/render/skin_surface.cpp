#include "app/render/skin_surface.h"

namespace palpate::app {

namespace {

constexpr int smoothing_rounds = 3;  // a probe that glides should turn evenly, not from facet to facet

std::vector<Vec3> smoothNormals(const TriangleSurface& surface) {
  std::vector<Vec3> normal(surface.vertices.size(), Vec3::Zero());
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3 area = (surface.vertices[b] - surface.vertices[a]).cross(surface.vertices[c] - surface.vertices[a]);
    for (const int v : {a, b, c}) normal[v] += area;
  }
  for (Vec3& n : normal) n = n.norm() > 0 ? Vec3(n.normalized()) : Vec3(Vec3::UnitZ());
  for (int round = 0; round < smoothing_rounds; ++round) {
    std::vector<Vec3> sum = normal;
    for (const auto& [a, b, c] : surface.triangles) {
      sum[a] += normal[b] + normal[c];
      sum[b] += normal[c] + normal[a];
      sum[c] += normal[a] + normal[b];
    }
    for (std::size_t v = 0; v < normal.size(); ++v)
      if (sum[v].norm() > 1e-9) normal[v] = sum[v].normalized();
  }
  return normal;
}

}  // namespace

SkinSurface::SkinSurface(const TriangleSurface& surface) : tree_(surface), normal_(smoothNormals(surface)) {}

SkinSurface::Place SkinSurface::nearest(const Vec3& x) const {
  if (tree_.surface().triangles.empty()) return {x, Vec3::UnitZ()};
  const SurfaceTree::Closest closest = tree_.closest(x);
  if (closest.triangle < 0) return {x, Vec3::UnitZ()};
  Place place{closest.point, Vec3::Zero()};
  const auto& corners = tree_.surface().triangles[static_cast<std::size_t>(closest.triangle)];
  for (int c = 0; c < 3; ++c)
    place.normal += closest.barycentric[c] * normal_[static_cast<std::size_t>(corners[static_cast<std::size_t>(c)])];
  place.normal = place.normal.norm() > 1e-9 ? Vec3(place.normal.normalized()) : Vec3(Vec3::UnitZ());
  return place;
}

}  // namespace palpate::app
