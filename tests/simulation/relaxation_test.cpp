#include "mechanics/relaxation.h"

#include <catch2/catch.hpp>
#include <cstring>

#include "batch/static_solver.h"
#include "batch/transient_solver.h"
#include "discretization/surface/solids.h"
#include "model/model_hash.h"
#include "model/solution_fields.h"
#include "step/step.h"
#include "step/trust.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;
using test::blockModel;
using test::blockScene;
using test::roller;
using test::toolAt;

namespace {

constexpr double edge = 0.04, squeeze = 0.2, ramp = 0.1;  // m, share, s
const std::vector<double> terms{0.3, 0.1, 0.2, 0.5};

/// A cube between frictionless planes whose top comes down by a fifth in 0.1 s.
Model squeezedCube() {
  Scene scene = blockScene(0.013);
  scene.organs[0].size = Vec3::Constant(edge);
  scene.boundaries = {roller(Vec3::Zero(), 2), roller(Vec3(-edge / 2, 0, 0), 0), roller(Vec3(0, -edge / 2, 0), 1),
                      roller(Vec3(0, 0, edge), 2)};
  scene.boundaries.back().translation = Vec3(0, 0, -squeeze * edge);
  scene.boundaries.back().duration = ramp;
  scene.tools[0].position = Vec3(0, 0, 0.5);
  scene.materials[0].material.set("poisson", 0.49).set("relaxation", terms);
  return buildModel(scene, boxSurface(scene.organs[0].size, 0.02));
}

/// Force of the incompressible cube at time t, N: the integral of the Prony series over the history of
/// S = J^(2/3) F^-1 P_iso along (11) and across (22), and no stress on the free sides.
double closedForm(double shear, double t) {
  const auto stretch = [](double s) { return 1 - squeeze * LoadCurve{}.at(s, ramp); };
  const auto along = [&](double s) {
    const double l = stretch(s), I1 = l * l + 2 / l;
    return shear * (1 - I1 / (3 * l * l));
  };
  const auto across = [&](double s) {
    const double l = stretch(s), I1 = l * l + 2 / l;
    return shear * (1 - I1 * l / 3);
  };
  const auto relaxed = [t](auto S) {
    double left = S(t);
    constexpr int intervals = 20000;
    for (std::size_t i = 0; i < terms.size(); i += 2)
      for (int k = 0; k < intervals; ++k) {
        const double s = (k + 0.5) * t / intervals;
        left -= terms[i] / terms[i + 1] * std::exp(-(t - s) / terms[i + 1]) * S(s) * t / intervals;
      }
    return left;
  };
  const double l = stretch(t);
  return edge * edge * (l * relaxed(along) - relaxed(across) / (l * l));
}

/// Presses a ball 4 mm deep in 0.5 s, holds for `hold` s, draws it back in 0.5 s; each(report, depth) after each tick.
template <class Each>
void indent(const Model& model, State& state, Workspace& workspace, double hold, Each each) {
  const double rate = model.scene.dynamics.rate_hz, travel = model.tools.first().first_contact_travel + 0.004,
               way = 0.5;
  Command command;
  for (int k = 1; k <= static_cast<int>((2 * way + hold) * rate); ++k) {
    const double t = k / rate;
    const double at =
        travel * (LoadCurve{}.at(std::min(t, way), way) - (t > way + hold ? LoadCurve{}.at(t - way - hold, way) : 0.0));
    command.tools[0].pose = toolAt(model, at);
    each(tick(model, state, command, workspace), at - model.tools.first().first_contact_travel);
  }
}

/// A block in which little but the material takes energy.
Scene slowlyDamped() {
  Scene scene = blockScene();
  scene.dynamics.damping = 20;
  return scene;
}

Model relaxingBlock(double g, double tau) {
  Scene scene = slowlyDamped();
  scene.materials[0].material.set("relaxation", std::vector<double>{g, tau});
  return blockModel(scene);
}

}  // namespace

TEST_CASE("A cube held at a fifth less height relaxes by the closed form: loop, transient and static solution",
          "[relaxation]") {
  const Model model = squeezedCube();
  State state = initialState(model);
  Workspace workspace(model, 1);
  TransientSolver solver(model, 1);
  Command command;
  command.tools[0].pose = model.tools.first().start.pose;
  const double shear = model.materials[0].shear_modulus;
  const int ticks = static_cast<int>(1.2 * model.scene.dynamics.rate_hz);
  int compared = 0;
  for (int k = 1; k <= ticks; ++k) {
    const StepReport report = tick(model, state, command, workspace);
    solver.tick();
    REQUIRE(report.flags == 0);
    const bool unknown = report.expected_error == 1 && report.error_force == 0;
    CHECK(doubtOf(model, report) == (unknown ? Doubt::Resolution : Doubt::None));
    if (k * 10 % ticks != 0 || k * 10 < 3 * ticks) continue;
    // The forces are those before the step: a step earlier.
    const double exact = closedForm(shear, solver.time() - model.dt);
    INFO(solver.time() << " s: loop " << report.base_reaction.z() << " N, solution "
                       << solver.body().reactions()[0].force.z() << " N, closed form " << -exact << " N");
    CHECK(report.base_reaction.z() == Approx(-exact).epsilon(0.01));
    CHECK(solver.body().reactions()[0].force.z() == Approx(-exact).epsilon(0.01));
    ++compared;
  }
  CHECK(compared == 8);
  CHECK(closedForm(shear, 0.36) / closedForm(shear, 1.2) > 1.1);  // there was something to see

  StaticSolver equilibrium(model, 1, 1e-4);
  REQUIRE(equilibrium.advanceTo(ramp).converged);
  const double l = 1 - squeeze, of_law = edge * edge * shear * (l - 1 / (l * l));
  CHECK(equilibrium.body().reactions()[0].force.z() == Approx(-0.5 * of_law).epsilon(0.01));

  // The fields, too: what is left of the law's stress, in equilibrium and now.
  std::vector<Vec3> u;
  for (const auto& a : solver.body().u) u.push_back(toVec3(a));
  const double left = closedForm(shear, solver.time()) / of_law, mises = std::abs(of_law / (edge * edge) * l);
  CHECK(solutionFields(model, u).von_mises[0] == Approx(0.5 * mises).epsilon(0.01));
  CHECK(solutionFields(model, u, solver.body().pointHistory()).von_mises[0] == Approx(left * mises).epsilon(0.01));
}

TEST_CASE("Of tissue that becomes softer or stiffer while it is held what has relaxed does, too", "[relaxation]") {
  const Model model = squeezedCube();
  const int ticks = static_cast<int>(model.scene.dynamics.rate_hz);
  Command command;
  command.tools[0].pose = model.tools.first().start.pose;
  for (const double factor : {0.2, 1.2}) {
    State state = initialState(model);
    Workspace workspace(model, 1);
    for (int k = 1; k <= ticks; ++k) {
      const StepReport report = tick(model, state, command, workspace);
      if (2 * k == ticks) setMaterial(model, 0, stiffened(model.materials[0], factor), state);
      if (2 * k < ticks + 10 || k * 25 % ticks != 0) continue;
      const double exact =
          factor * closedForm(model.materials[0].shear_modulus, k / model.scene.dynamics.rate_hz - model.dt);
      INFO(factor << " times as stiff since 0.5 s, at tick " << k << " of " << ticks);
      CHECK(report.base_reaction.z() == Approx(-exact).epsilon(0.01));
    }
  }
}

TEST_CASE("Indented, held and released: the force falls to what is left, the way back is softer, no doubt arises",
          "[relaxation][contact][whole]") {
  constexpr double g = 0.4, tau = 0.3;
  const Model model = relaxingBlock(g, tau);
  State state = initialState(model);
  Workspace workspace(model, 1);
  double work = 0, pressed = 0, last_depth = 0, peak = 0, held = 0;
  indent(model, state, workspace, 2.0, [&](const StepReport& report, double depth) {
    REQUIRE(doubtOf(model, report) <= Doubt::Resolution);  // the energy's included
    const double force = report.tool_force.z();
    work += force * (depth - last_depth);
    pressed = std::max(pressed, work);
    if (depth == last_depth) held = force;
    peak = std::max(peak, force);
    last_depth = depth;
  });
  CHECK(work > 0.15 * pressed);
  CHECK(held < 0.8 * peak);
  CHECK(state.energy.relaxed < -0.1 * pressed);  // a closed way: what the tissue kept

  // What the equilibrium is: a block of the shear modulus that is left, at the same bulk modulus.
  Scene scene = slowlyDamped();
  const Material& m = model.materials[0];
  const double K = m.bulk_modulus, mu = (1 - g) * m.shear_modulus;
  scene.materials[0].material.set("young", 9 * K * mu / (3 * K + mu));
  scene.materials[0].material.set("poisson", (3 * K - 2 * mu) / (2 * (3 * K + mu)));
  const Model left = blockModel(scene);
  State elastic = initialState(left);
  Workspace other(left, 1);
  double elastic_held = 0, elastic_work = 0, elastic_pressed = 0;
  last_depth = 0;
  indent(left, elastic, other, 2.0, [&](const StepReport& report, double depth) {
    elastic_work += report.tool_force.z() * (depth - last_depth);
    elastic_pressed = std::max(elastic_pressed, elastic_work);
    if (depth == last_depth) elastic_held = report.tool_force.z();
    last_depth = depth;
  });
  CHECK(held == Approx(elastic_held).epsilon(0.01));
  CHECK(elastic_work / elastic_pressed < 0.5 * work / pressed);  // of damping and inertia alone
}

TEST_CASE("What relaxes is part of the state: the same bits for any thread count, after a reset, after a resume",
          "[relaxation][determinism][whole]") {
  const Model model = relaxingBlock(0.4, 0.1);
  const State rest = initialState(model);
  std::vector<std::uint64_t> hashes;
  const auto ignore = [](const StepReport&, double) {};
  State state = rest;
  for (const int threads : {1, 3}) {
    Workspace workspace(model, threads);
    workspace.team.wake();
    state = rest;  // as a reset does
    CHECK(stateHash(model, state) == stateHash(model, rest));
    indent(model, state, workspace, 0.0, ignore);
    workspace.team.park();
    hashes.push_back(stateHash(model, state));
  }
  CHECK(hashes[0] == hashes[1]);
  state.relaxation.Z[3] += 1e-3F;
  CHECK(stateHash(model, state) != hashes[0]);

  const Model cube = squeezedCube();
  TransientSolver whole(cube, 1), first(cube, 2), second(cube, 1);
  for (int k = 0; k < 30; ++k) whole.tick();
  for (int k = 0; k < 12; ++k) first.tick();
  CHECK_FALSE(first.tick({}, [count = 0]() mutable { return ++count < 2; }).has_value());  // it never was
  second.resume(first.step(), first.body().u, first.body().du, {}, first.body().history());
  for (int k = 12; k < 30; ++k) second.tick();
  CHECK(second.body().history() == whole.body().history());
  CHECK(std::memcmp(second.body().u.data(), whole.body().u.data(), whole.body().u.size() * sizeof(Double4)) == 0);
}
