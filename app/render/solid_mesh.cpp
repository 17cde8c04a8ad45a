#include "app/render/solid_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::app {
namespace {

constexpr int turn_segments = 56;
constexpr int body_arc_segments = 10, rim_arc_segments = 4;  // per quarter turn
constexpr float pi = std::numbers::pi_v<float>;

/// An arc from angle a to b (0: outward, pi/2: up).
void addArc(std::vector<ProfilePoint>& profile, float centre_r, float centre_z, float radius, float a, float b,
            int segments_per_quarter) {
  const int segments = static_cast<int>(std::ceil((b - a) / (pi / 2) - 1e-3F)) * segments_per_quarter;
  for (int i = 0; i <= segments; ++i) {
    const float angle = a + (b - a) * static_cast<float>(i) / static_cast<float>(segments);
    profile.emplace_back(std::max(0.0F, centre_r + radius * std::cos(angle)), centre_z + radius * std::sin(angle));
  }
}

/// A rod with rounded rims at both ends.
void addRod(SolidMesh& mesh, float z_begin, float z_end, float radius, float rim, Finish look) {
  std::vector<ProfilePoint> profile{{0, z_begin}};
  addArc(profile, radius - rim, z_begin + rim, rim, -pi / 2, 0, rim_arc_segments);
  addArc(profile, radius - rim, z_end - rim, rim, 0, pi / 2, rim_arc_segments);
  profile.emplace_back(0.0F, z_end);
  addTurned(mesh, profile, look);
}

/// A grip with shallow waves for the fingers.
void addGrip(SolidMesh& mesh, float z_begin, float z_end, float radius) {
  constexpr int waves = 7, steps = 6;
  const float rim = 0.35F * radius;
  std::vector<ProfilePoint> profile{{0, z_begin}};
  addArc(profile, radius - rim, z_begin + rim, rim, -pi / 2, 0, rim_arc_segments);
  for (int i = 1; i < waves * steps; ++i) {
    const float t = static_cast<float>(i) / (waves * steps);
    const float depth = 0.05F * radius * (0.5F - 0.5F * std::cos(2 * pi * waves * t));
    profile.emplace_back(radius - depth, z_begin + rim + t * (z_end - z_begin - 2.6F * rim));
  }
  addArc(profile, radius - 1.6F * rim, z_end - 1.6F * rim, 1.6F * rim, 0, pi / 2, rim_arc_segments);
  profile.emplace_back(0.0F, z_end);
  addTurned(mesh, profile, Finish::Grip);
}

// The handle beyond the tool's neck, in tool radii. It is only drawn; the contact knows the tool up to its length.
constexpr float neck_begin = 0.6F;  // below the tool's end
constexpr float collar_radius = 0.72F, collar_length = 0.7F;
constexpr float grip_radius = 0.85F, grip_length = 8.0F;

float handleBegin(const ToolShape& shape) {
  const double neck = toolType(shape.kind).neck_length * shape.radius;
  return static_cast<float>(toolProfile(shape).length + neck);
}

}  // namespace

void addTurned(SolidMesh& mesh, const std::vector<ProfilePoint>& profile, Finish finish) {
  const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto rings = static_cast<std::uint32_t>(profile.size());
  for (std::uint32_t i = 0; i < rings; ++i) {
    const ProfilePoint &before = profile[i > 0 ? i - 1 : i], &after = profile[std::min(i + 1, rings - 1)];
    const ProfilePoint along = (after - before).normalized();
    for (int s = 0; s <= turn_segments; ++s) {
      const float angle = 2 * pi * static_cast<float>(s) / turn_segments;
      const float c = std::cos(angle), d = std::sin(angle), r = profile[i].x();
      mesh.vertices.push_back(
          {{r * c, r * d, profile[i].y()}, {along.y() * c, along.y() * d, -along.x()}, static_cast<float>(finish)});
    }
  }
  constexpr std::uint32_t ring = turn_segments + 1;
  for (std::uint32_t i = 0; i + 1 < rings; ++i)
    for (std::uint32_t s = 0; s < turn_segments; ++s) {
      const std::uint32_t a = base + i * ring + s, b = a + 1, c = a + ring, d = c + 1;
      mesh.indices.insert(mesh.indices.end(), {a, b, d, a, d, c});
    }
}

SolidMesh toolMesh(const ToolShape& shape, bool has_handle) {
  SolidMesh mesh;
  const ToolProfile profile = toolProfile(shape);
  std::vector<ProfilePoint> body;
  for (const MeridianPoint& p : outline(profile)) body.emplace_back(static_cast<float>(p.r), static_cast<float>(p.z));
  addTurned(mesh, body, Finish::Steel);
  if (!has_handle) return mesh;
  const float R = static_cast<float>(shape.radius), L = static_cast<float>(profile.length);
  const float handle = handleBegin(shape), neck = static_cast<float>(toolType(shape.kind).neck_radius) * R;
  addRod(mesh, std::max(L - neck_begin * R, 0.5F * L), handle + 0.1F * R, neck, 0.02F * R, Finish::Steel);
  addRod(mesh, handle, handle + collar_length * R, collar_radius * R, 0.12F * R, Finish::Collar);
  addGrip(mesh, handle + 0.9F * collar_length * R, toolHandleEnd(shape), grip_radius * R);
  return mesh;
}

float toolHandleEnd(const ToolShape& shape) {
  return handleBegin(shape) + (0.9F * collar_length + grip_length) * static_cast<float>(shape.radius);
}

SolidMesh sphereMesh() {
  SolidMesh mesh;
  std::vector<ProfilePoint> profile;
  addArc(profile, 0, 0, 1, -pi / 2, pi / 2, body_arc_segments);
  addTurned(mesh, profile, Finish::Steel);
  return mesh;
}

SolidMesh arrowMesh() {
  constexpr float head_radius = 2.6F;
  SolidMesh mesh;
  addTurned(mesh, {{0, 0}, {1, 0}}, Finish::Steel);
  addTurned(mesh, {{1, 0}, {1, 1}}, Finish::Steel);
  addTurned(mesh, {{0, 2}, {head_radius, 2}}, Finish::Steel);
  addTurned(mesh, {{head_radius, 2}, {0, 3}}, Finish::Steel);
  return mesh;
}

}  // namespace palpate::app
