#include "simulation/scene.h"

#include <cmath>

namespace palpate {

bool Region::contains(const Vec3& x, double tolerance) const {
  switch (kind) {
    case Kind::HalfSpace:
      return (x - point).dot(normal) <= tolerance;
    case Kind::Box:
      return ((x - min).array() >= -tolerance).all() && ((x - max).array() <= tolerance).all();
    case Kind::Sphere:
      return (x - point).norm() <= radius + tolerance;
    case Kind::NearPlane:
      return std::abs((x - point).dot(normal)) <= distance + tolerance;
  }
  return false;
}

}  // namespace palpate
