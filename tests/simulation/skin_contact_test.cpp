#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "discretization/surface/surface_bodies.h"
#include "discretization/surface/surface_tree.h"
#include "io/load_model.h"
#include "model/model_hash.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/cubes.h"
#include "support/realtime_guard.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;

namespace {

constexpr double block = 0.02, apart = 1e-3;  // m

void addBoundary(Scene& scene, int organ, const Vec3& point, const Vec3& normal, std::array<bool, 3> components,
                 double down = 0) {
  BoundarySpec wall = test::planeBoundary(point, normal, components);
  wall.name = "wall " + std::to_string(scene.boundaries.size() + 1);
  wall.organ = organ;
  wall.translation = Vec3(0, 0, -down);
  wall.duration = down > 0 ? 0.1 : 0;
  scene.boundaries.push_back(wall);
}

/// Two cubes between sliding walls, one a millimetre above the other, which comes down.
Scene twoBlocks(double down, double shift = 0) {
  Scene scene = test::blockScene(0.006);
  scene.boundaries.clear();
  scene.organs[0].size = Vec3::Constant(block);
  scene.organs.push_back(scene.organs[0]);
  scene.organs[1].position = Vec3(shift, 0, block + apart);
  scene.materials[0].material.set("poisson", 0.3);
  scene.tools[0].position = Vec3(0, 0, 0.2);
  scene.tools[0].shape.radius = 0.01;
  for (const int organ : {0, 1}) {
    const double x = organ * shift;
    for (const double side : {-0.5, 0.5}) {
      addBoundary(scene, organ, Vec3(x + side * block, 0, 0), Vec3::UnitX(), {true, false, false});
      addBoundary(scene, organ, Vec3(0, side * block, 0), Vec3::UnitY(), {false, true, false});
    }
  }
  addBoundary(scene, 0, Vec3::Zero(), Vec3::UnitZ(), {false, false, true});
  addBoundary(scene, 1, Vec3(0, 0, 2 * block + apart), Vec3::UnitZ(), {false, false, true}, down);
  return scene;
}

Model modelOf(const Scene& scene) { return buildModel(scene, organSurface(scene)); }

StepReport run(const Model& model, State& state, int ticks, int threads = 1) {
  Workspace workspace(model, threads);
  Command command;
  command.tools[0].pose = model.tools.first().start.pose;
  StepReport report;
  for (int k = 0; k < ticks; ++k) report = tick(model, state, command, workspace);
  return report;
}

constexpr double cube = 2e-3;  // m

/// A flap that hangs over what it is grown to: 50 mm long, 24 mm wide, 6 mm of air below it. A ball above its end.
Model flap() {
  Scene scene = test::blockScene(0.004);
  scene.materials[0].material.set("poisson", 0.45);
  scene.boundaries.clear();
  addBoundary(scene, -1, Vec3::Zero(), Vec3::UnitZ(), {true, true, true});
  scene.dynamics.damping = 40;
  scene.tools[0].shape.radius = 0.006;
  scene.tools[0].position = Vec3(0.036, 0.012, 0.031);
  return buildModel(scene,
                    test::cubes({25, 12, 12}, cube, [](const Vec3& x) { return x.x() < 6 || x.z() < 5 || x.z() > 8; }));
}

/// m, the least that is between the flap and what is below it; less than 0: they went through each other.
double airBelow(const Model& model, const State& state) {
  double least = 1;
  const auto& X = model.skin.surface.vertices;
  std::vector<Vec3> below, above;
  for (int v = 0; v < model.skin.vertexCount(); ++v) {
    if (X[v].x() < 6.5 * cube) continue;
    if (std::abs(X[v].z() - 5 * cube) < 1e-6) below.push_back(skinPosition(model.skin, v, state.u.data()));
    if (std::abs(X[v].z() - 8 * cube) < 1e-6) above.push_back(skinPosition(model.skin, v, state.u.data()));
  }
  for (const Vec3& a : above)
    for (const Vec3& b : below)
      if ((a - b).head<2>().norm() < 2e-4) least = std::min(least, a.z() - b.z());
  return least;
}

}  // namespace

TEST_CASE("What a flap follows is not what lies below it, however near", "[simulation][skin_contact]") {
  const Model model = flap();
  CHECK_FALSE(model.gaps[0]->empty());
  // Above the air only nodes above it, beyond where the flap is grown to.
  const auto follows = [&](const std::vector<Vec3>& at, const auto& rows) {
    int seen = 0, wrong = 0, near = 0;
    for (std::size_t r = 0; r < at.size(); ++r) {
      if (at[r].x() < 9 * cube || at[r].z() < 8 * cube - 1e-6) continue;
      ++seen;
      for (const Vec3& X : model.X) near += X.z() < 5.5 * cube && (X - at[r]).norm() < 0.007;
      for (int e = rows.begin[r]; e < rows.begin[r + 1]; ++e) wrong += model.X[rows.node[e]].z() < 6.5 * cube;
    }
    CHECK(seen > 50);
    CHECK(near > 20);  // that would carry it
    CHECK(wrong == 0);
  };
  follows(model.point_X, model.point_shape);
  follows(model.X, model.node_shape);
  follows(model.skin.surface.vertices, model.skin);
}

TEST_CASE("A flap that is pressed down rests on its own body, and lifts off again", "[simulation][skin_contact]") {
  const Model model = flap();
  REQUIRE(model.bodies.count == 1);
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  command.tools[0].pose = model.tools.first().start.pose;
  StepReport report;
  double least = 1;
  std::vector<double> force;                   // N, at each depth, held
  for (const double depth : {0.009, 0.014}) {  // m; the ball starts 1 mm above it
    const double from = model.tools.first().start.pose.position.z() - command.tools[0].pose.position.z();
    for (int k = 1; k <= 100; ++k) {
      command.tools[0].pose.position.z() =
          model.tools.first().start.pose.position.z() - from - (depth - from) * std::min(1.0, k / 50.0);
      report = tick(model, state, command, workspace);
      if (k % 10 == 0) least = std::min(least, airBelow(model, state));
    }
    force.push_back(report.tool_force.norm());
    CHECK((report.skin_contact_count > 0) == (depth > 0.01));
  }
  CHECK(force[1] > 3 * force[0]);  // without what is below it, 1.6 times: twice as far bent
  CHECK(least > -1e-5);
  command.tools[0].pose = model.tools.first().start.pose;
  command.tools[0].pose.position.z() += 0.01;
  // It creeps back, at w^2 / damping with w its slowest frequency, 1.1 1/s: finer clouds do, too.
  const auto bent = [&](int ticks) {
    for (int k = 0; k < ticks; ++k) report = tick(model, state, command, workspace);
    return std::abs(airBelow(model, state) - 3 * cube);
  };
  const double before = bent(750);
  CHECK(bent(250) == Approx(before * std::exp(-0.55)).epsilon(0.05));
  CHECK(report.skin_contact_count == 0);
}

TEST_CASE("A lip of a slit narrower than the nodes are apart bends alone, until it touches the other",
          "[simulation][skin_contact]") {
  Scene scene = test::blockScene(0.006);
  scene.materials[0].material.set("poisson", 0.45);
  scene.boundaries.clear();
  addBoundary(scene, -1, Vec3::Zero(), Vec3::UnitZ(), {true, true, true});
  scene.dynamics.damping = 40;
  scene.tools[0].shape.radius = 0.006;
  scene.tools[0].position = Vec3(-0.0065, 0.006, 0.02);
  const Model model = buildModel(
      scene, test::cubes({13, 6, 12}, cube, [](const Vec3& x) { return std::abs(x.x() - 6.5) > 0.5 || x.z() < 4; }));
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  command.tools[0].pose = model.tools.first().start.pose;
  StepReport report;
  const auto push = [&](double to, int ticks) {  // m, from the start
    const double from = command.tools[0].pose.position.x() - scene.tools[0].position.x();
    for (int k = 1; k <= ticks; ++k) {
      command.tools[0].pose.position.x() =
          scene.tools[0].position.x() + from + (to - from) * std::min(1.0, 2.0 * k / ticks);
      report = tick(model, state, command, workspace);
    }
  };
  // m, that the slit's edges have moved, left and right.
  const auto moved = [&] {
    std::array<double, 2> most{};
    const auto& X = model.skin.surface.vertices;
    for (int v = 0; v < model.skin.vertexCount(); ++v)
      for (const std::size_t side : {0U, 1U})
        if ((X[v] - Vec3((side == 0 ? 6 : 7) * cube, 0.006, 12 * cube)).norm() < 1e-6)
          most[side] = skinPosition(model.skin, v, state.u.data()).x() - X[v].x();
    return most;
  };
  push(0.003, 100);
  const auto [bent, still] = moved();
  CHECK(report.skin_contact_count == 0);
  CHECK(bent > 4 * std::abs(still));
  CHECK(bent > 5e-4);
  push(0.010, 300);
  const auto [left, right] = moved();
  CHECK(report.skin_contact_count > 0);
  CHECK(right > 5 * std::abs(still));
  CHECK(left - right < 1.05 * cube);
}

TEST_CASE("Looking at what moved finds what looking at all of the skin does", "[simulation][skin_contact][whole]") {
  const Model model = flap();
  State moved = initialState(model), all = moved;
  Workspace workspace(model, 1);
  Command command;
  command.tools[0].pose = model.tools.first().start.pose;
  StepReport report;
  // Vertices that carry force, with the face.
  const auto touching = [](const State& state) {
    std::vector<std::array<int, 2>> pairs;
    for (int k = 0; k < state.skins.count; ++k)
      if (!toVec3(state.skins.force[k]).isZero(0)) pairs.push_back({state.skins.vertex[k], state.skins.face[k]});
    return pairs;
  };
  bool spared = false;  // some regions were not looked at while others were
  for (int k = 1; k <= 60; ++k) {
    command.tools[0].pose.position.z() = model.tools.first().start.pose.position.z() - 0.015 * std::min(1.0, k / 40.0);
    report = tick(model, moved, command, workspace);
    const auto& unseen = moved.skins.unseen;
    spared |= !moved.skins.calm && std::count(unseen.begin(), unseen.end(), 0.0F) < static_cast<int>(unseen.size());
    std::fill(all.skins.unseen.begin(), all.skins.unseen.end(), 1e3F);
    tick(model, all, command, workspace);
    REQUIRE(touching(moved) == touching(all));
  }
  CHECK(report.skin_contact_count > 0);
  CHECK(spared);
  // To rounding: what is remembered of pairs that do not touch yet may be another face.
  double apart = 0;  // m
  for (std::size_t i = 0; i < moved.u.size(); ++i)
    apart = std::max(apart, (toVec3(moved.u[i]) - toVec3(all.u[i])).norm());
  std::printf("looked at what moved and at all: %.1e m apart\n", apart);
  CHECK(apart < 1e-7);
}

TEST_CASE("Two confined blocks that are pressed together are one twice as high", "[simulation][skin_contact][whole]") {
  constexpr double closing = 2e-3;
  const Model model = modelOf(twoBlocks(apart + closing));
  REQUIRE(model.bodies.count == 2);
  State state = initialState(model);
  const StepReport report = run(model, state, 150);
  // Uniaxial strain of a column that both make up: P = mu J^(-2/3) (l - I1 / (3 l)) + K (J - 1).
  const Material& m = model.materials[0];
  const double l = 1 - closing / (2 * block);
  const double stress =
      m.shear_modulus * std::pow(l, -2.0 / 3) * (l - (l * l + 2) / (3 * l)) + m.bulk_modulus * (l - 1);
  const Vec3 &on_lower = report.organ_force[0], &on_upper = report.organ_force[1];
  CHECK(on_lower.z() == Approx(stress * block * block).epsilon(2e-3));
  CHECK((on_lower + on_upper).norm() < 1e-6 * on_lower.norm());
  CHECK(on_lower.head<2>().norm() < 1e-3 * on_lower.norm());
  CHECK(report.skin_penetration < 1e-5);
  CHECK(report.flags == 0);
}

TEST_CASE("Two stiff blocks that slide on each other's faces stay where they came to rest",
          "[simulation][skin_contact]") {
  Scene scene = test::blockScene(0.006);
  scene.materials[0].material.set("young", 1e5);
  scene.materials[0].material.set("poisson", 0.45);
  scene.boundaries.clear();
  scene.dynamics.damping = 10;
  scene.organs[0].size = Vec3(0.03, 0.03, block);
  scene.organs.push_back(scene.organs[0]);
  scene.organs[1].position = Vec3(0, 0, block);
  scene.tools[0].position = Vec3(0, 0, 0.3);
  for (const int organ : {0, 1}) {
    addBoundary(scene, organ, Vec3(-0.015, 0, 0), Vec3::UnitX(), {true, false, false});
    addBoundary(scene, organ, Vec3(0, -0.015, 0), Vec3::UnitY(), {false, true, false});
  }
  addBoundary(scene, 0, Vec3::Zero(), Vec3::UnitZ(), {false, false, true});
  addBoundary(scene, 1, Vec3(0, 0, 2 * block), Vec3::UnitZ(), {false, false, true}, 0.004);
  scene.boundaries.back().duration = 0.3;
  const Model model = modelOf(scene);
  State state = initialState(model);
  run(model, state, 450, 2);
  double fastest = 0;  // m/s
  for (const Float4& du : state.du) fastest = std::max(fastest, toVec3(du).norm() / model.dt);
  std::printf("two stiff blocks: %.2g m/s\n", fastest);
  CHECK(fastest < 0.01);  // with pairs of a tick ago 2 m/s, and more and more
}

TEST_CASE("Two balls meet as Hertz says", "[simulation][skin_contact][whole]") {
  constexpr double R = 0.03, gap = 5e-4, closing = 1e-3;
  Scene scene = test::blockScene(0.006);
  scene.boundaries.clear();
  scene.organs[0].solid = OrganSpec::Solid::Ellipsoid;
  scene.organs[0].upper_half = true;
  scene.organs[0].semi_axes = Vec3::Constant(R);
  scene.organs.push_back(scene.organs[0]);
  scene.organs[1].axis = Vec3::UnitX();
  scene.organs[1].angle = M_PI;
  scene.organs[1].position = Vec3(0, 0, 2 * R + gap);
  scene.materials[0].material.set("poisson", 0.3);
  scene.tools[0].position = Vec3(0, 0, 0.2);
  scene.tools[0].shape.radius = 0.004;  // edges of the skin are by that
  scene.discretization.refine.push_back({Vec3(0, 0, R), 0.35 * R, 0.0022, 0, {}});
  addBoundary(scene, 0, Vec3::Zero(), Vec3::UnitZ(), {true, true, true});
  addBoundary(scene, 1, Vec3(0, 0, 2 * R + gap), Vec3::UnitZ(), {true, true, true}, gap + closing);
  const Model model = modelOf(scene);
  State state = initialState(model);
  const StepReport report = run(model, state, 150);
  // Each half gives way at its base, too, by about what a half-space has there: (1 - nu^2) F / (pi E R).
  const double E = 3000, plane = E / (1 - 0.3 * 0.3);
  double force = 0;
  for (int k = 0; k < 50; ++k)
    force = 4.0 / 3 * plane / 2 * std::sqrt(R / 2) * std::pow(closing + 2 * force / (M_PI * plane * R), 1.5);
  CHECK(-report.organ_force[0].z() == Approx(force).epsilon(0.05));
  CHECK(report.organ_force[0].head<2>().norm() < 0.01 * force);
}

TEST_CASE("Organs in contact have the same bits on any number of threads, as saved, and take no memory",
          "[simulation][skin_contact]") {
  const Model model = modelOf(twoBlocks(3 * apart, 0.004));
  State one = initialState(model), two = one;
  run(model, one, 80);
  run(model, two, 80, 2);
  CHECK(stateHash(model, one) == stateHash(model, two));
  State saved = one;
  run(model, one, 10);
  run(model, saved, 10);
  CHECK(stateHash(model, one) == stateHash(model, saved));
  saved.skins.force[0].x += 1e-6F;  // it is remembered
  CHECK(stateHash(model, one) != stateHash(model, saved));

  Workspace workspace(model, 1);
  Command command;
  command.tools[0].pose = model.tools.first().start.pose;
  tick(model, one, command, workspace);
  std::fill(one.skins.unseen.begin(), one.skins.unseen.end(), 1e3F);  // a look at all vertices
  if (test::guardAvailable()) test::startGuard();
  for (int k = 0; k < 5; ++k) tick(model, one, command, workspace);
  CHECK((!test::guardAvailable() || test::stopGuard().total() == 0));
}

TEST_CASE("Friction between organs holds what pushes less than it can, and does not creep",
          "[simulation][skin_contact]") {
  for (const int rough : {0, 1}) {
    Scene scene = twoBlocks(apart + 2e-3);
    std::erase_if(scene.boundaries, [](const BoundarySpec& b) { return b.region.normal.z() == 0; });
    scene.boundaries.back().translation.x() = 1e-3;
    for (BoundarySpec& b : scene.boundaries) std::fill(b.component, b.component + 3, true);
    scene.organs[0].friction = 0.3 * rough;
    const Model model = modelOf(scene);
    State state = initialState(model);
    const Vec3 soon = run(model, state, 90).organ_force[0], later = run(model, state, 60).organ_force[0];
    if (rough == 0) {
      CHECK(std::abs(soon.x()) < 0.02 * std::abs(soon.z()));
    } else {
      CHECK(soon.x() > 0.04 * std::abs(soon.z()));
      CHECK(later.x() == Approx(soon.x()).epsilon(0.01));
    }
  }
}

TEST_CASE("A soft cube slides down a soft block that is too steep for its friction, and no edge holds it",
          "[simulation][skin_contact]") {
  constexpr double slope = 20 * M_PI / 180, friction = 0.3, damping = 20, time = 0.2;
  Scene scene = test::blockScene(0.005);
  scene.materials[0].material.set("young", 2e4);
  scene.boundaries.clear();
  scene.organs[0].size = Vec3(0.08, 0.05, block);
  scene.organs[0].friction = friction;
  scene.organs.push_back(scene.organs[0]);
  scene.organs[1].size = Vec3::Constant(block);
  scene.organs[1].position = Vec3(-0.023, 0.0013, block + 1e-4);
  addBoundary(scene, 0, Vec3::Zero(), Vec3::UnitZ(), {true, true, true});
  scene.dynamics.gravity = 9.81 * Vec3(std::sin(slope), 0, -std::cos(slope));
  scene.dynamics.damping = damping;
  scene.tools[0].position = Vec3(0, 0, 0.3);
  scene.tools[0].shape.radius = 0.01;
  const Model model = modelOf(scene);
  State state = initialState(model);
  const auto wayIn = [&](double seconds) {  // m, of the cube
    const State before = state;
    run(model, state, static_cast<int>(seconds * scene.dynamics.rate_hz));
    Vec3 way = Vec3::Zero();
    int nodes = 0;
    for (int i = 0; i < model.nodeCount(); ++i)
      if (model.node_organ[i] == 1) way += toVec3(state.u[i]) - toVec3(before.u[i]), ++nodes;
    return Vec3(way / nodes);
  };
  wayIn(time);  // it falls by a tenth of a millimetre, and comes to its speed
  const Vec3 way = wayIn(time);
  CHECK(way.x() == Approx(9.81 * (std::sin(slope) - friction * std::cos(slope)) / damping * time).epsilon(0.03));
  CHECK(std::abs(way.y()) < 0.02 * way.x());
}

TEST_CASE("An organ that is struck at the tool's highest speed is not passed through", "[simulation][skin_contact]") {
  Scene scene = twoBlocks(apart + 0.008);
  scene.boundaries.back().duration = 0.01;  // 0.9 m/s
  std::erase_if(scene.boundaries, [](const BoundarySpec& b) { return b.region.normal.z() == 0; });
  for (bool& component : scene.boundaries.front().component) component = true;
  for (bool& component : scene.boundaries.back().component) component = true;
  const Model model = modelOf(scene);
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  command.tools[0].pose = model.tools.first().start.pose;
  double deepest = 1;
  for (int k = 0; k < 130; ++k) {
    const StepReport report = tick(model, state, command, workspace);
    REQUIRE((report.flags & (kNotFinite | kBlowUp | kInvertedPoints)) == 0);
    if (k >= 120) CHECK(report.skin_penetration < 1e-4);  // what the blow left comes back slowly
    TriangleSurface now = model.skin.surface;
    for (int v = 0; v < model.skin.vertexCount(); ++v) now.vertices[v] = skinPosition(model.skin, v, state.u.data());
    const std::vector<TriangleSurface> skins = separated(now, bodiesOf(now));
    const SurfaceTree lower(skins[0]);
    for (const Vec3& x : skins[1].vertices) deepest = std::min(deepest, lower.signedDistance(x));
  }
  CHECK(deepest > -5e-4);  // where vertices of the one stand between those of the other
  CHECK(deepest < 1e-4);
  CHECK(state.skins.count > 0);
}

TEST_CASE("A stiff organ that holds a soft one by friction presses it as a bonded face does",
          "[simulation][skin_contact]") {
  // Cells take pressure over from the patches of what flows freely: beside what is held they are 9 % too stiff here.
  constexpr double high = 0.024, pressed = 0.4 * high;
  Scene scene = test::blockScene(0.006);
  scene.boundaries.clear();
  scene.materials[0].material.set("young", 3000);
  scene.materials[0].material.set("poisson", 0.49);
  scene.tools[0].position = Vec3(0, 0, 0.2);
  scene.organs[0].size = Vec3(0.036, 0.036, high);
  scene.organs[0].position = Vec3(0, 0, block);
  RigidSpec& plate = scene.rigid.emplace_back();
  plate.region.point = Vec3(0, 0, block + high);
  plate.region.normal = -Vec3::UnitZ();
  plate.friction = 1;
  plate.motion.translation = Vec3(0, 0, -pressed);
  plate.motion.duration = 0.25;
  Scene bonded = scene;
  addBoundary(bonded, 0, Vec3(0, 0, block), Vec3::UnitZ(), {true, true, true});
  OrganSpec stiff = scene.organs[0];
  stiff.size = Vec3(0.048, 0.048, block - 1e-5);
  stiff.position = Vec3::Zero();
  stiff.friction = 1;
  scene.organs.push_back(stiff);
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].organ = 1;
  scene.materials[1].material.set("young", 2e5);
  scene.materials[1].material.set("poisson", 0.3);
  addBoundary(scene, 1, Vec3::Zero(), Vec3::UnitZ(), {true, true, true});
  const auto force = [](const Model& model) {
    State state = initialState(model);
    return run(model, state, 200).base_reaction.z();
  };
  const double on_organ = force(modelOf(scene)), on_face = force(modelOf(bonded));
  std::printf("on a bonded face %.4f N, on a stiff organ with friction %.4f N\n", on_face, on_organ);
  CHECK(on_organ == Approx(on_face).epsilon(0.04));
}

TEST_CASE("What stands apart in one surface file is several bodies: no support goes across the gap",
          "[simulation][skin_contact]") {
  Scene scene = twoBlocks(0.5 * apart);
  TriangleSurface both = organSurface(scene);
  both.organ.clear();
  scene.organs.resize(1);
  for (BoundarySpec& b : scene.boundaries) b.organ = -1;
  const Model model = buildModel(scene, both);
  CHECK(model.bodies.count == 2);
  State state = initialState(model);
  const StepReport report = run(model, state, 80);
  CHECK(report.base_reaction.norm() < 1e-5);  // the upper one came nearer, and did not touch
  CHECK(report.skin_contact_count == 0);
}

TEST_CASE("Organs that overlap are refused with what to do", "[simulation][skin_contact]") {
  Scene scene = twoBlocks(apart);
  scene.organs[1].position.z() = 0.9 * block;
  CHECK_THAT(refusal([&] { organSurface(scene); }),
             Catch::Matchers::Contains("overlap by 2 mm") && Catch::Matchers::Contains("\"position\""));
}
