#include "app/render/rigid_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/turn.h"
#include "discretization/surface/surface_geometry.h"

namespace palpate::app {
namespace {

constexpr auto finish = static_cast<float>(Finish::Matte);
constexpr double plate_radius = 1.45, plate_thickness = 0.06;  // of the organ's radius

/// A solid that is turned about z, from its base at the origin up.
SolidMesh canMesh(double radius, double height, double rim) {
  constexpr int rim_steps = 5;
  std::vector<ProfilePoint> profile{{0, 0}};
  const auto addRim = [&](double z, double from) {
    for (int k = 0; k <= rim_steps; ++k) {
      const double angle = from + 0.5 * std::numbers::pi * k / rim_steps;
      profile.emplace_back(static_cast<float>(radius - rim + rim * std::cos(angle)),
                           static_cast<float>(z + rim * std::sin(angle)));
    }
  };
  addRim(rim, -0.5 * std::numbers::pi);
  addRim(height - rim, 0);
  profile.emplace_back(0.0F, static_cast<float>(height));
  SolidMesh mesh;
  addTurned(mesh, profile, Finish::Matte);
  return mesh;
}

void addQuad(SolidMesh& mesh, const std::array<Vec3, 4>& corners, const Vec3& normal) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Vec3& x : corners) mesh.vertices.push_back({x.cast<float>(), normal.cast<float>(), finish});
  mesh.indices.insert(mesh.indices.end(), {base, base + 1, base + 2, base, base + 2, base + 3});
}

SolidMesh boxMesh(const Vec3& min, const Vec3& max) {
  SolidMesh mesh;
  const Vec3 middle = 0.5 * (min + max), half = 0.5 * (max - min);
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const Vec3 out = side * Vec3::Unit(axis);
      const Vec3 right = half[(axis + 1) % 3] * Vec3::Unit((axis + 1) % 3);
      const Vec3 up = side * half[(axis + 2) % 3] * Vec3::Unit((axis + 2) % 3);
      const Vec3 face = middle + half[axis] * out;
      addQuad(mesh, {face - right - up, face + right - up, face + right + up, face - right + up}, out);
    }
  return mesh;
}

SolidMesh surfaceMesh(const TriangleSurface& surface) {
  SolidMesh mesh;
  const std::vector<Vec3> normals = vertexNormals(surface);
  constexpr double sharp = 0.7;  // cosine between a face and its corner's normal, below which there is an edge
  for (const auto& t : surface.triangles) {
    const auto corner = [&](int c) {
      return surface.vertices[static_cast<std::size_t>(t[static_cast<std::size_t>(c)])];
    };
    const Vec3 face = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    for (int c = 0; c < 3; ++c) {
      const Vec3& smooth = normals[static_cast<std::size_t>(t[static_cast<std::size_t>(c)])];
      mesh.indices.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
      mesh.vertices.push_back(
          {corner(c).cast<float>(), (smooth.dot(face) < sharp ? face : smooth).cast<float>(), finish});
    }
  }
  return mesh;
}

/// Turns z to `up` and shifts.
SolidMesh put(SolidMesh mesh, const Vec3& up, const Vec3& at) {
  const Eigen::Matrix3f turn = uprightOn(up).toRotationMatrix().cast<float>();
  for (SolidVertex& v : mesh.vertices) {
    v.position = turn * v.position + at.cast<float>();
    v.normal = turn * v.normal;
    v.finish = finish;
  }
  return mesh;
}

}  // namespace

SolidMesh rigidMesh(const RigidSpec& body, const Vec3& centre, double radius) {
  if (body.encloses) return {};
  if (body.surface) return surfaceMesh(*body.surface);
  const Region& region = body.region;
  switch (region.kind) {
    case Region::Kind::Box:
      return boxMesh(region.min, region.max);
    case Region::Kind::Sphere: {
      SolidMesh ball = sphereMesh();
      for (SolidVertex& v : ball.vertices) v.position *= static_cast<float>(region.radius);
      return put(std::move(ball), Vec3::UnitZ(), region.point);
    }
    case Region::Kind::Cylinder:
      return put(canMesh(region.radius, region.height, 0.05 * std::min(region.radius, region.height)), region.normal,
                 region.point);
    default: {
      const double thickness = plate_thickness * radius;
      const Vec3 below = centre - (centre - region.point).dot(region.normal) * region.normal;
      return put(canMesh(plate_radius * radius, thickness, 0.3 * thickness), region.normal,
                 below - thickness * region.normal);
    }
  }
}

}  // namespace palpate::app
