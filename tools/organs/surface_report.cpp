#include "organs/surface_report.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "base/input_error.h"
#include "discretization/surface/surface_check.h"
#include "discretization/surface/surface_parts.h"

namespace palpate::organs {

SurfaceReport reportOn(const TriangleSurface& surface) {
  SurfaceReport report;
  report.vertices = static_cast<int>(surface.vertices.size());
  report.triangles = static_cast<int>(surface.triangles.size());
  try {
    checkSurface(surface);
  } catch (const InputError& error) {
    report.problem = error.what();
  }
  report.volume = signedVolume(surface);
  report.area = surfaceArea(surface);
  report.box = boundingBox(surface);

  report.shortest_edge = std::numeric_limits<double>::max();
  double largest_cosine = -1;
  double edge_sum = 0;
  for (const auto& t : surface.triangles) {
    for (int s = 0; s < 3; ++s) {
      const Vec3 forward = surface.vertices[t[(s + 1) % 3]] - surface.vertices[t[s]];
      const Vec3 back = surface.vertices[t[(s + 2) % 3]] - surface.vertices[t[s]];
      const double length = forward.norm();
      report.shortest_edge = std::min(report.shortest_edge, length);
      report.longest_edge = std::max(report.longest_edge, length);
      edge_sum += length;
      largest_cosine = std::max(largest_cosine, forward.normalized().dot(back.normalized()));
    }
  }
  report.mean_edge = edge_sum / (3.0 * report.triangles);
  report.smallest_angle_deg = std::acos(std::min(1.0, largest_cosine)) * 180 / M_PI;

  const std::vector<FaceEdge> edges = faceEdges(surface);
  report.components = connectedParts(surface, edges).count;
  report.genus = report.components - (report.vertices - static_cast<int>(edges.size()) / 2 + report.triangles) / 2;
  return report;
}

std::string SurfaceReport::text() const {
  std::ostringstream s;
  const Vec3 size = 1e3 * box.sizes(), min = 1e3 * box.min(), max = 1e3 * box.max();
  s << std::fixed << std::setprecision(1) << "  " << triangles << " triangles, " << vertices << " vertices; "
    << (problem.empty() ? "closed" : problem) << ", " << components << (components == 1 ? " piece" : " pieces")
    << ", genus " << genus << "\n"
    << "  size " << size.x() << " x " << size.y() << " x " << size.z() << " mm, x " << min.x() << ".." << max.x()
    << ", y " << min.y() << ".." << max.y() << ", z " << min.z() << ".." << max.z() << "\n"
    << "  volume " << volume * 1e6 << " ml, area " << area * 1e4 << " cm2\n"
    << std::setprecision(2) << "  edges " << shortest_edge * 1e3 << " / " << mean_edge * 1e3 << " / "
    << longest_edge * 1e3 << " mm (shortest, mean, longest), smallest angle " << smallest_angle_deg << " degrees\n";
  return s.str();
}

}  // namespace palpate::organs
