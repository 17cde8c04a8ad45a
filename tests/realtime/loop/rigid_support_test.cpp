#include "realtime/loop/rigid_support.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "contact/tools/tool_list.h"
#include "realtime/fakes.h"
#include "realtime/loop/tool_proxy.h"

using namespace palpate;

namespace {

constexpr double spacing = 0.01;

/// Nodes on a grid of 9 x 9 x 4, the lowest layer held, and as skin the lowest and the highest layer.
Model slab(bool moved = false) {
  constexpr int n = 9, layers = 4;
  Model model = test::smallModel(500);
  model.scene.discretization.spacing = spacing;
  model.tools.body[0].shape = model.scene.tools[0].shape = ToolShape::of(ToolKind::Sphere, 0.01);
  model.X.clear();
  model.skin.surface = {};
  const auto at = [](int i, int j, int k) { return Vec3(spacing * (i - n / 2), spacing * (j - n / 2), spacing * k); };
  for (int k = 0; k < layers; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        if (k == 0) model.essential.nodes.push_back({static_cast<int>(model.X.size()), {0, 0, 0}});
        model.X.push_back(at(i, j, k));
      }
  for (const int k : {0, layers - 1}) {
    const int first = static_cast<int>(model.skin.surface.vertices.size());
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) model.skin.surface.vertices.push_back(at(i, j, k));
    for (int j = 0; j + 1 < n; ++j)
      for (int i = 0; i + 1 < n; ++i) {
        const int a = first + j * n + i, d = a + n + 1;
        int b = a + 1, c = a + n;
        if (k == 0) std::swap(b, c);  // outward is down
        model.skin.surface.triangles.push_back({a, b, d});
        model.skin.surface.triangles.push_back({a, d, c});
      }
  }
  model.essential.motions.emplace_back();
  if (moved) model.essential.motions[0].translation = Vec3(0, 0, 0.01);
  return model;
}

ToolPosture at(double x, double y, double z) {
  ToolPosture tool;
  tool.pose.position = Vec3(x, y, z);
  return tool;
}

constexpr double stand = RigidSupport::clearance * spacing;  // m, of the tip over a held vertex

}  // namespace

TEST_CASE("A tool comes to stand a quarter of the spacing before what holds the organ", "[rigid_support]") {
  const RigidSupport support(slab());
  ToolPosture tool = at(0, 0, 0.02);
  for (int tick = 0; tick < 100; ++tick) tool.pose.position += support.stop(tool, Vec3(0, 0, -2e-3));
  CHECK(tool.pose.position.isApprox(Vec3(0, 0, stand), 1e-9));
  // Between four held vertices a ball sinks no deeper than it must, and stays under the hand there, too.
  tool = at(0.005, 0.005, 0.02);
  for (int tick = 0; tick < 100; ++tick) tool.pose.position += support.stop(tool, Vec3(0, 0, -2e-3));
  const double radius = 0.01, reach = radius + stand, aside = std::sqrt(0.5) * spacing;
  CHECK(tool.pose.position.head<2>() == Vec3(0.005, 0.005, 0).head<2>());
  CHECK(tool.pose.position.z() == Approx(std::sqrt(reach * reach - aside * aside) - radius).margin(2e-6));
  // A hand that draws sideways takes it along, and up again it is free.
  const Vec3 along = support.stop(tool, Vec3(1e-3, 0, -1e-3));
  CHECK(along.x() > 0.5e-3);
  CHECK(support.stop(tool, Vec3(0, 0, 2e-3)) == Vec3(0, 0, 2e-3));
}

TEST_CASE("Where nothing held is near, the tool goes all of its way, to the bit", "[rigid_support]") {
  const Vec3 down(0.1e-3, -0.2e-3, -1.9e-3);
  const RigidSupport support(slab());
  CHECK(support.stop(at(0, 0, stand + 2e-3), down) == down);
  CHECK(support.stop(at(0.2, 0, 0), down) == down);
  // From outside it meets held skin as any skin.
  CHECK(support.stop(at(0, 0, -0.021), -down) == -down);
  CHECK(support.stop(at(0, 0, -0.0205), Vec3(0, 0, 1e-3)) == Vec3(0, 0, 1e-3));
  // What begins too near may leave, but not come nearer.
  CHECK(support.stop(at(0, 0, 0), Vec3(0, 0, 1e-3)) == Vec3(0, 0, 1e-3));
  CHECK(support.stop(at(0, 0, 1e-4), Vec3(0, 0, -1e-3)).norm() < 1e-12);
  // What it has passed from outside is behind it: across the plane of the skin it is free.
  for (const Vec3& way : {Vec3(1e-3, 0, 0), Vec3(0, -1e-3, 0), Vec3(0, 0, 1e-3)})
    CHECK(support.stop(at(0, 0, -0.0095), way) == way);
}

TEST_CASE("Only what no boundary moves and no component frees is rigid - held nodes inside are, too",
          "[rigid_support]") {
  CHECK(RigidSupport(slab(true)).empty());
  Model sliding = slab();
  for (ImposedNode& node : sliding.essential.nodes) node.boundary[0] = -1;
  CHECK(RigidSupport(sliding).empty());

  Model thick = slab();
  for (int i = 81; i < 162; ++i) thick.essential.nodes.push_back({i, {0, 0, 0}});  // the layer above it
  const RigidSupport support(thick);
  ToolPosture tool = at(0, 0, 0.025);
  for (int tick = 0; tick < 100; ++tick) tool.pose.position += support.stop(tool, Vec3(0, 0, -2e-3));
  CHECK(tool.pose.position.isApprox(Vec3(0, 0, spacing + stand), 1e-9));
}

TEST_CASE("No tool is pushed through what holds the organ, whatever its shape and wherever its hand is",
          "[rigid_support]") {
  for (const ToolKind kind : {ToolKind::Sphere, ToolKind::FlatCylinder, ToolKind::Capsule, ToolKind::Cone}) {
    Model model = slab();
    model.tools.body[0].shape = model.scene.tools[0].shape = ToolShape::of(kind, 0.01, 0.05);
    ToolProxy proxy(model);
    State state;
    state.u.resize(4);
    state.tool[0].pose.position = Vec3(0.002, -0.003, 0.02);
    Pose hand;
    hand.position = Vec3(0.002, -0.003, -1);
    const auto go = [&] {  // at the tool's greatest speed
      const Vec3 way = proxy.follow(ToolPosture{hand}, state, {}).pose.position - state.tool[0].pose.position;
      state.tool[0].pose.position += std::min(1.0, 2e-3 / std::max(way.norm(), 1e-12)) * way;
    };
    for (int tick = 0; tick < 200; ++tick) go();
    INFO(static_cast<int>(kind));
    CHECK(state.tool[0].pose.position.z() > 0);
    CHECK(state.tool[0].pose.position.z() < 0.5 * spacing);
    CHECK(state.tool[0].pose.position.head<2>().isApprox(hand.position.head<2>(), 1e-9));
    CHECK(proxy.yieldAfter(hand, state, {}) == Approx((hand.position - state.tool[0].pose.position).norm()));
    hand.position.z() = 0.05;  // and it comes out as it went in
    for (int tick = 0; tick < 50; ++tick) go();
    CHECK(state.tool[0].pose.position == hand.position);
    hand.position.z() = -1;  // not when it lets the tissue go, either
    ToolProxy::Memory letting_go;
    letting_go.lets_go = true;
    proxy.recall(letting_go);
    for (int tick = 0; tick < 200; ++tick) go();
    CHECK(proxy.letsGo());
    CHECK(state.tool[0].pose.position.z() > 0);
  }
}
