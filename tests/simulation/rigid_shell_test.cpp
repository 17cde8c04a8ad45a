#include <catch2/catch.hpp>

#include "batch/static_solver.h"
#include "batch/transient_solver.h"
#include "model/model_hash.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/realtime_guard.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;

namespace {

constexpr double ball_radius = 0.03, ball_clearance = 5e-4;

/// A heavy ball in a skull half a millimetre around it; guided so that nothing but the skull bears its weight.
Scene heavyBallScene() {
  Scene scene = test::blockScene(0.011);
  scene.organs[0].solid = OrganSpec::Solid::Ellipsoid;
  scene.organs[0].semi_axes = Vec3::Constant(ball_radius);
  scene.dynamics.gravity = Vec3(0, 0, -9.81);
  scene.dynamics.damping = 60;
  scene.tools[0].position = Vec3(0, 0, 0.06);
  BoundarySpec& guide = scene.boundaries[0];
  guide.region.kind = Region::Kind::Box;
  guide.region.min = Vec3(-0.012, -0.012, -0.012);
  guide.region.max = Vec3(0.012, 0.012, 0.012);
  guide.component[2] = false;
  RigidSpec& skull = scene.rigid.emplace_back();
  skull.name = "skull";
  skull.of_organ = skull.encloses = true;
  skull.clearance = ball_clearance;
  return scene;
}

Model heavyBallModel(const Scene& scene = heavyBallScene()) {
  return buildModel(scene, ellipsoidSurface(scene.organs[0].semi_axes, 0.004));
}

double ownWeight(const Model& model) {
  double weight = 0;
  for (const Double4& f : model.weight) weight -= f.z;
  return weight;
}

/// m, how deep the skin is in the organ's own skull at most.
template <class Positions>
double deepest(const Model& model, const Positions& positionOf) {
  const SurfaceTree shell(ellipsoidSurface(model.scene.organs[0].semi_axes, 0.004));
  double depth = -1;
  for (int v = 0; v < model.skin.vertexCount(); ++v)
    depth = std::max(depth, shell.signedDistance(positionOf(v)) - model.scene.rigid[0].clearance);
  return depth;
}

/// Steps until it rests, the tool far away.
StepReport settled(const Model& model, State& state, int threads = 1, int ticks = 500) {
  Workspace workspace(model, threads);
  Command command;
  command.tools[0].pose = model.tools.first().start.pose;
  StepReport report;
  for (int k = 0; k < ticks; ++k) report = tick(model, state, command, workspace);
  return report;
}

}  // namespace

TEST_CASE("A ball rests in its skull, which bears its weight, whatever the threads", "[simulation][rigid][whole]") {
  const Model model = heavyBallModel();
  State state = initialState(model), other = initialState(model);
  const StepReport report = settled(model, state);
  CHECK(report.rigid[0].force.z() == Approx(ownWeight(model)).epsilon(0.01));
  CHECK(report.rigid[0].max_penetration < 1e-4);
  CHECK(report.flags == 0);
  CHECK(report.max_increment < 1e-5 * model.dt);  // m/s; where the normal jumped from cell to cell, 20 mm/s
  CHECK(deepest(model, [&](int v) { return skinPosition(model.skin, v, state.u.data()); }) < 1e-4);

  State half = initialState(model);
  settled(model, half, 1, 20);
  settled(model, other, 2, 20);
  CHECK(stateHash(model, half) == stateHash(model, other));
  other.rigid.force[0].x += 1e-6F;  // it is remembered
  CHECK(stateHash(model, half) != stateHash(model, other));
}

TEST_CASE("A static solution in a skull rests, and a transient one comes to the same",
          "[simulation][rigid][static][whole]") {
  const Model model = heavyBallModel();
  StaticSolver solver(model, 1, 1e-2);
  const Equilibrium rest = solver.advanceTo(1);
  REQUIRE(rest.converged);
  TransientSolver motion(model, 1);
  BatchBody::Report report;
  for (int k = 0; k < 130; ++k) report = motion.tick();
  CHECK(rest.rigid[0].force.z() == Approx(ownWeight(model)).epsilon(5e-3));
  CHECK(report.contact.rigid[0].force.z() == Approx(ownWeight(model)).epsilon(0.02));
  CHECK(report.contact.rigid[0].max_penetration < 1e-4);
  double sag[2] = {0, 0};
  for (int which = 0; which < 2; ++which) {
    const AlignedVector<Double4>& u = which == 0 ? solver.body().u : motion.body().u;
    AlignedVector<Float4> rounded;
    for (const Double4& a : u) rounded.push_back(toFloat4(toVec3(a)));
    CHECK(deepest(model, [&](int v) { return skinPosition(model.skin, v, rounded.data()); }) < 1e-4);
    for (std::size_t i = 0; i < u.size(); ++i) sag[which] -= model.mass[i] * u[i].z;
  }
  CHECK(sag[0] == Approx(sag[1]).epsilon(0.02));  // 1.2 mm on average
}

TEST_CASE("Where the skull is open nothing holds the skin, and steps with it take no memory",
          "[simulation][rigid][whole]") {
  Scene scene = heavyBallScene();
  Region below;
  below.point = Vec3(0, 0, 0);  // a half-space: z <= 0
  scene.rigid[0].open.push_back(below);
  const Model open = heavyBallModel(scene), closed = heavyBallModel();
  CHECK(modelHash(open) != modelHash(closed));
  State state = initialState(open);
  CHECK(settled(open, state, 1, 60).rigid[0].force.z() < 0.05 * ownWeight(open));
  CHECK(deepest(open, [&](int v) { return skinPosition(open.skin, v, state.u.data()); }) > 2e-3);

  State held = initialState(closed);
  Workspace workspace(closed, 1);
  Command command;
  command.tools[0].pose = closed.tools.first().start.pose;
  for (int k = 0; k < 40; ++k) tick(closed, held, command, workspace);
  REQUIRE(held.rigid.force.size() > 20);
  if (test::guardAvailable()) test::startGuard();
  for (int k = 0; k < 5; ++k) tick(closed, held, command, workspace);
  CHECK((!test::guardAvailable() || test::stopGuard().total() == 0));
}

TEST_CASE("A skull of its own that the organ does not fit in is refused", "[simulation][rigid]") {
  Scene scene = heavyBallScene();
  scene.rigid[0].of_organ = false;
  scene.rigid[0].surface =
      std::make_shared<TriangleSurface>(ellipsoidSurface(Vec3::Constant(ball_radius - 0.003), 0.004));
  CHECK_THAT(refusal([&] { heavyBallModel(scene); }), Catch::Matchers::Contains("through the skull"));
}
