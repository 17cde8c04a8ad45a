#include "step/rigid_stop.h"

#include <catch2/catch.hpp>

#include <cmath>

#include "base/turn.h"
#include "batch/static_solver.h"
#include "contact/tools/tool_list.h"
#include "discretization/surface/surface_geometry.h"
#include "step/step.h"
#include "step/tool_bodies.h"
#include "step/trust.h"
#include "step/workspace.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;

namespace {

/// A ball of 10 mm, or another tool, before one rigid body.
Scene toolBefore(Region::Kind kind) {
  Scene scene = test::blockScene();
  RigidSpec body;
  body.name = "body";
  body.region.kind = kind;
  body.region.point = Vec3(0.2, 0, 0);
  body.region.radius = 0.03;
  body.region.min = Vec3(0.15, -0.05, -0.02);
  body.region.max = Vec3(0.25, 0.05, 0);
  scene.rigid = {body};
  return scene;
}

constexpr double spacing = 0.01;

/// Nodes on a grid of 9 x 9 x 4, the lowest layer held, and as skin the lowest and the highest layer.
Model slab(bool moved = false) {
  constexpr int n = 9, layers = 4;
  Model model;
  model.scene.discretization.spacing = spacing;
  model.tools.body[0].shape = model.scene.tools[0].shape = ToolShape::of(ToolKind::Sphere, 0.01);
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
  // Rows of all nodes around, of which heldTissue reads no weights.
  const auto addRow = [&](const Vec3& x, std::vector<int>& begin, std::vector<int>& node) {
    for (std::size_t j = 0; j < model.X.size(); ++j)
      if ((model.X[j] - x).norm() < 1.6 * spacing) node.push_back(static_cast<int>(j));
    begin.push_back(static_cast<int>(node.size()));
  };
  model.node_shape.begin = model.skin.begin = {0};
  for (const Vec3& x : model.X) addRow(x, model.node_shape.begin, model.node_shape.node);
  for (const Vec3& x : model.skin.surface.vertices) addRow(x, model.skin.begin, model.skin.node);
  model.bodies.normal = vertexNormals(model.skin.surface);
  model.essential.motions.emplace_back();
  if (moved) model.essential.motions[0].translation = Vec3(0, 0, 0.01);
  model.held = heldTissue(model);
  return model;
}

ToolPosture at(double x, double y, double z) {
  ToolPosture tool;
  tool.pose.position = Vec3(x, y, z);
  return tool;
}

/// What is left of a way.
Vec3 wayOf(const Model& model, const ToolPosture& from, const Vec3& move, const RigidStop& stop = {}) {
  ToolPosture wanted = from;
  wanted.pose.position += move;
  const ToolPosture to = stop.of(model, 0, from, wanted);
  return to.pose.position == wanted.pose.position ? move : Vec3(to.pose.position - from.pose.position);
}

constexpr double stand = HeldTissue::clearance * spacing;  // m, of the tip over a held vertex

constexpr double kept = 0.25 * 0.01;  // m, of the radius

/// A box that goes somewhere at constant speed.
RigidSpec plate(const Vec3& min, const Vec3& max, const Vec3& translation, double duration) {
  RigidSpec body;
  body.name = "plate";
  body.region.kind = Region::Kind::Box;
  body.region.min = min;
  body.region.max = max;
  body.motion.translation = translation;
  body.motion.duration = duration;
  body.motion.curve.kind = LoadCurve::Kind::Linear;
  return body;
}

/// The tools' ways alone, tick by tick, as if there were no tissue.
struct Ways {
  explicit Ways(const Model& the_model)
      : model(the_model), state(initialState(the_model)), command(restCommand(the_model)) {}

  /// Whether a tool came to be in a rigid body.
  bool tick() {
    const ToolWays ways(model, state, command);
    bool fails = false;
    for (std::size_t t = 0; t < state.tool.size(); ++t) {
      state.tool[t] = ways.end()[t];
      fails = fails || ways.fails(static_cast<int>(t));
    }
    state.step += model.substeps_per_tick;
    return fails;
  }
  double time() const { return static_cast<double>(state.step) * model.dt; }

  const Model& model;
  State state;
  Command command;
};

}  // namespace

TEST_CASE("A tool comes to stand before a rigid body and slides along it", "[simulation][rigid]") {
  Pose pose;
  SECTION("a ball over a box") {
    const Model model = test::blockModel(toolBefore(Region::Kind::Box));
    pose.position = Vec3(0.2, 0.01, -0.001);
    const Pose stopped = RigidStop{0, 0, 1}.of(model, 0, {pose, 0}, {pose, 0}).pose;
    CHECK((stopped.position - Vec3(0.2, 0.01, kept)).norm() < 1e-9);
    const Pose short_of = RigidStop{0, 0, 0.0005}.of(model, 0, {pose, 0}, {pose, 0}).pose;
    CHECK(short_of.position.z() == Approx(-0.0005));
    pose.position.z() = 0.01;
    CHECK(RigidStop{0, 0, 1}.of(model, 0, {pose, 0}, {pose, 0}).pose.position == pose.position);  // to the bit
  }
  SECTION("a ball beside a ball") {
    const Model model = test::blockModel(toolBefore(Region::Kind::Sphere));
    pose.position = Vec3(0.215, 0, 0.015);
    const Vec3 middle = RigidStop{0, 0, 1}.of(model, 0, {pose, 0}, {pose, 0}).pose.position + Vec3(0, 0, 0.01);
    CHECK((middle - Vec3(0.2, 0, 0)).norm() == Approx(0.04 + kept));
  }
  SECTION("a capsule that lies, the middle of its side first") {
    Scene scene = toolBefore(Region::Kind::Sphere);
    scene.tools[0].shape = ToolShape::of(ToolKind::Capsule, 0.01, 0.08);
    const Model model = test::blockModel(scene);
    pose.orientation = uprightOn(Vec3::UnitY());
    pose.position = Vec3(0.2, -0.042, 0.035);
    const Vec3 at = RigidStop{0, 0, 1}.of(model, 0, {pose, 0}, {pose, 0}).pose.position;
    CHECK(at.z() == Approx(0.04 + kept).margin(2e-4));
  }
}

TEST_CASE("A rigid body that moves takes every tool along, however fast and thin, and however slow the hand",
          "[simulation][rigid]") {
  const double top = 0.1, length = 0.03;  // m
  Scene scene = toolBefore(Region::Kind::Box);
  scene.rigid = {plate(Vec3(0.15, -0.05, top), Vec3(0.25, 0.05, top + 0.0005), Vec3(0, 0, -0.08), 1)};
  scene.tools[0].position = Vec3(0.2, 0.01, 0.06);
  scene.tools[0].max_speed = 0.02;
  scene.tools.push_back(scene.tools[0]);
  scene.tools[1].position.x() = 0.21;
  scene.tools[1].max_speed = 10;
  Model model = test::blockModel(scene);
  for (const ToolKind kind : {ToolKind::Sphere, ToolKind::FlatCylinder, ToolKind::Capsule, ToolKind::Cone})
    for (const double radius : {0.0006, 0.01})
      for (const double duration : {2.0, 0.016}) {  // 40 mm/s, 5 m/s
        CAPTURE(static_cast<int>(kind), radius, duration);
        for (ToolBody& body : model.tools.body) body.shape = ToolShape::of(kind, radius, length);
        model.rigid.body[0].motion.duration = duration;
        const double high = kind == ToolKind::Sphere ? 2 * radius : length;
        const double off = 0.25 * std::min(scene.discretization.spacing, radius);
        Ways ways(model);
        while (ways.time() < 1.05 * duration) {
          REQUIRE_FALSE(ways.tick());
          for (const ToolPosture& tool : ways.state.tool)
            REQUIRE(tool.pose.position.z() + high < top - 0.08 * std::min(1.0, ways.time() / duration) - 0.9 * off);
        }
        for (const ToolPosture& tool : ways.state.tool)  // and no further
          CHECK(tool.pose.position.z() + high == Approx(top - 0.08 - off).margin(1e-9));
        // The hand waits above. Once it comes from below, its tool follows it as fast as it may.
        ways.command.tools[0].pose.position.z() = ways.state.tool[0].pose.position.z() - 0.01;
        const double before = ways.state.tool[0].pose.position.z();
        ways.tick();
        CHECK(before - ways.state.tool[0].pose.position.z() == Approx(0.02 / scene.dynamics.rate_hz));
      }
}

TEST_CASE("A paddle that turns takes a tool along", "[simulation][rigid]") {
  Scene scene = toolBefore(Region::Kind::Box);
  RigidSpec paddle = plate(Vec3(0.2, 0.011, 0), Vec3(0.26, 0.012, 0.1), Vec3::Zero(), 0.1);
  paddle.motion.axis_point = Vec3(0.2, 0.011, 0);
  paddle.motion.axis = Vec3::UnitZ();
  paddle.motion.angle = -M_PI;
  scene.rigid = {paddle};
  scene.tools[0].position = Vec3(0.23, -0.005, 0.03);
  scene.tools[0].max_speed = 0.1;
  const Model model = test::blockModel(scene);
  Ways ways(model);
  while (ways.time() < 0.1) {
    REQUIRE_FALSE(ways.tick());
    const Vec3 middle = ways.state.tool[0].pose.position + Vec3(0, 0, 0.01);
    const Vec3 local = model.rigid.body[0].at(ways.time()).toLocal(middle);
    REQUIRE(local.y() < 0.011);
    CHECK((local.x() > 0.26 || local.x() < 0.2 || local.y() < 0.001 + 1e-9));
  }
  CHECK(ways.state.tool[0].pose.position.y() > 0.02);  // half around, though the hand is where it began
}

TEST_CASE("A tool that two rigid bodies squeeze, or jaws about one, are in them, which is doubted",
          "[simulation][rigid]") {
  Scene scene = toolBefore(Region::Kind::Box);
  SECTION("squeezed") {  // over skin
    scene.rigid = {plate(Vec3(0.0126, -0.05, 0.031), Vec3(0.02, 0.05, 0.06), Vec3(-0.006, 0, 0), 0.1),
                   plate(Vec3(-0.02, -0.05, 0.031), Vec3(-0.0126, 0.05, 0.06), Vec3::Zero(), 0.1)};
    const Model model = test::blockModel(scene);
    State state = initialState(model);
    Workspace workspace(model, 1);
    const Command command = restCommand(model);
    while (true) {
      const StepReport report = tick(model, state, command, workspace);
      const double time = static_cast<double>(state.step) * model.dt;
      if (time > 0.1) break;
      const double left = 0.0252 - 0.06 * time;  // m, between the plates
      CAPTURE(left);
      if (left > 0.0201 + kept) CHECK(doubtOf(model, report) != Doubt::Contact);
      if (left < 0.0199) CHECK(doubtOf(model, report) == Doubt::Contact);
    }
  }
  SECTION("jaws") {
    scene.tools[0].position = Vec3(0.2, 0, 0.06);
    scene.rigid = {plate(Vec3(0.199, -0.05, 0.04), Vec3(0.201, 0.05, 0.2), Vec3::Zero(), 1)};
    scene.tools[0].opening = 0.01;
    scene.tools[0].shape = ToolShape::of(ToolKind::Capsule, 0.002, 0.03);
    const Model model = test::blockModel(scene);
    Ways ways(model);
    CHECK_FALSE(ways.tick());
    ways.command.tools[0].opening = 0;
    bool fails = false;
    for (int k = 0; k < 20; ++k) fails = ways.tick();
    CHECK(fails);
  }
}

TEST_CASE("A plate presses a tool into tissue as a hand does, though the hand holds it with less",
          "[simulation][rigid][whole]") {
  Scene scene = test::blockScene();
  scene.dynamics.damping = 200;
  const Model by_hand = test::blockModel(scene);
  scene.tools[0].max_speed = 0.01;
  scene.tools[0].max_force = 0.05;
  scene.rigid = {plate(Vec3(-0.05, -0.05, 0.0545), Vec3(0.05, 0.05, 0.06), Vec3(0, 0, -0.007), 0.3)};
  const Model by_plate = test::blockModel(scene);
  const auto pressed = [](const Model& model, double travel, double& tip) {
    State state = initialState(model);
    Workspace workspace(model, 1);
    const StepReport report =
        test::moveAlong(model, state, workspace, 300, [&](int k) { return travel * std::min(1.0, k / 150.0); });
    tip = state.tool[0].pose.position.z();
    return report.loads[0].force.z();
  };
  double of_hand, of_plate;
  const double force = pressed(by_hand, 0.007, of_hand);
  CHECK(force > 0.1);
  CHECK(pressed(by_plate, 0, of_plate) == Approx(force).epsilon(0.01));
  CHECK(of_plate == Approx(of_hand).margin(2e-5));
}

TEST_CASE("A tool that starts inside a rigid body is refused, one that touches it is not", "[simulation][rigid]") {
  Scene scene = toolBefore(Region::Kind::Sphere);
  scene.tools[0].position = Vec3(0.2, 0, 0.0301);
  CHECK_NOTHROW(checkToolStarts(test::blockModel(scene)));
  scene.tools[0].position.z() = 0.0299;
  CHECK_THAT(refusal([&] { checkToolStarts(test::blockModel(scene)); }),
             Catch::Contains("tool 1 starts inside the rigid body body"));
}

TEST_CASE("A tool under a hand that goes through the table does not, nor does the tissue",
          "[simulation][rigid][whole]") {
  Scene scene = test::blockScene();
  scene.boundaries.clear();
  scene.dynamics.gravity = Vec3(0, 0, -9.81);
  RigidSpec table;
  table.name = "table";
  table.friction = 0.5;
  scene.rigid = {table};
  scene.tools[0].max_speed = 0.3;
  const Model model = test::blockModel(scene);
  State state = initialState(model);
  Workspace workspace(model, 1);
  const StepReport report = test::moveAlong(model, state, workspace, 250, [](int) { return 0.08; });
  CHECK(report.loads[0].stopped);
  CHECK((report.flags & (kNotFinite | kBlowUp)) == 0);
  CHECK(state.tool[0].pose.position.z() > 0.9 * kept);
  double lowest = 0;
  for (int v = 0; v < model.skin.vertexCount(); ++v)
    lowest = std::min(lowest, skinPosition(model.skin, v, state.u.data()).z());
  CHECK(lowest > -2e-3);  // between the points that touch, which are half a spacing apart
}

TEST_CASE("A tool comes to stand a quarter of the spacing before what holds the organ", "[simulation][rigid]") {
  const Model model = slab();
  ToolPosture tool = at(0, 0, 0.02);
  for (int tick = 0; tick < 100; ++tick) tool.pose.position += wayOf(model, tool, Vec3(0, 0, -2e-3));
  CHECK(tool.pose.position.isApprox(Vec3(0, 0, stand), 1e-9));
  // Between four held vertices a ball sinks no deeper than it must, and stays under the hand there, too.
  tool = at(0.005, 0.005, 0.02);
  for (int tick = 0; tick < 100; ++tick) tool.pose.position += wayOf(model, tool, Vec3(0, 0, -2e-3));
  const double radius = 0.01, reach = radius + stand, aside = std::sqrt(0.5) * spacing;
  CHECK(tool.pose.position.head<2>() == Vec3(0.005, 0.005, 0).head<2>());
  CHECK(tool.pose.position.z() == Approx(std::sqrt(reach * reach - aside * aside) - radius).margin(2e-6));
  // A hand that draws sideways takes it along, and up again it is free.
  const Vec3 along = wayOf(model, tool, Vec3(1e-3, 0, -1e-3));
  CHECK(along.x() > 0.5e-3);
  CHECK(wayOf(model, tool, Vec3(0, 0, 2e-3)) == Vec3(0, 0, 2e-3));
}

TEST_CASE("Where nothing held is near, the tool goes all of its way, to the bit", "[simulation][rigid]") {
  const Vec3 down(0.1e-3, -0.2e-3, -1.9e-3);
  const Model model = slab();
  CHECK(wayOf(model, at(0, 0, stand + 2e-3), down) == down);
  CHECK(wayOf(model, at(0.2, 0, 0), down) == down);
  // From outside it meets held skin as any skin.
  CHECK(wayOf(model, at(0, 0, -0.021), -down) == -down);
  CHECK(wayOf(model, at(0, 0, -0.0205), Vec3(0, 0, 1e-3)) == Vec3(0, 0, 1e-3));
  // What begins too near may leave, but not come nearer.
  CHECK(wayOf(model, at(0, 0, 0), Vec3(0, 0, 1e-3)) == Vec3(0, 0, 1e-3));
  CHECK(wayOf(model, at(0, 0, 1e-4), Vec3(0, 0, -1e-3)).norm() < 1e-12);
  // What it has passed from outside is behind it: across the plane of the skin it is free.
  for (const Vec3& way : {Vec3(1e-3, 0, 0), Vec3(0, -1e-3, 0), Vec3(0, 0, 1e-3)})
    CHECK(wayOf(model, at(0, 0, -0.0095), way) == way);
}

TEST_CASE("Only what no scene moves and no component frees is rigid - held nodes inside are, too",
          "[simulation][rigid]") {
  CHECK(slab(true).held.empty());
  Model sliding = slab();
  for (ImposedNode& node : sliding.essential.nodes) node.boundary[0] = -1;
  CHECK(heldTissue(sliding).empty());

  Model thick = slab();
  for (int i = 81; i < 162; ++i) thick.essential.nodes.push_back({i, {0, 0, 0}});  // the layer above it
  thick.held = heldTissue(thick);
  ToolPosture tool = at(0, 0, 0.025);
  for (int tick = 0; tick < 100; ++tick) tool.pose.position += wayOf(thick, tool, Vec3(0, 0, -2e-3));
  CHECK(tool.pose.position.isApprox(Vec3(0, 0, spacing + stand), 1e-9));

  // A region that was moved live holds where it is, each component by who holds it; those beyond the sixteenth stand.
  Model model = slab();
  for (ImposedNode& node : model.essential.nodes) node.boundary = {17, 17, 0};
  model.essential.motions.resize(18);
  model.held = heldTissue(model);
  RigidStop stop;
  stop.shifts.of[0] = Vec3(0, 0, 0.005);
  tool = at(0, 0, 0.025);
  for (int tick = 0; tick < 100; ++tick) tool.pose.position += wayOf(model, tool, Vec3(0, 0, -2e-3), stop);
  CHECK(tool.pose.position.isApprox(Vec3(0, 0, 0.005 + stand), 1e-9));
}

TEST_CASE("No tool goes through what holds the organ, whatever its shape and however far its way",
          "[simulation][rigid]") {
  for (const ToolKind kind : {ToolKind::Sphere, ToolKind::FlatCylinder, ToolKind::Capsule, ToolKind::Cone}) {
    Model model = slab();
    model.tools.body[0].shape = model.scene.tools[0].shape = ToolShape::of(kind, 0.01, 0.05);
    const Vec3 hand(0.002, -0.003, -1);
    ToolPosture tool = at(hand.x(), hand.y(), 0.02);
    for (int tick = 0; tick < 200; ++tick)  // at the tool's greatest speed
      tool.pose.position += wayOf(model, tool, 2e-3 * (hand - tool.pose.position).normalized());
    INFO(static_cast<int>(kind));
    CHECK(tool.pose.position.z() > 0);
    CHECK(tool.pose.position.z() < 0.5 * spacing);
    CHECK(tool.pose.position.head<2>().isApprox(hand.head<2>(), 1e-9));
    // A batch solution goes there in one step, and comes out in one.
    ToolsAt from(at(hand.x(), hand.y(), 0.02).pose), below(Pose{hand, Quat::Identity()});
    const ToolsAt there = stoppedByRigid(model, from, below, 0);
    CHECK((there.posture[0].pose.position - tool.pose.position).norm() < 1e-4);
    CHECK(stoppedByRigid(model, there, from, 0).posture[0].pose.position == from.posture[0].pose.position);
  }
}

TEST_CASE("An equilibrium has its tool before what holds the body, not behind it", "[simulation][rigid][whole]") {
  const Model model = test::blockModel(test::blockScene());
  StaticSolver solver(model, 2, 1e-3);
  Pose pose = test::toolAt(model, 0.005);
  REQUIRE(solver.advanceTo(0, pose).converged);
  CHECK(solver.body().tools().posture[0].pose.position == pose.position);
  const double bottom = boundingBox(model.skin.surface).min().z();
  pose.position.z() = bottom - 0.01;
  const Equilibrium equilibrium = solver.advanceTo(0, pose);
  CHECK(solver.body().tools().posture[0].pose.position.z() > bottom);
  CHECK(equilibrium.doubt != Doubt::None);
}
