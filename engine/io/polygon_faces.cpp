#include "io/polygon_faces.h"

#include <algorithm>

#include "discretization/surface/polygon_triangles.h"

namespace palpate {

void PolygonFaces::add(std::span<const int> corners, int line) {
  auto& triangles = file_.surface.triangles;
  if (corners.size() < 3) ++file_.unreadable_faces;
  if (corners.size() > 3) polygons_.push_back({static_cast<int>(triangles.size()), {corners.begin(), corners.end()}});
  for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
    triangles.push_back({corners[0], corners[k], corners[k + 1]});
    if (line > 0) file_.source.triangle_line.push_back(line);
  }
}

void PolygonFaces::finish() {
  const auto& vertices = file_.surface.vertices;
  std::vector<Vec3> x;
  CutBudget budget;
  for (const Polygon& polygon : polygons_) {
    const bool all_there = std::all_of(polygon.corners.begin(), polygon.corners.end(), [&](int v) {
      return v >= 0 && v < static_cast<int>(vertices.size()) && vertices[v].allFinite();
    });
    if (!all_there) continue;
    x.clear();
    for (const int v : polygon.corners) x.push_back(vertices[v]);
    Vec3 whole = Vec3::Zero();
    for (std::size_t k = 1; k + 1 < x.size(); ++k) whole += (x[k] - x[0]).cross(x[k + 1] - x[0]);
    // A fan fills a polygon only if none of its triangles points against the whole.
    bool convex = true;
    for (std::size_t k = 1; k + 1 < x.size(); ++k)
      convex = convex && !((x[k] - x[0]).cross(x[k + 1] - x[0]).dot(whole) < 0);
    if (convex) continue;
    ++file_.concave_polygons;
    int t = polygon.first_triangle;
    for (const auto& [a, b, c] : polygonTriangles(x, budget))
      file_.surface.triangles[t++] = {polygon.corners[a], polygon.corners[b], polygon.corners[c]};
  }
}

void checkIndices(const SurfaceFile& result, SurfaceReading reading) {
  const auto& vertices = result.surface.vertices;
  const auto& triangles = result.surface.triangles;
  const std::string& file = result.source.file;
  if (triangles.empty()) throw InputError({file, 0, 0}, "no faces in this file", "export the organ as a triangle mesh");
  if (reading == SurfaceReading::Tolerant) return;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const int line = result.source.triangle_line.empty() ? 0 : result.source.triangle_line[t];
    for (const int v : triangles[t])
      if (v < 0 || v >= static_cast<int>(vertices.size()))
        throw InputError({file, line, 0},
                         "face " + std::to_string(t + 1) + " names a vertex that is not there (the file has " +
                             std::to_string(vertices.size()) + ")",
                         "the file may have been cut short: export it again");
  }
  for (std::size_t v = 0; v < vertices.size(); ++v)
    if (!vertices[v].allFinite())
      throw InputError({file, 0, 0}, "vertex " + std::to_string(v + 1) + " is not finite", "export the file again");
  if (result.unreadable_faces > 0)
    throw InputError({file, 0, 0}, std::to_string(result.unreadable_faces) + " faces with fewer than 3 corners",
                     "export the file again");
}

}  // namespace palpate
