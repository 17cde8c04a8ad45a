#include "step/resolution.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "batch/static_solver.h"
#include "mechanics/internal_forces.h"
#include "step/step.h"
#include "step/trust.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

/// Presses 7 mm in and holds. @param seconds  of both
StepReport pressed(const Model& model, State& state, Workspace& workspace, RunTrust& trust, double seconds = 2) {
  const auto ticks = static_cast<int>(seconds * model.scene.dynamics.rate_hz);
  StepReport report;
  for (int k = 1; k <= ticks; ++k) {
    Command command;
    command.tools[0].pose = test::toolAt(
        model, model.tools.first().first_contact_travel + 0.007 * std::min(1.0, 3.0 * k / static_cast<double>(ticks)));
    report = tick(model, state, command, workspace);
    trust.add(doubtOf(model, report), report.expected_error, report.error_force, k / model.scene.dynamics.rate_hz);
  }
  return report;
}

}  // namespace

TEST_CASE("A deformation that is the same everywhere leaves nothing to expect, also where two materials meet in it",
          "[resolution]") {
  Scene scene = test::blockScene();
  MaterialSpec stiff;
  stiff.material.set("young", 30000);
  stiff.material.set("poisson", 0.48);
  stiff.everywhere = false;
  stiff.region.point = Vec3(0, 0, 0.015);  // below
  scene.materials.push_back(stiff);
  const Model model = test::blockModel(scene);
  AlignedVector<Double4> u;
  for (const Vec3& X : model.X)
    u.push_back(toReal4<double>(Vec3(0.1 * X.x() + 0.02 * X.z(), -0.05 * X.y(), 0.03 * X.x())));
  CHECK(expectedError(model, model.materials, u, 1e-3) < 1e-10);
  // A jump of the gradient at the border is no error, one within a material is.
  for (std::size_t i = 0; i < u.size(); ++i) u[i].x += 0.1 * std::max(0.0, model.X[i].z() - 0.02);
  CHECK(expectedError(model, model.materials, u, 1e-3) > 1e-4);
  CHECK(expectedError(model, model.materials, u, 0) == 0);
}

TEST_CASE("A coarse block's press is doubted for its resolution, a fine one's is not", "[resolution][whole]") {
  double before = 0;
  for (const double spacing : {0.012, 0.0045}) {
    const Model model = test::blockModel(test::blockScene(spacing));
    Workspace workspace(model, 2);
    State state = initialState(model);
    RunTrust trust;
    const StepReport report = pressed(model, state, workspace, trust, 2);
    CAPTURE(spacing, report.expected_error, trust.expectedError());
    const bool coarse = spacing > 0.01;
    CHECK((report.expected_error > TrustLimits::expected_error) == coarse);
    CHECK(trust.doubt() == (coarse ? Doubt::Resolution : Doubt::None));
    CHECK((trust.firstTime() >= 0) == coarse);
    CHECK(resolutionWarning(model).empty() != coarse);
    if (coarse) CHECK(resolutionWarning(model).find("mtled fit") != std::string::npos);
    CHECK(report.error_force == Approx(report.tool_force.norm()).epsilon(0.01));
    if (!coarse) CHECK(report.expected_error < 0.5 * before);
    before = report.expected_error;

    // The whole sweep at once, in double, finds the same.
    AlignedVector<Double4> u;
    for (const Float4& a : state.u) u.push_back({a.x, a.y, a.z, 0});
    CHECK(expectedError(model, model.materials, u, report.strain_energy, PressList(report.loads)) ==
          Approx(report.expected_error).epsilon(0.01));

    workspace.resolution.restart();
    Command command;
    command.tools[0].pose = state.tool[0].pose;
    const StepReport unknown = tick(model, state, command, workspace);
    CHECK(unknown.expected_error == 1);
    CHECK(unknown.error_force == 0);
    CHECK(doubtOf(model, unknown) == Doubt::Resolution);
  }
}

TEST_CASE("A touch narrower than the nodes are apart is expected to be as far off as it is", "[resolution][whole]") {
  double force[2], expected[2];
  for (const int fine : {0, 1}) {
    Scene scene = test::blockScene(fine ? 0.0035 : 0.012);
    const Model model = test::blockModel(scene);
    Workspace workspace(model, 2);
    State state = initialState(model);
    const double touch = model.tools.first().first_contact_travel;
    const auto travelAt = [&](int k) { return touch + 0.002 * std::min(1.0, k / 200.0); };
    const StepReport report = test::moveAlong(model, state, workspace, 400, travelAt);
    force[fine] = report.tool_force.norm();
    expected[fine] = report.expected_error;
    AlignedVector<Double4> u;
    for (const Float4& a : state.u) u.push_back({a.x, a.y, a.z, 0});
    CHECK(expectedError(model, model.materials, u, report.strain_energy, PressList(report.loads),
                        {state.tool.begin(), state.tool.end()}) == Approx(expected[fine]).epsilon(0.1));
  }
  const double off = force[0] / force[1] - 1;
  CAPTURE(force[0], force[1], off, expected[0], expected[1]);
  CHECK(off > 0.25);  // too stiff by so much
  CHECK(expected[0] > 0.6 * off);
  CHECK(expected[0] < 2.5 * off);
  CHECK(expected[1] < 0.1);
}

TEST_CASE("What is expected of a press is the same bits for any number of threads", "[resolution][whole]") {
  const Model model = test::blockModel();
  double error = -1;
  for (const int threads : {1, 3}) {
    Workspace workspace(model, threads);
    State state = initialState(model);
    RunTrust trust;
    const double found = pressed(model, state, workspace, trust, 1).expected_error;
    CHECK(found > 0);
    if (error >= 0) CHECK(found == error);
    error = found;
  }
}

namespace {

/// A ball of 3 mm pressed 2 mm into a block on nodes that are too far apart for it, and held.
/// @param beside  a ball of 10 mm presses 6 mm in, too  @param gravity  m/s^2, to the side, from before it touches on
StepReport pressedBySmall(bool beside, double gravity, RunTrust& trust) {
  Scene scene = test::blockScene(0.006);
  scene.tools[0].shape.radius = 0.003;
  scene.tools[0].position = Vec3(0.017, 0, 0.032);
  scene.tools.push_back(scene.tools[0]);
  scene.tools[1].shape.radius = 0.01;
  scene.tools[1].position = Vec3(-0.015, 0, 0.032);
  const Model model = test::blockModel(scene);
  Workspace workspace(model, 2);
  State state = initialState(model);
  state.live.loads.gravity = Vec3(gravity, 0, 0);
  Command command;
  command.moves_others = true;
  StepReport report;
  for (int k = 1; k <= 900; ++k) {
    const double way = std::clamp((k - 300) / 200.0, 0.0, 1.0);
    for (std::size_t t = 0; t < 2; ++t) {
      command.tools[t] = model.tools.tool[t].start;
      command.tools[t].pose.position.z() -= (t == 0 ? 0.004 : beside ? 0.008 : 0) * way;
    }
    report = tick(model, state, command, workspace);
    trust.add(doubtOf(model, report), report, k / model.scene.dynamics.rate_hz);
  }
  return report;
}

}  // namespace

TEST_CASE("What a large tool stores, or gravity does, vouches for no small tool", "[resolution][whole]") {
  RunTrust alone, both, heavy;
  const StepReport small = pressedBySmall(false, 0, alone), beside = pressedBySmall(true, 0, both),
                   sagging = pressedBySmall(false, 20, heavy);
  CAPTURE(small.strain_energy, beside.strain_energy, sagging.strain_energy, beside.loads[1].expected_error);
  REQUIRE(beside.strain_energy > 10 * small.strain_energy);
  REQUIRE(sagging.strain_energy > 5 * small.strain_energy);
  const double expected = small.loads[0].expected_error;
  CHECK(expected > 0.1);
  CHECK(small.expected_error == expected);
  CHECK(beside.loads[0].expected_error > 0.5 * expected);
  CHECK(beside.loads[0].expected_error < 2 * expected);
  CHECK(beside.loads[1].expected_error < 0.5 * expected);  // the large one's own
  CHECK(beside.expected_error == beside.loads[0].expected_error);
  CHECK(beside.error_by == 0);
  CHECK(sagging.loads[0].expected_error > 0.4 * expected);
  CHECK(sagging.loads[0].expected_error < 3 * expected);
  for (const RunTrust* trust : {&alone, &both, &heavy}) CHECK(trust->doubt() == Doubt::Resolution);
}

TEST_CASE("A narrow touch that bends a bar counts by what it gives there", "[resolution][whole]") {
  // The same touch, as narrow as a third of the nodes' distance, on a block that stands on its base and on one that is
  // held at one end: what the tool feels of that is the bar's bending.
  for (const bool bends : {false, true}) {
    Scene scene = test::blockScene(0.006);
    scene.boundaries[0].region.normal = bends ? Vec3::UnitX() : Vec3::UnitZ();
    if (bends) scene.boundaries[0].region.point = Vec3(-0.1, 0, 0);
    scene.tools[0].position = Vec3(bends ? 0.08 : 0, 0, 0.035);
    scene.tools[0].shape.radius = 0.012;
    const Model model = buildModel(scene, boxSurface({0.2, 0.04, 0.03}, 0.004));
    Workspace workspace(model, 2);
    State state = initialState(model);
    const double touch = model.tools.first().first_contact_travel, way = bends ? 0.01 : 0.00025;
    const auto travelAt = [&](int k) { return touch + way * std::min(1.0, k / 600.0); };
    const StepReport report = test::moveAlong(model, state, workspace, 1200, travelAt);
    CAPTURE(bends, report.tool_force.norm());
    REQUIRE(report.contact_count > 0);
    AlignedVector<Double4> u;
    for (const Float4& a : state.u) u.push_back({a.x, a.y, a.z, 0});
    for (const double expected :
         {report.expected_error, expectedError(model, model.materials, u, report.strain_energy, PressList(report.loads),
                                               {state.tool.begin(), state.tool.end()})})
      CHECK((bends ? expected < 0.1 : expected > 0.5));
  }
}

TEST_CASE("A tool's errors are shares of its own largest force", "[resolution]") {
  RunTrust trust;
  trust.add(Doubt::None, 0.02, 1, 0.1, 0);
  trust.add(Doubt::Resolution, 0.3, 0.05, 0.2, 1);
  CHECK(trust.expectedError() == Approx(0.3));
  trust.add(Doubt::None, 0.03, 0.6, 0.3, 1);  // that was its first touch
  CHECK(trust.expectedError() == Approx(0.03));
  trust.add(Doubt::Resolution, 0.4, 0.1, 0.4, -1);  // what holds a body that swings
  CHECK(trust.expectedError() == Approx(0.04));
  CHECK(trust.doubt() == Doubt::None);
}

TEST_CASE("A run's trust is that of its gravest row, and of its resolution at the largest force", "[resolution]") {
  RunTrust trust;
  trust.add(Doubt::Resolution, 1, 0, 0.1);  // nothing is known yet
  CHECK(trust.doubt() == Doubt::Resolution);
  CHECK(trust.expectedError() == 1);
  trust.add(Doubt::Resolution, 0.8, 0.01, 0.1);  // first touch: never resolved
  trust.add(Doubt::None, 0.03, 1, 0.2);
  CHECK(trust.doubt() == Doubt::None);
  CHECK(trust.firstTime() < 0);
  CHECK(trust.expectedError() == Approx(0.03));
  trust.add(Doubt::Resolution, 0.08, 1, 0.3);
  CHECK(trust.doubt() == Doubt::Resolution);
  CHECK(trust.firstTime() == 0.1);
  trust.add(Doubt::Volume, 0.01, 1, 0.4);
  trust.add(Doubt::Contact, 0.01, 1, 0.5);
  CHECK(trust.doubt() == Doubt::Contact);
  CHECK(trust.firstTime() == 0.4);
}

TEST_CASE("An equilibrium of a face that is moved has an error to expect, too", "[resolution]") {
  Scene scene = test::blockScene();
  scene.materials[0].material.set("poisson", 0.3);
  BoundarySpec top = test::planeBoundary(Vec3(0, 0, 0.03));
  top.translation = Vec3(0.006, 0, 0);
  top.duration = 1;
  scene.boundaries.push_back(top);
  scene.tools[0].position = Vec3(0, 0, 1);
  const Model model = test::blockModel(scene);
  StaticSolver solver(model, 2, 1e-4);
  const Equilibrium sheared = solver.advanceTo(1);
  REQUIRE(sheared.converged);
  CHECK(sheared.strain_energy > 0);
  CHECK(sheared.expected_error > 0.001);
  CHECK(sheared.expected_error < TrustLimits::expected_error);
  CHECK(sheared.doubt == Doubt::None);
}

TEST_CASE("Of a block that stands on a patch of its base at least half of the error is expected",
          "[resolution][whole]") {
  Scene scene = test::blockScene();
  scene.materials[0].material.set("poisson", 0.45);
  scene.boundaries[0].region.kind = Region::Kind::Box;
  scene.boundaries[0].region.min = Vec3(-1, -1, -1e-4);
  scene.boundaries[0].region.max = Vec3(-0.01, 0, 1e-4);
  BoundarySpec top = test::planeBoundary(Vec3(0, 0, 0.03));
  top.translation = Vec3(0.001, 0, 0);
  top.duration = 1;
  scene.boundaries.push_back(top);
  scene.tools[0].position = Vec3(0, 0, 1);
  Equilibrium at[2];
  for (const int fine : {0, 1}) {
    scene.discretization.spacing = fine ? 0.004 : 0.009;
    const Model model = test::blockModel(scene);
    at[fine] = StaticSolver(model, 2, 1e-4).advanceTo(1);
    REQUIRE(at[fine].converged);
  }
  const double off = at[0].strain_energy / at[1].strain_energy - 1;
  CAPTURE(off, at[0].expected_error, at[1].expected_error);
  CHECK(off > 0.03);
  CHECK(at[0].expected_error > 0.8 * off);
  CHECK(at[0].expected_error < 2 * off);
  CHECK(at[1].expected_error < 0.6 * at[0].expected_error);
}

TEST_CASE("One point misses what changes within its cell, two cells' more, fibres' most, and four points see it",
          "[resolution][whole]") {
  // Sheared the more the higher up, at a volume that stays.
  const auto expected = [](int points_per_cell, double cells_per_point, double k2) {
    Scene scene = test::blockScene();
    scene.discretization.quadrature.points_per_cell = points_per_cell;
    scene.discretization.quadrature.cells_per_point = cells_per_point;
    if (k2 >= 0) {
      const std::array up{0.0, 0.0, 1.0};
      scene.materials[0].material =
          Material::of("fibre-reinforced").set("young", 3000).set("poisson", 0.3).set("k1", 3000).set("k2", k2);
      scene.materials[0].material.set("fibre", up);
    }
    const Model model = test::blockModel(scene);
    AlignedVector<Double4> u;
    for (const Vec3& X : model.X) u.push_back(toReal4<double>(Vec3(20 * X.z() * X.z(), 0, 0)));
    return expectedError(model, model.materials, u, 1e-3);
  };
  const double one = expected(1, 1, -1);
  CHECK(expected(4, 1, -1) < one / 3);
  CHECK(expected(1, 1.5, -1) > 1.2 * one);
  const double straight = expected(1, 1, 0);
  CHECK(straight > 1.5 * one);
  CHECK(expected(1, 1, 0.5) > 1.2 * straight);
}

TEST_CASE("A tool off which the skin slips in jerks is doubted until it lifts, one that slides is not",
          "[resolution][contact][whole]") {
  Scene scene = test::blockScene(0.004);
  scene.organs[0].size = Vec3(0.06, 0.04, 0.015);
  scene.materials[0].material.set("poisson", 0.45);
  scene.tools[0].shape.radius = 0.006;
  scene.tools[0].position = Vec3(-0.014, 0, 0.025);
  for (const double friction : {0.4, 1.5}) {
    scene.tools[0].friction = friction;
    const Model model = test::blockModel(scene);
    Workspace workspace(model, 2);
    State state = initialState(model);
    const double rate = scene.dynamics.rate_hz;
    StepReport report;
    double worst = 0;
    const auto go = [&](double seconds, double depth, double from, double to) {
      const auto ticks = static_cast<int>(seconds * rate);
      for (int k = 1; k <= ticks; ++k) {
        Command command;
        command.tools[0].pose = test::toolAt(model, model.tools.first().first_contact_travel + depth);
        command.tools[0].pose.position.x() += from + (to - from) * k / ticks;
        report = tick(model, state, command, workspace);
        if (report.error_force > 0) worst = std::max(worst, report.expected_error);
      }
    };
    go(0.6, 0.003, 0, 0);
    worst = 0;
    go(1.2, 0.003, 0, 0.024);
    CAPTURE(friction, worst, report.expected_error, report.tool_force.transpose());
    CHECK((worst > 0.1) == (friction > 1));
    if (friction > 1) {
      CHECK(report.expected_error > 0.1);  // kept
      go(0.2, -0.002, 0.024, 0.024);
      go(0.6, 0.003, 0.024, 0.024);
      CHECK(report.expected_error < 0.1);
    }
  }
}
