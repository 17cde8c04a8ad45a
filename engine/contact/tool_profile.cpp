#include "contact/tool_profile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace palpate {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The core is a point or a piece of the axis.
ToolDistance distanceToAxis(const ToolProfile& p, const Vec3& x) {
  const double z = std::clamp(x.z(), p.corner[0].z, p.corner[p.corner_count - 1].z);
  const Vec3 away = x - Vec3(0.0, 0.0, z);
  const double length = away.norm();
  if (length > 0.0 || std::isnan(length)) return {length - p.rounding, away / length};
  // On the axis the way out is sideways, at the tip's end of the core forwards.
  return {-p.rounding, z > p.corner[0].z ? Vec3(Vec3::UnitX()) : Vec3(-Vec3::UnitZ())};
}

/// The core is a polygon.
ToolDistance distanceToPolygon(const ToolProfile& p, const Vec3& x) {
  const double r = std::sqrt(x.x() * x.x() + x.y() * x.y());
  if (!std::isfinite(r + x.z())) return {std::numeric_limits<double>::quiet_NaN(), -Vec3::UnitZ()};
  double nearest = infinity, highest = -infinity;  // squared distance to a side; height over a side's line
  MeridianPoint away, up;                          // from the nearest point of a side; normal of the highest line
  for (int k = 0; k + 1 < p.corner_count; ++k) {
    const MeridianPoint n = p.side_normal[k];
    const double qr = r - p.corner[k].r, qz = x.z() - p.corner[k].z;
    const double height = qr * n.r + qz * n.z;
    if (height > highest) highest = height, up = n;
    const double along = qz * n.r - qr * n.z;
    MeridianPoint d{height * n.r, height * n.z};
    if (along < 0.0) d = {qr, qz};
    if (along > p.side_length[k]) d = {r - p.corner[k + 1].r, x.z() - p.corner[k + 1].z};
    const double squared = d.r * d.r + d.z * d.z;
    if (squared < nearest) nearest = squared, away = d;
  }
  double distance = highest;
  MeridianPoint normal = up;
  if (highest > 0.0 && nearest > 0.0) {  // outside of the core
    distance = std::sqrt(nearest);
    normal = {away.r / distance, away.z / distance};
  }
  const double c = r > 0.0 ? x.x() / r : 1.0, s = r > 0.0 ? x.y() / r : 0.0;
  return {distance - p.rounding, Vec3(normal.r * c, normal.r * s, normal.z)};
}

}  // namespace

ToolProfile makeToolProfile(double radius, double length, double rounding,
                            std::initializer_list<MeridianPoint> corners) {
  ToolProfile p;
  p.radius = radius;
  p.length = length;
  p.rounding = rounding;
  for (const MeridianPoint& corner : corners) {
    if (p.corner_count > 0) {
      const MeridianPoint last = p.corner[p.corner_count - 1];
      const double side = std::hypot(corner.r - last.r, corner.z - last.z);
      if (side == 0.0) continue;
      p.side_normal[p.corner_count - 1] = {(corner.z - last.z) / side, (last.r - corner.r) / side};
      p.side_length[p.corner_count - 1] = side;
    }
    p.corner[p.corner_count++] = corner;
  }
  return p;
}

ToolDistance generalDistance(const ToolProfile& p, const Vec3& local) {
  const bool on_axis = p.corner_count == 1 || (p.corner_count == 2 && p.corner[1].r == 0.0);
  return on_axis ? distanceToAxis(p, local) : distanceToPolygon(p, local);
}

ToolDistance toolDistance(const ToolProfile& p, const Vec3& local) {
  return p.closed_form != nullptr ? p.closed_form(p, local) : generalDistance(p, local);
}

double exitDistance(const ToolProfile& p, const Vec3& local, const Vec3& direction) {
  // A step as long as the distance to the surface can't pass through it.
  const double close = 1e-4 * p.radius;
  double travelled = 0.0, last = 0.0;
  for (int i = 0; i < 32; ++i) {
    const double depth = -toolDistance(p, local + travelled * direction).distance;
    if (!(depth > 0.0)) break;
    travelled += depth;
    if (depth < close && depth < last) break;  // near the surface and going out
    last = depth;
  }
  return travelled;
}

double tipProfile(const ToolProfile& p, double r) {
  if (!(r <= p.radius)) return infinity;
  const double e = p.rounding;
  for (int k = 0;; ++k) {
    // Around a corner up to the next side that looks forwards, then along that side.
    const bool last = k + 1 >= p.corner_count || !(p.side_normal[k].z < 0.0);
    const double end_of_arc = last ? infinity : p.corner[k].r + e * p.side_normal[k].r;
    if (r <= end_of_arc) {
      const double a = std::max(0.0, r - p.corner[k].r);
      return p.corner[k].z - std::sqrt(std::max(0.0, e * e - a * a));
    }
    const MeridianPoint n = p.side_normal[k];
    if (r <= p.corner[k + 1].r + e * n.r) return p.corner[k].z + e * n.z - (r - end_of_arc) * n.r / n.z;
  }
}

std::vector<MeridianPoint> outline(const ToolProfile& p) {
  constexpr double quarter = 0.5 * std::numbers::pi;
  const double pieces_per_quarter = std::max(4.0, std::round(10.0 * std::sqrt(p.rounding / p.radius)));
  std::vector<MeridianPoint> points;
  for (int k = 0; k < p.corner_count; ++k) {
    const auto angle = [&](int side) { return std::atan2(p.side_normal[side].z, p.side_normal[side].r); };
    const double from = k == 0 ? -quarter : angle(k - 1), to = k + 1 == p.corner_count ? quarter : angle(k);
    const int pieces = static_cast<int>(std::ceil((to - from) / quarter * pieces_per_quarter - 1e-3));
    for (int i = 0; i <= pieces; ++i) {
      const double at = pieces > 0 ? from + (to - from) * i / pieces : from;
      points.push_back(
          {std::max(0.0, p.corner[k].r + p.rounding * std::cos(at)), p.corner[k].z + p.rounding * std::sin(at)});
    }
  }
  return points;
}

}  // namespace palpate
