#pragma once

#include <algorithm>
#include <array>

#include "discretization/surface/solids.h"
#include "setup/build_model.h"
#include "step/step.h"
#include "step/tool_bodies.h"

namespace palpate::test {

/// Imposed on what is on a plane.
inline BoundarySpec planeBoundary(const Vec3& point, const Vec3& normal = Vec3::UnitZ(),
                                  const std::array<bool, 3>& components = {true, true, true}) {
  BoundarySpec b;
  b.region.kind = Region::Kind::NearPlane;
  b.region.point = point;
  b.region.normal = normal;
  b.region.distance = 1e-6;
  std::copy(components.begin(), components.end(), b.component);
  return b;
}

/// A plane to which `component` is normal, and along which all may slide.
inline BoundarySpec roller(const Vec3& point, int component) {
  return planeBoundary(point, Vec3::Unit(component), {component == 0, component == 1, component == 2});
}

/// A block of 60 x 60 x 30 mm on a fixed base under a sphere of 10 mm: small enough to step in a test.
inline Scene blockScene(double spacing = 0.012) {
  Scene scene;
  scene.name = "block";
  scene.organs[0].solid = OrganSpec::Solid::Box;
  scene.organs[0].size = Vec3(0.06, 0.06, 0.03);
  scene.discretization.spacing = spacing;
  scene.discretization.quadrature.points_per_cell = 1;
  scene.materials.emplace_back();
  scene.materials[0].material.set("young", 3000);
  scene.materials[0].material.set("poisson", 0.48);
  scene.boundaries = {planeBoundary(Vec3::Zero())};
  scene.dynamics.damping = 60;
  scene.tools[0].shape.radius = 0.01;
  scene.tools[0].position = Vec3(0, 0, 0.032);
  return scene;
}

/// A bar of 160 x 50 x 30 mm on a fixed base under a ball of 8 mm: one that a cloud can follow (setup/place.h).
inline Scene barScene() {
  Scene scene = blockScene();
  scene.organs[0].size = Vec3(0.16, 0.05, 0.03);
  scene.materials[0].material.set("poisson", 0.45);
  scene.discretization.quadrature.cells_per_point = 1.32;
  scene.tools[0].shape.radius = 0.008;
  return scene;
}

inline const TriangleSurface& barSurface() {
  static const TriangleSurface surface = boxSurface(barScene().organs[0].size, 0.01);
  return surface;
}

inline Model blockModel(const Scene& scene = blockScene()) {
  return buildModel(scene, boxSurface(scene.organs[0].size, 0.004));
}

/// The tool's start pose moved by `travel` along its axis and `slide` in x.
inline Pose toolAt(const Model& model, double travel, double slide = 0) {
  Pose pose = model.tools.first().start.pose;
  pose.position += travel * (pose.orientation * -Vec3::UnitZ()) + slide * Vec3::UnitX();
  return pose;
}

/// Moves the first tool, in tick k from 1 on by `travelAt(k)` from its start; others stand. Returns the last tick's
/// report, but with the flags of all.
template <class TravelAt>
StepReport moveAlong(const Model& model, State& state, Workspace& workspace, int ticks, TravelAt&& travelAt) {
  Command command = restCommand(model);
  StepReport report;
  std::uint32_t flags = 0;
  for (int k = 1; k <= ticks; ++k) {
    command.tools[0].pose = toolAt(model, travelAt(k));
    report = tick(model, state, command, workspace);
    flags |= report.flags;
  }
  report.flags = flags;
  return report;
}

}  // namespace palpate::test
