#include "simulation/scene.h"

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
    case Kind::Point:
      break;
  }
  return false;
}

}  // namespace palpate
