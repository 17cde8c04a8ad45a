#include "contact/first_contact_travel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

/// Where a convex function on [0, 1] is least, by golden section; 50 steps narrow it to 1e-10.
template <class Function>
double convexArgmin(const Function& f) {
  constexpr double kGolden = 0.6180339887498949;
  double low = 0.0, high = 1.0;
  double a = high - kGolden, b = low + kGolden;
  double fa = f(a), fb = f(b);
  for (int i = 0; i < 50; ++i) {
    if (fa <= fb) {
      high = b, b = a, fb = fa;
      a = high - kGolden * (high - low), fa = f(a);
    } else {
      low = a, a = b, fa = fb;
      b = low + kGolden * (high - low), fb = f(b);
    }
  }
  return fa <= fb ? a : b;
}

}  // namespace

double firstContactTravel(const TriangleSurface& surface, const ToolShape& tool, const Pose& start) {
  const ToolProfile profile = toolProfile(tool);
  // A point at (r, z) in the tool's frame is touched after profile(r) - z. The profile is convex in r
  // and z is linear over a triangle, so each triangle has one minimum. Beyond the tool's radius
  // the profile goes on as a steep cone, which keeps it convex and steers the search inwards.
  constexpr double kSteep = 1e6;
  auto travel = [&](const Vec3& p) {
    const double r = std::hypot(p.x(), p.y());
    return tipProfile(profile, std::min(r, tool.radius)) + kSteep * std::max(0.0, r - tool.radius) - p.z();
  };
  double first = std::numeric_limits<double>::infinity();
  auto consider = [&](const Vec3& p) {
    const double r = std::hypot(p.x(), p.y());
    if (p.z() > profile.length || r > tool.radius * (1.0 + 1e-9)) return;
    first = std::min(first, tipProfile(profile, std::min(r, tool.radius)) - p.z());
  };

  std::vector<Vec3> local(surface.vertices.size());
  for (std::size_t v = 0; v < local.size(); ++v) {
    local[v] = start.toLocal(surface.vertices[v]);
    consider(local[v]);
  }
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3 &A = local[a], &B = local[b], &C = local[c];
    if (-std::max({A.z(), B.z(), C.z()}) >= first) continue;  // touched later than what is known
    const Vec3 m = (A + B + C) / 3.0;
    auto lateral = [&](const Vec3& p) { return std::hypot(p.x() - m.x(), p.y() - m.y()); };
    if (std::hypot(m.x(), m.y()) > tool.radius + std::max({lateral(A), lateral(B), lateral(C)})) continue;
    auto pointAt = [&](double s, double w) { return Vec3(A + s * ((1.0 - w) * (B - A) + w * (C - A))); };
    auto across = [&](double s) { return convexArgmin([&](double w) { return travel(pointAt(s, w)); }); };
    const double s = convexArgmin([&](double t) { return travel(pointAt(t, across(t))); });
    consider(pointAt(s, across(s)));
  }
  return first;
}

}  // namespace palpate
