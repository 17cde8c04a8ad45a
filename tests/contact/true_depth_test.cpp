#include "contact/true_depth.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "contact/contact.h"
#include "contact/tools/tool_list.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

/// A skin of the plane z = 0, and a tool that touches it from above, tilted about y.
struct PlaneAndTool {
  explicit PlaneAndTool(const ToolShape& tool_shape, double tilt) : tool(tool_shape) {
    for (int i = -20; i <= 20; ++i)
      for (int j = -20; j <= 20; ++j) skin.surface.vertices.emplace_back(1e-3 * i, 1e-3 * j, 0);
    for (int at = 0; at < 40 * 41; ++at)
      if (at % 41 < 40) {
        skin.surface.triangles.push_back({at, at + 41, at + 42});
        skin.surface.triangles.push_back({at, at + 42, at + 1});
      }
    // One cluster in one region holds all.
    const auto count = static_cast<int>(skin.surface.vertices.size());
    skin.cluster_begin = skin.region_begin = {0, count};
    skin.region_begin = {0, 1};
    skin.cluster_representative = skin.region_representative = {count / 2};
    skin.cluster_radius = skin.region_radius = {0.03F};
    for (int v = 0; v < count; ++v) skin.cluster_vertex.push_back(v);
    pose.orientation = Quat(Eigen::AngleAxisd(tilt, Vec3::UnitY()));
  }

  /// Height of the tool's lowest point over the plane of its tip, in the present turn.
  double lowest() const {
    const ToolProfile profile = toolProfile(tool);
    double low = 1;
    for (const MeridianPoint& p : outline(profile))
      for (const double side : {-1.0, 1.0}) low = std::min(low, (pose.orientation * Vec3(side * p.r, 0, p.z)).z());
    return low;
  }

  SkinModel skin;
  ToolShape tool;
  Pose pose;
};

}  // namespace

TEST_CASE("In air the depth is the gap, of any tool in any turn", "[true_depth]") {
  for (const ToolType* type : toolTypes())
    for (const double tilt : {0.0, 0.3, 1.2}) {
      const auto kind =
          static_cast<ToolKind>(std::find(toolTypes().begin(), toolTypes().end(), type) - toolTypes().begin());
      PlaneAndTool at(ToolShape::of(kind, 0.008), tilt);
      at.pose.position.z() = 0.005 - at.lowest();
      const TrueDepth depth(at.skin, at.tool);
      CAPTURE(type->name, tilt);
      // A vertex lies within 0.71 mm of the foremost point: over a radius of 2.4 mm that is 0.11 mm at most.
      CHECK(depth.of(at.pose, ContactState{}) == Approx(-0.005).margin(1.2e-4));
      at.pose.position.z() -= 0.006;  // where the skin was, but is no more: it has sunk
      CHECK(depth.of(at.pose, ContactState{}) == 0);
    }
}

TEST_CASE("Where it touches, the depth is how far the tool reaches beyond the skin at rest, along the contact",
          "[true_depth]") {
  for (const ToolKind kind : {ToolKind::Sphere, ToolKind::FlatCylinder, ToolKind::Capsule})
    for (const double tilt : {0.0, 0.3}) {
      if (kind == ToolKind::FlatCylinder && tilt > 0) continue;  // its face is not on its foremost point
      PlaneAndTool at(ToolShape::of(kind, 0.008), tilt);
      at.pose.position.z() = -0.004 - at.lowest();
      ContactState contact;
      const ToolProfile profile = toolProfile(at.tool);
      for (int v = 0; v < static_cast<int>(at.skin.surface.vertices.size()); ++v) {
        // The plane is bent to where the tool is: each vertex within 3 mm of the foremost point is touched there.
        const Vec3 foremost = at.pose.orientation.conjugate() * -Vec3::UnitZ();
        const Vec3& X = at.skin.surface.vertices[static_cast<std::size_t>(v)];
        const ToolDistance d = toolDistance(profile, at.pose.toLocal(X));
        if (d.normal.dot(foremost) < 0.9 || d.distance > 0) continue;
        contact.vertex.push_back(v);
        contact.normal.push_back(d.normal.cast<float>());
        contact.force.push_back(toFloat4(at.pose.orientation * d.normal));
        ++contact.count;
      }
      REQUIRE(contact.count > 3);
      CAPTURE(toolType(kind).name, tilt);
      CHECK(TrueDepth(at.skin, at.tool).of(at.pose, contact) == Approx(0.004).epsilon(0.05));
    }
}

TEST_CASE("A flat end is as deep as its face, however much more one side of its rim pushes", "[true_depth]") {
  PlaneAndTool at(ToolShape::of(ToolKind::FlatCylinder, 0.008), 0);
  at.pose.position.z() = -0.004 - at.lowest();
  ContactState contact;
  const auto touch = [&](int v, const Vec3& normal, double force) {
    contact.vertex.push_back(v);
    contact.normal.push_back(normal.cast<float>());
    contact.force.push_back(toFloat4(Vec3(force * normal)));
    ++contact.count;
  };
  for (int v = 0; v < static_cast<int>(at.skin.surface.vertices.size()); ++v) {
    const Vec3& X = at.skin.surface.vertices[static_cast<std::size_t>(v)];
    if (X.norm() < 0.0065) touch(v, -Vec3::UnitZ(), 1);
    if (X.norm() >= 0.0065 && X.norm() < 0.008)
      touch(v, (X.normalized() - Vec3::UnitZ()).normalized(), X.x() > 0 ? 3 : 1);
  }
  // The force leans by 8 degrees: along it the rim is 1.1 mm ahead.
  CHECK(TrueDepth(at.skin, at.tool).of(at.pose, contact) == Approx(0.004).epsilon(0.01));
}

TEST_CASE("A ball that just touches skin that leans there is not in it", "[true_depth]") {
  PlaneAndTool at(ToolShape::of(ToolKind::Sphere, 0.008), 0);
  for (Vec3& X : at.skin.surface.vertices) X.z() = -0.25 * X.x();  // by 14 degrees
  const int v = 20 * 41 + 25;
  at.pose.position = at.skin.surface.vertices[v];
  ContactState contact;
  contact.vertex = {v};
  contact.normal = {-Vec3f::UnitZ()};
  contact.force = {toFloat4(-0.001 * Vec3::UnitZ())};
  contact.count = 1;
  CHECK(TrueDepth(at.skin, at.tool).of(at.pose, contact) < 1e-9);  // along the skin's normal 0.24 mm
}

TEST_CASE("A ball that goes straight in is as deep as it has come past the touch, and the gap ends there",
          "[true_depth]") {
  const Model model = test::blockModel();
  const TrueDepth depth(model.skin, model.scene.tools[0].shape);
  State state = initialState(model);
  Workspace workspace(model, 1);
  double last = depth.of(state.tool[0].pose, state.contact[0]), largest_step = 0;
  CHECK(last == Approx(-0.002).epsilon(0.05));
  for (int k = 1; k <= 150; ++k) {
    Command command;
    command.tools[0].pose = test::toolAt(model, 4e-5 * k);
    tick(model, state, command, workspace);
    const double now = depth.of(state.tool[0].pose, state.contact[0]);
    largest_step = std::max(largest_step, std::abs(now - last - 4e-5));
    last = now;
  }
  CHECK(last == Approx(0.004).epsilon(0.05));
  CHECK(largest_step < 2.5e-4);  // 0.025 of the radius: as late as vertices feel the first touch
}

TEST_CASE("Vertices that come under the tip and leave it move the depth no further than the tool", "[true_depth]") {
  // A dome of 30 mm radius, vertices 0.35 radii of the ball apart, which slides down it, 4 mm deep. It has turned.
  const Quat turn(Eigen::AngleAxisd(0.4, Vec3::UnitY()));
  PlaneAndTool at(ToolShape::of(ToolKind::Sphere, 0.008), 0);
  for (Vec3& X : at.skin.surface.vertices) {
    X *= 2.8;
    X.z() = -X.squaredNorm() / (2 * 0.03);
  }
  const ToolProfile profile = toolProfile(at.tool);
  double last = 0, largest_change = 0;
  for (int k = 0; k <= 60; ++k) {
    at.pose.position = Vec3(1e-4 * k, 0.3e-4 * k, -0.004);
    ContactState contact;
    for (int v = 0; v < static_cast<int>(at.skin.surface.vertices.size()); ++v) {
      const Vec3& X = at.skin.surface.vertices[static_cast<std::size_t>(v)];
      const ToolDistance d = toolDistance(profile, at.pose.toLocal(turn * X));
      if (d.distance > 0) continue;
      contact.vertex.push_back(v);
      contact.normal.push_back(d.normal.cast<float>());
      contact.force.push_back(toFloat4(Vec3(-d.distance * d.normal)));
      ++contact.count;
    }
    REQUIRE(contact.count > 3);
    const double now = TrueDepth(at.skin, at.tool).of(at.pose, contact);
    if (k > 0) largest_change = std::max(largest_change, std::abs(now - last));
    last = now;
  }
  CHECK(largest_change < 1e-4);
}
