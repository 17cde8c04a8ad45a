#include "simulation/scene.h"

#include <algorithm>
#include <cmath>

namespace palpate {

bool Region::contains(const Vec3& x, double tolerance, double surface_distance) const {
  switch (kind) {
    case Kind::HalfSpace:
      return (x - point).dot(normal) <= tolerance;
    case Kind::Box:
      return ((x - min).array() >= -tolerance).all() && ((x - max).array() <= tolerance).all();
    case Kind::Sphere:
      return (x - point).norm() <= radius + tolerance;
    case Kind::NearPlane:
      return std::abs((x - point).dot(normal)) <= distance + tolerance;
    case Kind::Cylinder: {
      const double z = (x - point).dot(normal);
      return z >= -tolerance && z <= height + tolerance && (x - point - z * normal).norm() <= radius + tolerance;
    }
    case Kind::Shell:
      return surface_distance <= distance + tolerance;
  }
  return false;
}

double LoadCurve::at(double time_s, double duration) const {
  if (kind == Kind::Table) {
    const auto after = std::upper_bound(time.begin(), time.end(), time_s);
    if (after == time.begin()) return fraction.front();
    if (after == time.end()) return fraction.back();
    const auto k = static_cast<std::size_t>(after - time.begin());
    const double s = (time_s - time[k - 1]) / (time[k] - time[k - 1]);
    return fraction[k - 1] + s * (fraction[k] - fraction[k - 1]);
  }
  const double t = duration > 0 ? std::clamp(time_s / duration, 0.0, 1.0) : (time_s > 0 ? 1.0 : 0.0);
  return kind == Kind::Linear ? t : t * t * t * (10 + t * (-15 + 6 * t));
}

}  // namespace palpate
