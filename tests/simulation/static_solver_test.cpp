#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "base/build_info.h"
#include "batch/static_solver.h"
#include "io/csv_table.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;
using test::blockModel;
using test::blockScene;
using test::moveAlong;
using test::roller;
using test::toolAt;

namespace {

constexpr double height = 0.03, area = 0.06 * 0.06;  // m, m^2; of the block

/// The block on rollers on three sides, its top moved by `travel` in z within 1 s: a homogeneous state.
Scene rollers(double travel) {
  Scene scene = blockScene();
  scene.materials[0].material.set("poisson", 0.49);
  scene.boundaries = {roller(Vec3::Zero(), 2), roller(Vec3(-0.03, 0, 0), 0), roller(Vec3(0, -0.03, 0), 1),
                      roller(Vec3(0, 0, height), 2)};
  scene.boundaries[3].translation = Vec3(0, 0, travel);
  scene.boundaries[3].duration = 1;
  return scene;
}

/// The block between rough plates, the upper one moved by `travel` within 1 s.
Scene plates(const Vec3& travel) {
  Scene scene = blockScene();
  scene.boundaries.push_back(test::planeBoundary(Vec3(0, 0, height)));
  scene.boundaries[1].translation = travel;
  scene.boundaries[1].duration = 1;
  scene.boundaries[1].curve.kind = LoadCurve::Kind::Linear;
  return scene;
}

struct Uniaxial {
  double lateral, stress;  // 1, Pa
};
Uniaxial reference(double stretch) {
  const CsvTable table = readCsvTable(sourceFolder() + "/tests/reference/uniaxial_neo_hookean_E3000_nu0.49.csv");
  for (std::size_t r = 0; r < table.rowCount(); ++r)
    if (std::abs(table["stretch"][r] - stretch) < 1e-9)
      return {table["lateral_stretch"][r], table["nominal_stress_Pa"][r]};
  throw std::logic_error("no such stretch in the reference");
}

double largestDifference(const AlignedVector<Double4>& a, const AlignedVector<Double4>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, (toVec3(a[i]) - toVec3(b[i])).norm());
  return worst;
}

bool allFinite(const AlignedVector<Double4>& u) {
  for (const auto& a : u)
    if (!toVec3(a).allFinite()) return false;
  return true;
}

}  // namespace

TEST_CASE("A block on rollers meets the closed form of uniaxial stress", "[static_solver][whole]") {
  for (const auto method : {DiscretizationSpec::BoundaryMethod::Sebciem, DiscretizationSpec::BoundaryMethod::Ebciem})
    for (const double stretch : {0.8, 1.2}) {
      Scene scene = rollers((stretch - 1) * height);
      scene.discretization.boundary_method = method;
      const Model model = blockModel(scene);
      StaticSolver solver(model, 1, 1e-6);
      const Equilibrium e = solver.advanceTo(1);
      REQUIRE(e.converged);
      const Uniaxial exact = reference(stretch);
      const double travel = std::abs(stretch - 1) * height;
      double worst = 0;
      const auto field = fieldAt(model.node_shape, solver.body().u);
      for (int i = 0; i < model.nodeCount(); ++i) {
        const Vec3 from_corner = model.X[i] + Vec3(0.03, 0.03, 0);
        const Vec3 expected = Vec3(exact.lateral - 1, exact.lateral - 1, stretch - 1).cwiseProduct(from_corner);
        worst = std::max(worst, (field[i] - expected).norm());
      }
      const auto& top = solver.body().reactions()[3].force;
      INFO("stretch " << stretch << " method " << static_cast<int>(method) << " displacement off by " << worst / travel
                      << ", force by " << top.z() / (exact.stress * area) - 1);
      CHECK(worst <
            1e-5 *
                travel);  // consistent gradients leave 1e-7, the tolerance 1e-6 in parameters of a few times the field
      CHECK(top.z() == Approx(exact.stress * area).epsilon(1e-4));  // the bulk modulus multiplies it
      CHECK(e.min_J == Approx(std::min(1.0, exact.lateral * exact.lateral * stretch)).epsilon(1e-4));
    }
}

TEST_CASE("A block with fibres on rollers meets its closed form, stretched along them and pressed across them",
          "[static_solver][whole]") {
  constexpr double young = 3000, poisson = 0.45, k1 = 2000, k2 = 1.5;
  constexpr double mu = young / (2 * (1 + poisson)), K = young / (3 * (1 - 2 * poisson));
  for (const int along : {2, 0}) {
    const double stretch = along == 2 ? 1.3 : 0.7;
    const Vec3 fibre = Vec3::Unit(along);
    Scene scene = rollers((stretch - 1) * height);
    scene.discretization.boundary_method = DiscretizationSpec::BoundaryMethod::Ebciem;
    scene.materials[0].material = Material::of("fibre-reinforced")
                                      .set("young", young)
                                      .set("poisson", poisson)
                                      .set("k1", k1)
                                      .set("k2", k2)
                                      .set("fibre", {fibre.data(), 3});
    const Model model = blockModel(scene);
    StaticSolver solver(model, 1, 1e-6);
    for (const double time : {0.5, 1.0}) REQUIRE(solver.advanceTo(time).converged);
    // Nominal principal stresses of the stretches; the two sideways ones where theirs vanish, by Newton's iteration.
    const auto stress = [&](const Vec3& l) {
      const double J = l.prod(), e = std::max(l[along] * l[along] - 1, 0.0);
      Vec3 P = mu * std::pow(J, -2.0 / 3) * (l - l.squaredNorm() / 3 * l.cwiseInverse()) +
               K * (J - 1) * J * l.cwiseInverse();
      P[along] += 2 * k1 * e * std::exp(k2 * e * e) * l[along];
      return P;
    };
    Vec3 l(1 / std::sqrt(stretch), 1 / std::sqrt(stretch), stretch);
    for (int k = 0; k < 50; ++k) {
      const Vec3 P = stress(l), dx = (stress(l + 1e-7 * Vec3::UnitX()) - P) / 1e-7,
                 dy = (stress(l + 1e-7 * Vec3::UnitY()) - P) / 1e-7;
      const double det = dx[0] * dy[1] - dx[1] * dy[0];
      l -= Vec3(dy[1] * P[0] - dy[0] * P[1], dx[0] * P[1] - dx[1] * P[0], 0) / det;
    }
    REQUIRE(stress(l).head<2>().norm() < 1e-6 * mu);
    double worst = 0;
    const auto field = fieldAt(model.node_shape, solver.body().u);
    for (int i = 0; i < model.nodeCount(); ++i)
      worst =
          std::max(worst, (field[i] - (l - Vec3::Ones()).cwiseProduct(Vec3(model.X[i] + Vec3(0.03, 0.03, 0)))).norm());
    const double force = solver.body().reactions()[3].force.z(), exact = stress(l)[2] * area;
    INFO("fibres along " << along << ": stretches " << l.transpose() << ", displacement off by "
                         << worst / (std::abs(stretch - 1) * height) << ", force by " << force / exact - 1);
    CHECK(worst < 1e-5 * std::abs(stretch - 1) * height);
    CHECK(force == Approx(exact).epsilon(1e-4));
  }
}

TEST_CASE("A static solution is the same to the bit for any number of threads", "[static_solver][determinism]") {
  const Model model = blockModel(plates(Vec3(0.003, 0, -0.003)));
  const auto solve = [&](int threads) {
    StaticSolver solver(model, threads, 1e-3);
    CHECK(solver.advanceTo(0.5).converged);
    CHECK(solver.advanceTo(1).converged);
    return solver.body().u;
  };
  const auto one = solve(1), two = solve(2);
  CHECK(std::memcmp(one.data(), two.data(), one.size() * sizeof(Double4)) == 0);
}

TEST_CASE("The estimated error is above the true one", "[static_solver][whole]") {
  for (const Vec3& travel : {Vec3(0.004, 0, -0.004), Vec3(0, 0.01, 0), Vec3(0, 0, 0.006)}) {
    const Model model = blockModel(plates(travel));
    StaticSolver tight(model, 1, 1e-9);
    REQUIRE(tight.advanceTo(1).converged);
    for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
      StaticSolver solver(model, 1, tolerance);
      const Equilibrium e = solver.advanceTo(1);
      REQUIRE(e.converged);
      const double truth = largestDifference(solver.body().u, tight.body().u);
      INFO("travel " << travel.transpose() << " tolerance " << tolerance << " true " << truth << " estimated "
                     << e.error << " iterations " << e.iterations);
      CHECK(e.error <= tolerance * e.largest);
      CHECK(truth <= e.error);
      CHECK(truth > 0.01 * e.error);  // not by caution alone
    }
  }
}

TEST_CASE("At equilibrium the boundaries' forces and moments balance", "[static_solver]") {
  const Model model = blockModel(plates(Vec3(0.006, 0.002, -0.004)));
  StaticSolver solver(model, 1, 1e-6);
  REQUIRE(solver.advanceTo(1).converged);
  const auto& r = solver.body().reactions();
  REQUIRE(r.size() == 2);
  CHECK(r[1].force.z() < 0);  // the plate presses
  CHECK(r[1].force.x() > 0);
  CHECK((r[0].force + r[1].force).norm() < 1e-4 * r[0].force.norm());
  // About one point, and in the present configuration: P F^T is symmetric, so that no moment is left over.
  CHECK((r[0].moment + r[1].moment).norm() < 1e-4 * (r[0].moment.norm() + height * r[0].force.norm()));
  std::vector<Vec3> node_force(model.X.size(), Vec3::Zero());
  solver.body().addNodeReactions(node_force);
  Vec3 sum = Vec3::Zero();
  for (const auto& f : node_force) sum += f;
  CHECK((sum - r[0].force - r[1].force).norm() < 1e-12 * r[0].force.norm());
}

TEST_CASE("A solution that goes on from a saved state ends where the unbroken one does", "[static_solver]") {
  const Model model = blockModel(plates(Vec3(0.003, 0, -0.005)));
  const double tolerance = 1e-5;
  StaticSolver whole(model, 1, tolerance);
  AlignedVector<Double4> saved;
  Equilibrium e;
  for (int k = 1; k <= 4; ++k) {
    e = whole.advanceTo(k / 4.0);
    REQUIRE(e.converged);
    if (k == 2) saved = whole.body().u;
  }
  StaticSolver second(model, 1, tolerance);
  second.resume(0.5, saved, {});
  CHECK(second.time() == 0.5);
  for (int k = 3; k <= 4; ++k) REQUIRE(second.advanceTo(k / 4.0).converged);
  CHECK(largestDifference(whole.body().u, second.body().u) < 2 * tolerance * e.largest);  // the two errors
  CHECK((whole.body().reactions()[1].force - second.body().reactions()[1].force).norm() <
        1e-3 * whole.body().reactions()[1].force.norm());
}

TEST_CASE("A tool pressed statically has the real-time loop's force at rest", "[static_solver][contact][whole]") {
  const Model model = blockModel();
  constexpr double depth = 0.003;
  StaticSolver solver(model, 1, 1e-4);
  const Equilibrium e = solver.advanceTo(1, toolAt(model, model.tools.first().first_contact_travel + depth));
  REQUIRE(e.converged);

  State state = initialState(model);
  Workspace workspace(model, 1);
  const StepReport report = moveAlong(model, state, workspace, 1000, [&](int k) {  // 1 s down, 1 s to come to rest
    return (model.tools.first().first_contact_travel + depth) * LoadCurve{}.at(k / model.scene.dynamics.rate_hz, 1.0);
  });
  REQUIRE(report.flags == 0);
  INFO("static " << e.tool_force.transpose() << " loop " << report.tool_force.transpose());
  CHECK(e.tool_force.z() > 0.01);
  CHECK((e.tool_force - report.tool_force).norm() < 0.01 * report.tool_force.norm());
  CHECK((solver.body().reactions()[0].force - e.tool_force).norm() < 0.01 * e.tool_force.norm());
}

TEST_CASE("Where a tool only just touches, zero is an equilibrium", "[static_solver][contact][whole]") {
  const Model model = blockModel();
  // The travel at which the sphere meets its first skin vertex, |v - c| = R.
  const double R = model.scene.tools[0].shape.radius;
  double touch = 1;
  for (const Vec3& v : model.skin.surface.vertices) {
    const Vec3 from_axis = v - model.tools.first().start.pose.position;
    const double r2 = from_axis.head<2>().squaredNorm();
    if (r2 < R * R) touch = std::min(touch, -from_axis.z() - std::sqrt(R * R - r2) + R);
  }
  REQUIRE(touch > model.tools.first().first_contact_travel);
  REQUIRE(touch < model.tools.first().first_contact_travel + 1e-3);
  double largest = 0;
  for (const double deeper : {-1e-6, 0.0, 1e-15, 1e-13, 1e-12, 1e-9})
    for (const double tolerance : {1e-3, 1e-6}) {
      StaticSolver solver(model, 1, tolerance);
      const Equilibrium e = solver.advanceTo(1, toolAt(model, touch + deeper));
      INFO("deeper " << deeper << " tolerance " << tolerance << " error " << e.error << " largest " << e.largest);
      CHECK(e.converged);
      CHECK(e.iterations < StaticSolver::max_iterations / 4);
      CHECK(e.largest < 3e-9);
      largest = std::max(largest, e.largest);
    }
  CHECK(largest > 1e-10);  // the deepest does touch
}

TEST_CASE("A watch interrupts a solution, which can be taken up again", "[static_solver]") {
  const Model model = blockModel(plates(Vec3(0, 0, -0.003)));
  StaticSolver solver(model, 1, 1e-4);
  int calls = 0, last = 0;
  const Equilibrium stopped = solver.advanceTo(1, {}, [&](int iterations) {
    CHECK(iterations > last);
    last = iterations;
    return ++calls < 4;
  });
  CHECK(stopped.interrupted);
  CHECK_FALSE(stopped.converged);
  CHECK_FALSE(stopped.diverged);
  CHECK(calls == 4);
  CHECK(stopped.iterations == last);
  CHECK(allFinite(solver.body().u));
  const Equilibrium e = solver.advanceTo(1);
  CHECK(e.converged);
  StaticSolver unbroken(model, 1, 1e-4);
  REQUIRE(unbroken.advanceTo(1).converged);
  CHECK(largestDifference(solver.body().u, unbroken.body().u) < 2e-4 * e.largest);
}

TEST_CASE("An impossible load is owned up to, and leaves no number that is not one", "[static_solver][whole]") {
  // The upper plate goes through the lower: no equilibrium that the material can have.
  const Model model = blockModel(plates(Vec3(0, 0, -1.5 * height)));
  StaticSolver solver(model, 2, 1e-3);
  const Equilibrium e = solver.advanceTo(1);
  INFO("iterations " << e.iterations << " diverged " << e.diverged << " converged " << e.converged << " inverted "
                     << e.inverted_points);
  CHECK(e.diverged);
  CHECK_FALSE(e.converged);
  REQUIRE(allFinite(solver.body().u));
  for (const auto& u : solver.body().u) CHECK(toVec3(u).norm() == 0);  // the last equilibrium: at rest
}
