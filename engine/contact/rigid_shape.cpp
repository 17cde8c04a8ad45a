#include "contact/rigid_shape.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

double boxGap(const Vec3& half, const Vec3& local, Vec3& normal) {
  const Vec3 beyond = local.cwiseAbs() - half;
  const Vec3 side = local.unaryExpr([](double a) { return a < 0 ? -1.0 : 1.0; });
  if ((beyond.array() > 0).any()) {
    const Vec3 out = beyond.cwiseMax(0);
    normal = out.cwiseProduct(side);
    return out.norm();
  }
  int nearest = 0;
  const double depth = beyond.maxCoeff(&nearest);
  normal = side[nearest] * Vec3::Unit(nearest);
  return depth;
}

/// @param local  from the middle of the base
double cylinderGap(const RigidShape& s, const Vec3& local, Vec3& normal) {
  const double up = local.dot(s.normal), r = (local - up * s.normal).norm();
  const Vec3 radial = r > 0 ? Vec3((local - up * s.normal) / r) : s.normal.unitOrthogonal();
  const double past_end = std::abs(up - 0.5 * s.height) - 0.5 * s.height, past_side = r - s.radius;
  const Vec3 end = up < 0.5 * s.height ? Vec3(-s.normal) : s.normal;
  if (past_end <= 0 && past_side <= 0) {
    normal = past_side > past_end ? radial : end;
    return std::max(past_side, past_end);
  }
  normal = std::max(past_end, 0.0) * end + std::max(past_side, 0.0) * radial;
  return normal.norm();
}

double gridGap(const GapGrid& grid, const Vec3& x, Vec3& normal) {
  const Vec3 index = (x - grid.origin) / grid.cell;
  normal = Vec3::UnitZ();
  int low[3];
  for (int a = 0; a < 3; ++a) {
    if (!(index[a] >= 0 && index[a] < grid.count[static_cast<std::size_t>(a)] - 1)) return RigidShape::away;
    low[a] = static_cast<int>(index[a]);
  }
  const double r = index[0] - low[0], s = index[1] - low[1], t = index[2] - low[2];
  const auto row = static_cast<std::size_t>(grid.count[0]), plane = row * static_cast<std::size_t>(grid.count[1]);
  const float* g =
      grid.gap.data() + static_cast<std::size_t>(low[2]) * plane + static_cast<std::size_t>(low[1]) * row + low[0];
  double c[2][2][2];  // z, y, x
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t j = 0; j < 2; ++j)
      for (std::size_t i = 0; i < 2; ++i) {
        const auto value = static_cast<double>(g[k * plane + j * row + i]);
        if (value >= RigidShape::away) return RigidShape::away;
        c[k][j][i] = value;
      }
  const auto mix = [](double a, double b, double share) { return a + share * (b - a); };
  const auto alongX = [&](const double(&face)[2][2]) {
    return mix(face[0][1] - face[0][0], face[1][1] - face[1][0], s);
  };
  const auto line = [&](int k, int j) { return mix(c[k][j][0], c[k][j][1], r); };
  normal.x() = mix(alongX(c[0]), alongX(c[1]), t);
  normal.y() = mix(line(0, 1) - line(0, 0), line(1, 1) - line(1, 0), t);
  const double lower = mix(line(0, 0), line(0, 1), s), upper = mix(line(1, 0), line(1, 1), s);
  normal.z() = upper - lower;
  if (normal.squaredNorm() < 1e-6 * grid.cell * grid.cell) return RigidShape::away;  // between two walls
  const double value = mix(lower, upper, t);
  return value < -RigidShape::farthest_out ? RigidShape::away : value;
}

}  // namespace

double RigidShape::gapAt(const Vec3& x, Vec3& n) const {
  switch (kind) {
    case Kind::HalfSpace:
      n = normal;
      return (x - point).dot(normal);
    case Kind::Box:
      return boxGap(half, x - point, n);
    case Kind::Sphere: {
      const Vec3 out = x - point;
      const double distance = out.norm();
      n = distance > 0 ? out : Vec3::UnitZ();
      return distance - radius;
    }
    case Kind::Cylinder:
      return cylinderGap(*this, x - point, n);
    case Kind::Surface:
      break;
  }
  return gridGap(grid, x, n);
}

Vec3 RigidShape::normalAt(const Vec3& x, const Vec3& gradient) const {
  if (kind != Kind::Surface) return gradient.normalized();
  Vec3 slope, unused;
  for (int a = 0; a < 3; ++a) {
    const Vec3 half_cell = 0.5 * grid.cell * Vec3::Unit(a);
    const double up = gapAt(x + half_cell, unused), down = gapAt(x - half_cell, unused);
    if (std::max(up, down) >= away) return gradient.normalized();
    slope[a] = up - down;
  }
  return slope.squaredNorm() > 1e-6 * grid.cell * grid.cell ? slope.normalized() : gradient.normalized();
}

Vec3 RigidShape::middle() const {
  if (kind != Kind::Surface) return point;
  return grid.origin + 0.5 * grid.cell * Vec3(grid.count[0] - 1, grid.count[1] - 1, grid.count[2] - 1);
}

double RigidShape::leastGap(const Vec3& x) const {
  Vec3 unused;
  if (kind != Kind::Surface) return gapAt(x, unused);
  return ((x - middle()).cwiseAbs() - (middle() - grid.origin)).cwiseMax(0).norm();
}

}  // namespace palpate
