#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "batch/static_solver.h"
#include "batch/transient_solver.h"
#include "model/model_hash.h"
#include "step/resolution.h"
#include "step/step.h"
#include "step/tool_bodies.h"
#include "step/trust.h"
#include "step/workspace.h"
#include "support/realtime_guard.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;

namespace {

constexpr double g = 9.81;  // m/s^2

/// The half-space beneath a plane.
RigidSpec halfSpace(const Vec3& point, const Vec3& normal, double friction = 0) {
  RigidSpec body;
  body.name = "floor";
  body.region.point = point;
  body.region.normal = normal;
  body.friction = friction;
  return body;
}

/// A body that goes somewhere in a second, or in so many.
RigidSpec moved(RigidSpec body, const Vec3& translation, double duration = 1) {
  body.name += ", moved";
  body.motion.translation = translation;
  body.motion.duration = duration;
  return body;
}

/// The block of blockScene on a floor, held by nothing else.
Scene lyingScene(double friction = 0) {
  Scene scene = test::blockScene();
  scene.boundaries.clear();
  scene.dynamics.gravity = Vec3(0, 0, -g);
  scene.rigid = {halfSpace(Vec3::Zero(), Vec3::UnitZ(), friction)};
  scene.tools[0].position = Vec3(0, 0, 0.2);
  return scene;
}

/// Ticks with the tool where it starts.
struct Run {
  explicit Run(const Model& the_model, int threads = 1)
      : model(the_model), workspace(the_model, threads), state(initialState(the_model)) {
    command.tools[0].pose = model.tools.first().start.pose;
  }
  StepReport ticks(int count) {
    StepReport report;
    for (int k = 0; k < count; ++k) {
      report = tick(model, state, command, workspace);
      flags |= report.flags;
      doubt = std::max(doubt, doubtOf(model, report));
    }
    return report;
  }
  /// Mean over the mass: the way, m, and the last step's speed, m/s.
  Vec3 mean(const AlignedVector<Float4>& field) const {
    Vec3 sum = Vec3::Zero();
    double mass = 0;
    for (std::size_t i = 0; i < field.size(); ++i) sum += model.mass[i] * toVec3(field[i]), mass += model.mass[i];
    return sum / mass;
  }
  Vec3 way() const { return mean(state.u); }
  Vec3 speed() const { return mean(state.du) / model.dt; }
  std::uint64_t hash() const { return stateHash(model, state); }

  const Model& model;
  Workspace workspace;
  State state;
  Command command;
  std::uint32_t flags = 0;
  Doubt doubt = Doubt::None;
};

double weightOf(const Model& model) {
  double weight = 0;
  for (const Double4& f : model.weight) weight += toVec3(f).norm();
  return weight;
}

/// N, on a neo-Hookean bar of this section, pressed to `stretch` of its length and free across.
double uniaxialForce(double young, double poisson, double stretch, double section) {
  const double mu = young / (2 * (1 + poisson)), bulk = young / (3 * (1 - 2 * poisson));
  const auto energy = [&](double along, double across) {
    const double J = along * across * across;
    return 0.5 * mu * (std::pow(J, -2.0 / 3) * (along * along + 2 * across * across) - 3) +
           0.5 * bulk * (J - 1) * (J - 1);
  };
  constexpr double h = 1e-6;
  double low = 0.5, high = 2;  // the width that costs least
  while (high - low > 1e-12) {
    const double middle = 0.5 * (low + high);
    (energy(stretch, middle + h) > energy(stretch, middle - h) ? high : low) = middle;
  }
  return -section * (energy(stretch + h, low) - energy(stretch - h, low)) / (2 * h);
}

}  // namespace

TEST_CASE("A block that nothing else holds lies on a floor, which bears its weight", "[simulation][rigid]") {
  const Model model = test::blockModel(lyingScene());
  Run run(model);
  const StepReport report = run.ticks(400);
  CHECK(report.rigid[0].force.z() == Approx(weightOf(model)).epsilon(1e-3));
  CHECK(report.rigid[0].max_penetration < 1e-4);
  CHECK(report.max_increment < 1e-5 * model.dt);  // m/s: it rests
  CHECK(run.way().head<2>().norm() < 1e-4);
  CHECK(run.flags == 0);
}

TEST_CASE("Neither threads nor where points were looked for last change a bit, and steps take no memory",
          "[simulation][rigid]") {
  const double duration = GENERATE(0.1, 0.004);  // s; the second at 1.5 m/s, from out of sight
  Scene scene = lyingScene(0.4);
  scene.rigid.push_back(moved(halfSpace(Vec3(0, 0, duration > 0.01 ? 0.0302 : 0.036), -Vec3::UnitZ(), 0.2),
                              Vec3(0.002, 0, duration > 0.01 ? -0.006 : -0.0118), duration));
  const Model model = test::blockModel(scene);
  Run one(model), two(model, 2), forgetful(model);
  one.ticks(40);
  two.ticks(40);
  for (int k = 0; k < 40; ++k) {
    forgetful.state.rigid.lookAgain();
    forgetful.ticks(1);
  }
  CHECK(one.hash() == two.hash());
  CHECK(one.hash() == forgetful.hash());
  REQUIRE(one.state.rigid.near_count < model.rigid.pointCount() / 2);  // the sides are far from both

  Run later(model);  // a state that was kept goes on as if nothing had been
  later.state = one.state;
  if (test::guardAvailable()) test::startGuard();
  one.ticks(10);
  CHECK((!test::guardAvailable() || test::stopGuard().total() == 0));
  later.ticks(10);
  CHECK(one.hash() == later.hash());
  later.state.rigid.normal[one.state.rigid.near[0]].x() += 0.5F;  // it is remembered
  CHECK(one.hash() != later.hash());
}

TEST_CASE("Between two smooth plates a block is compressed as a bar", "[simulation][rigid][static][whole]") {
  Scene scene = test::blockScene(0.01);
  scene.boundaries = {test::roller(Vec3(-0.03, 0, 0), 0),  // planes of symmetry, which leave it free to widen
                      test::roller(Vec3(0, -0.03, 0), 1)};
  const double squeeze = 0.003;
  scene.rigid = {halfSpace(Vec3::Zero(), Vec3::UnitZ()),
                 moved(halfSpace(Vec3(0, 0, 0.03), -Vec3::UnitZ()), -squeeze * Vec3::UnitZ())};
  const Model model = test::blockModel(scene);
  StaticSolver solver(model, 1, 1e-4);
  const Equilibrium pressed = solver.advanceTo(1);
  const double force = uniaxialForce(3000, 0.48, 1 - squeeze / 0.03, 0.0036);
  CHECK(pressed.rigid[0].force.z() == Approx(force).epsilon(0.01));
  CHECK(pressed.rigid[1].force.z() == Approx(-force).epsilon(0.01));
  CHECK(pressed.rigid[0].max_penetration < 2e-5);
}

TEST_CASE("A block on a slope sticks below the angle of friction without creeping, and slides above it",
          "[simulation][rigid][whole]") {
  const auto onSlope = [](double tangent, double friction) {
    Scene scene = lyingScene(friction);
    const double angle = std::atan(tangent);
    scene.dynamics.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle));
    return scene;
  };
  SECTION("it sticks") {
    const Model model = test::blockModel(onSlope(0.4, 0.5));
    Run run(model);
    run.ticks(200);
    const Vec3 before = run.way();
    const StepReport report = run.ticks(200);
    CHECK((run.way() - before).norm() < 1e-6);
    CHECK(report.rigid[0].force.x() == Approx(-weightOf(model) * std::sin(std::atan(0.4))).epsilon(2e-3));
  }
  SECTION("it slides") {
    Scene scene = onSlope(0.5, 0.2);  // where much more friction makes the block chatter
    scene.materials[0].material.set("young", 30e3);
    scene.dynamics.damping = 10;
    const Model model = test::blockModel(scene);
    Run run(model);
    const double angle = std::atan(0.5), a = g * (std::sin(angle) - 0.2 * std::cos(angle)), c = scene.dynamics.damping;
    for (const int ticks : {40, 80}) {
      const StepReport report = run.ticks(40);
      CHECK(run.speed().x() == Approx(a / c * (1 - std::exp(-c * ticks / scene.dynamics.rate_hz))).epsilon(0.02));
      CHECK(-report.rigid[0].force.x() == Approx(0.2 * report.rigid[0].force.z()).epsilon(2e-3));
    }
  }
}

TEST_CASE("A table carries what lies on it, along and about", "[simulation][rigid][whole]") {
  Scene scene = lyingScene(0.8);
  scene.rigid[0].motion.duration = 0.4;
  SECTION("along") {
    scene.rigid[0].motion.translation = Vec3(0.02, 0, 0);
    const Model model = test::blockModel(scene);
    Run run(model);
    run.ticks(300);
    CHECK(run.way().x() == Approx(0.02).margin(5e-5));
  }
  SECTION("about") {
    scene.rigid[0].motion.axis = Vec3::UnitZ();
    scene.rigid[0].motion.angle = 0.5;
    scene.materials[0].material.set("young", 30e3);
    const Model model = test::blockModel(scene);
    scene.rigid[0].motion = {};
    const Model standing = test::blockModel(scene);
    Run run(model), still(standing);
    run.ticks(250);
    still.ticks(250);
    const Pose pose = model.rigid.body[0].at(1);
    double farthest = 0;
    for (std::size_t i = 0; i < model.X.size(); ++i)
      farthest = std::max(
          farthest, (model.X[i] + toVec3(run.state.u[i]) - pose.toWorld(model.X[i] + toVec3(still.state.u[i]))).norm());
    CHECK(farthest < 1e-4);
  }
}

TEST_CASE("A rigid sphere presses as the same sphere held by a hand", "[simulation][rigid][static][whole]") {
  const Scene scene = test::blockScene();
  const double press = 0.006;
  const Model by_hand = test::blockModel(scene);
  StaticSolver hand(by_hand, 1, 1e-4);
  const Equilibrium held = hand.advanceTo(1, test::toolAt(by_hand, press));
  Scene with_ball = scene;
  with_ball.tools[0].position.z() = 0.1;
  RigidSpec ball;
  ball.name = "ball";
  ball.region.kind = Region::Kind::Sphere;
  ball.region.point = scene.tools[0].position + Vec3(0, 0, 0.01);
  ball.region.radius = 0.01;
  for (const bool of_file : {false, true}) {
    if (of_file) {  // the same as a surface
      TriangleSurface surface = ellipsoidSurface(Vec3::Constant(0.01), 0.0004);
      for (Vec3& x : surface.vertices) x += ball.region.point;
      ball.surface = std::make_shared<const TriangleSurface>(std::move(surface));
    }
    with_ball.rigid = {moved(ball, -press * Vec3::UnitZ())};
    const Model by_body = test::blockModel(with_ball);
    StaticSolver body(by_body, 1, 1e-4);
    const Equilibrium pressed = body.advanceTo(1);
    REQUIRE((held.converged && pressed.converged));
    CAPTURE(of_file);
    CHECK(-pressed.rigid[0].force.z() == Approx(held.tool_force.z()).epsilon(0.01));
    CHECK(pressed.expected_error == Approx(held.expected_error).epsilon(0.3));
  }
}

TEST_CASE("A thin rod of a surface file presses as the same cylinder, and is told to be thin", "[simulation][rigid]") {
  Scene scene = test::blockScene(0.005);
  scene.tools[0].position.z() = 0.2;
  RigidSpec rod;
  rod.name = "rod";
  rod.region.kind = Region::Kind::Cylinder;
  rod.region.normal = Vec3::UnitX();
  rod.region.radius = 0.0015;
  rod.region.height = 0.02;
  rod.region.point = Vec3(-0.01, 0, scene.organs[0].size.z() + 0.0017);
  double force[2] = {};
  for (const bool of_file : {false, true}) {
    if (of_file) {
      constexpr int around = 24, along = 20;
      TriangleSurface surface;
      for (int k = 0; k <= along; ++k)
        for (int a = 0; a < around; ++a)
          surface.vertices.push_back(rod.region.point + Vec3(0.02 * k / along, 0.0015 * std::cos(2 * M_PI * a / around),
                                                             0.0015 * std::sin(2 * M_PI * a / around)));
      const int first = static_cast<int>(surface.vertices.size());
      surface.vertices.push_back(rod.region.point);
      surface.vertices.push_back(rod.region.point + Vec3(0.02, 0, 0));
      for (int a = 0; a < around; ++a) {
        const int b = (a + 1) % around;
        surface.triangles.push_back({first, b, a});
        surface.triangles.push_back({first + 1, along * around + a, along * around + b});
        for (int k = 0; k < along; ++k) {
          const int p = k * around + a, q = k * around + b;
          surface.triangles.push_back({p, q, p + around});
          surface.triangles.push_back({q, q + around, p + around});
        }
      }
      rod.surface = std::make_shared<const TriangleSurface>(std::move(surface));
    }
    scene.rigid = {moved(rod, Vec3(0, 0, -0.0042), 0.3)};
    const Model model = test::blockModel(scene);
    CHECK_FALSE(resolutionWarning(model).empty());
    State state = initialState(model);
    Workspace workspace(model, 1);
    Command command;
    command.tools[0].pose = model.tools.first().start.pose;
    StepReport report;
    for (int k = 0; k < 250; ++k) report = tick(model, state, command, workspace);
    force[of_file] = -report.rigid[0].force.z();
    // Nothing else presses, and its force is doubted for the nodes.
    CHECK(report.rigid[0].expected_error > TrustLimits::expected_error);
    CHECK(report.error_by == max_tools);
    CHECK(doubtOf(model, report) == Doubt::Resolution);
  }
  CHECK(force[0] > 0.1);
  CHECK(force[1] == Approx(force[0]).epsilon(0.1));
}

TEST_CASE("A blade that goes between the points of the skin is doubted, as a region and as a file",
          "[simulation][rigid]") {
  Scene scene = test::blockScene(0.012);
  scene.tools[0].position.z() = 0.2;
  RigidSpec blade;
  blade.name = "blade";
  blade.region.kind = Region::Kind::Box;
  const double top = scene.organs[0].size.z();
  blade.region.min = Vec3(0.0011, -0.1, top + 0.0005);
  blade.region.max = Vec3(0.0016, 0.1, top + 0.02);
  for (const bool of_file : {false, true}) {
    CAPTURE(of_file);
    if (of_file) {
      TriangleSurface surface = boxSurface(blade.region.max - blade.region.min, 1);
      const Vec3 shift = 0.5 * (blade.region.min + blade.region.max) - boundingBox(surface).center();
      for (Vec3& x : surface.vertices) x += shift;
      blade.surface = std::make_shared<const TriangleSurface>(std::move(surface));
    }
    scene.rigid = {moved(blade, Vec3(0, 0, -0.0045), 0.2)};
    const Model model = test::blockModel(scene);
    Run run(model);
    const StepReport report = run.ticks(400);
    CHECK(report.rigid[0].force.norm() < 0.05);  // it should be some tenths of a newton
    CHECK(report.rigid[0].max_penetration > 0.003);
    CHECK(doubtOf(model, report) == Doubt::Contact);
  }
}

TEST_CASE("Tissue that slides to and fro on a rigid ball gains no energy", "[simulation][rigid][whole]") {
  Scene scene = test::blockScene();
  scene.tools[0].position.z() = 0.2;
  scene.dynamics.damping = 0;
  RigidSpec ball;
  ball.name = "ball";
  ball.region.kind = Region::Kind::Sphere;
  ball.region.radius = 0.008;
  ball.region.point = Vec3(0, 0, 0.030 + ball.region.radius);
  const double press = 0.009;
  scene.rigid = {moved(ball, -press * Vec3::UnitZ(), 0.3)};
  const Model model = test::blockModel(scene);
  Run run(model);
  const auto largest = [&](int ticks) {
    double energy = 0;
    for (int k = 0; k < ticks; ++k) energy = std::max(energy, run.ticks(1).kinetic_energy);
    return energy;
  };
  run.ticks(200);
  const double early = largest(200), late = (run.ticks(2000), largest(200));
  std::printf("beside a rigid ball: kinetic energy %.2e J, 4 s later %.2e J\n", early, late);
  CHECK(late < 1.1 * early);
}

TEST_CASE("In time a plate presses as in equilibrium, in float and in double", "[simulation][rigid][whole]") {
  Scene scene = test::blockScene();  // on a fixed base
  scene.rigid = {moved(halfSpace(Vec3(0, 0, 0.03), -Vec3::UnitZ()), Vec3(0, 0, -0.002), 0.4)};
  scene.tools[0].position.z() = 0.2;
  scene.rigid[0].region.point.z() = 0.0301;
  const Model model = test::blockModel(scene);
  StaticSolver solver(model, 1, 1e-3);
  const double force = -solver.advanceTo(0.4).rigid[0].force.z();
  Run run(model);
  CHECK(-run.ticks(300).rigid[0].force.z() == Approx(force).epsilon(0.01));
  TransientSolver motion(model, 1);
  BatchBody::Report report;
  for (int k = 0; k < 300; ++k) report = motion.tick();
  CHECK(-report.contact.rigid[0].force.z() == Approx(force).epsilon(0.01));
}

TEST_CASE("Plates that hold a block by friction press it as bonded ones, in float and in double",
          "[simulation][rigid]") {
  // Cells take pressure over from the patches of what flows freely: beside what is held they are 17 % too stiff here.
  Scene scene = test::blockScene(0.006);
  scene.organs[0].size = Vec3(0.04, 0.04, 0.03);
  scene.materials[0].material.set("poisson", 0.49);
  scene.tools[0].position.z() = 0.2;
  const Vec3 way(0, 0, -0.009);
  Scene held = scene;
  held.boundaries.push_back(test::planeBoundary(Vec3(0, 0, 0.03)));
  held.boundaries.back().translation = way;
  held.boundaries.back().duration = 0.3;
  scene.boundaries.clear();
  scene.rigid = {halfSpace(Vec3::Zero(), Vec3::UnitZ(), 1),
                 moved(halfSpace(Vec3(0, 0, 0.03), -Vec3::UnitZ(), 1), way, 0.3)};
  constexpr int ticks = 250;
  const Model bonded = test::blockModel(held), pressed = test::blockModel(scene);
  Run bonded_run(bonded), run(pressed);
  const double force = bonded_run.ticks(ticks).base_reaction.z();
  CHECK(run.ticks(ticks).rigid[0].force.z() == Approx(force).epsilon(0.05));
  CHECK(run.doubt == bonded_run.doubt);
  TransientSolver motion(pressed, 1);
  BatchBody::Report report;
  for (int k = 0; k < ticks; ++k) report = motion.tick();
  CHECK(report.contact.rigid[0].force.z() == Approx(run.ticks(1).rigid[0].force.z()).epsilon(0.005));
}

TEST_CASE("A ball with finer nodes below lies on a plate with all of its skin", "[simulation][rigid]") {
  Scene scene = lyingScene();
  scene.organs[0].solid = OrganSpec::Solid::Ellipsoid;
  scene.organs[0].semi_axes = Vec3::Constant(0.02);
  scene.dynamics.gravity.setZero();
  scene.discretization.spacing = 0.008;
  RefineSpec& refine = scene.discretization.refine.emplace_back();
  refine.centre = Vec3(0, 0, -0.02);
  refine.radius = 0.008;
  refine.spacing = 0.0025;
  scene.rigid = {moved(halfSpace(Vec3(0, 0, -0.0201), Vec3::UnitZ()), Vec3(0, 0, 0.0011), 0.2)};
  BoundarySpec& held = scene.boundaries.emplace_back();
  held.region.kind = Region::Kind::HalfSpace;
  held.region.normal = -Vec3::UnitZ();
  const Model model = buildModel(scene, ellipsoidSurface(scene.organs[0].semi_axes, 0.003));
  Run run(model);
  run.ticks(150);
  double deepest = 0, told = 0;
  for (int v = 0; v < model.skin.vertexCount(); ++v)
    deepest = std::max(deepest, -0.019 - skinPosition(model.skin, v, run.state.u.data()).z());
  StepReport report;
  for (int k = 0; k < 128; ++k) told = std::max(told, (report = run.ticks(1)).rigid[0].max_penetration);
  std::printf("a refined ball on a plate: %.3f mm deep, %.3f told\n", 1e3 * deepest, 1e3 * told);
  CHECK(deepest < 0.1 * refine.spacing);
  CHECK(told == Approx(deepest).margin(1e-5));  // at the points and between them
  CHECK(report.expected_error < 1);             // known, though no tool touches and nothing that is held stands still
  StaticSolver solver(model, 1, 1e-3);
  const Equilibrium pressed = solver.advanceTo(1);
  CHECK(pressed.rigid[0].force.z() == Approx(report.rigid[0].force.z()).epsilon(0.01));
  CHECK(pressed.rigid[0].max_penetration == Approx(deepest).margin(1e-5));
}

TEST_CASE("A sheet between a tool and a floor is held by both, whatever the time step", "[simulation][rigid][whole]") {
  Scene scene = lyingScene(0.5);
  scene.organs[0].size.z() = 0.006;
  scene.discretization.spacing = 0.005;
  scene.tools[0].position = Vec3(-0.005, 0, 0.0061);
  scene.tools[0].friction = 0.5;
  const auto draggedAside = [&](double time_step) {  // force on the tool, N
    scene.dynamics.time_step = time_step;
    const Model model = buildModel(scene, boxSurface(scene.organs[0].size, 0.003));
    Run run(model);
    for (int k = 1; k <= 250; ++k) {
      run.command.tools[0].pose =
          test::toolAt(model, 0.002 * std::min(1.0, k / 60.0), 0.003 * std::clamp((k - 80) / 100.0, 0.0, 1.0));
      run.ticks(1);
    }
    return std::pair(run.ticks(50).tool_force, model.dt);
  };
  const auto [force, dt] = draggedAside(0);
  const Vec3 finer = draggedAside(dt / 4).first;
  std::printf("a sheet between tool and floor: %.4f N aside, with a fourth of the step %.4f N\n", -force.x(),
              -finer.x());
  CHECK(-force.x() > 0.1 * force.z());
  CHECK((force - finer).norm() < 0.01 * force.norm());
}

TEST_CASE("Jabs of a plate at 1 m/s do not blow a block up", "[simulation][rigid]") {
  Scene scene = lyingScene(0.5);
  RigidSpec plate;
  plate.name = "plate";
  plate.region.kind = Region::Kind::Box;
  plate.region.min = Vec3(-0.05, -0.05, 0.031);
  plate.region.max = Vec3(0.01, 0.05, 0.036);
  plate.motion.translation = Vec3(0, 0, -0.018);
  plate.motion.curve = {LoadCurve::Kind::Table, {0, 0.018, 0.036, 0.054, 0.072, 0.2}, {0, 1, 0, 1, 0, 0}};
  plate.motion.duration = 0.2;
  scene.rigid.push_back(plate);
  const Model model = test::blockModel(scene);
  Run run(model);
  run.ticks(36);
  CHECK((run.flags & (kNotFinite | kBlowUp)) == 0);
  const StepReport report = run.ticks(300);
  CHECK((run.flags & (kNotFinite | kBlowUp)) == 0);
  CHECK(report.rigid[0].max_penetration < 1e-4);
  CHECK(report.min_J > 0.5F);
  CHECK(report.rigid[0].force.z() == Approx(weightOf(model)).epsilon(0.02));  // it lies there again
}

TEST_CASE("A fast plate presses as a slow one, however thin, and however long the time step", "[simulation][rigid]") {
  Scene scene = test::blockScene();
  scene.tools[0].position.z() = 0.2;
  scene.dynamics.damping = 200;
  const double top = scene.organs[0].size.z();
  double slow = 0;
  for (const auto& [thick, duration, from] : {std::tuple(0.01, 0.3, 0.001), std::tuple(0.0001, 0.008, 0.0003),
                                              std::tuple(0.0005, 0.006, 0.006), std::tuple(0.002, 0.004, 0.001)}) {
    CAPTURE(thick, duration, from);
    RigidSpec plate;
    plate.name = "plate";
    plate.region.kind = Region::Kind::Box;
    plate.region.min = Vec3(-0.06, -0.06, top + from);
    plate.region.max = Vec3(0.06, 0.06, top + from + thick);
    scene.rigid = {moved(plate, Vec3(0, 0, -0.003 - from), duration)};
    scene.rigid[0].motion.curve.kind = LoadCurve::Kind::Linear;
    const Model model = test::blockModel(scene);
    Run run(model);
    const StepReport report = run.ticks(300);
    CHECK(report.rigid[0].max_penetration < 1e-4);
    if (slow == 0) slow = report.rigid[0].force.z();
    CHECK(report.rigid[0].force.z() == Approx(slow).epsilon(2e-3));
    for (int v = 0; v < model.skin.vertexCount(); ++v)
      REQUIRE(skinPosition(model.skin, v, run.state.u.data()).z() < top - 0.003 + 2e-4);
  }
}

TEST_CASE("What rigid bodies can't be is refused", "[simulation][rigid]") {
  const auto fails = [](const Scene& scene, const char* text) {
    CHECK_THAT(refusal([&] {
                 const Model model = test::blockModel(scene);
                 StaticSolver(model, 1, 1e-3);
               }),
               Catch::Matchers::Contains(text));
  };
  Scene scene = lyingScene();
  fails(scene, "free to slide");
  scene.boundaries = test::blockScene().boundaries;
  scene.rigid[0].friction = 0.5;
  fails(scene, "depends on the way");
  scene.rigid[0] = halfSpace(Vec3(0, 0, 0.0025), Vec3::UnitZ());
  fails(scene, "reaches 2.5 mm into the rigid body \"floor\"");
}

TEST_CASE("In an equilibrium a floor bears what a tool presses", "[simulation][rigid][whole]") {
  Scene scene = test::blockScene();
  scene.boundaries = {test::roller(Vec3(-0.03, 0, 0), 0), test::roller(Vec3(0, -0.03, 0), 1)};
  RigidSpec floor;
  floor.name = "floor";
  scene.rigid = {floor};
  const Model model = test::blockModel(scene);
  StaticSolver solver(model, 2, 1e-4);
  const Equilibrium equilibrium = solver.advanceTo(0, test::toolAt(model, 0.005));
  REQUIRE(equilibrium.converged);
  CHECK(equilibrium.tool_force.z() > 0.01);
  CHECK(equilibrium.rigid[0].force.z() == Approx(equilibrium.tool_force.z()).epsilon(1e-3));
}
