#include "batch/sensitivity.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "imaging/membership.h"
#include "support/small_scene.h"

using namespace palpate;
using Kind = EquilibriumQuantity::Kind;

namespace {

/// The block with a stiffer ball in it, under a tool without friction.
Scene lumpScene(double poisson = 0.45) {
  Scene scene = test::blockScene();
  scene.tools[0].friction = 0;
  scene.materials[0].material.set("poisson", poisson);
  MaterialSpec lump;
  lump.material = Material::neoHookean(9000, poisson, 1000);
  lump.everywhere = false;
  lump.region.kind = Region::Kind::Sphere;
  lump.region.point = Vec3(0.005, 0, 0.017);
  lump.region.radius = 0.01;
  scene.materials.push_back(lump);
  return scene;
}

/// A tool that is pressed in beside the middle, not along an axis of anything.
Pose pressed(const Model& model, double depth = 0.002) {
  return test::toolAt(model, model.tools.first().first_contact_travel + depth, 0.006);
}

EquilibriumQuantity quantity(Kind kind, const Vec3& direction, const Model& model) {
  EquilibriumQuantity q;
  q.kind = kind;
  q.direction = direction;
  int i = 0;  // inside, where nothing is held
  for (int k = 1; k < model.nodeCount(); ++k) {
    const Vec3 at(-0.01, 0.004, 0.019);
    if ((model.X[k] - at).norm() < (model.X[i] - at).norm()) i = k;
  }
  for (int e = model.node_shape.begin[i]; e < model.node_shape.begin[i + 1]; ++e)
    q.row.emplace_back(model.node_shape.node[e], model.node_shape.N[e]);
  return q;
}

/// dq/dp by two equilibria. @param share  of p, to each side
double centralDifference(EquilibriumSensitivity& body, const EquilibriumQuantity& q, const MaterialNumber& number,
                         const std::optional<Pose>& tool, double share = 1e-3) {
  const AlignedVector<Double4> u = body.u();
  const std::vector<Material> before = body.materials();
  const double middle = before[static_cast<std::size_t>(number.material)].get(number.name)[0];
  double value[2];
  for (const int side : {0, 1}) {
    std::vector<Material> materials = before;
    materials[static_cast<std::size_t>(number.material)].set(number.name, middle * (1 + (side == 0 ? -share : share)));
    body.setMaterials(materials);
    body.settleFrom(u, tool);
    value[side] = body.valueOf(q);
  }
  body.setMaterials(before);
  body.settleFrom(u, tool);
  return (value[1] - value[0]) / (2 * share * middle);
}

const std::vector<MaterialNumber> all_numbers = {{0, "young"}, {0, "poisson"}, {1, "young"}, {1, "poisson"}};

/// That derivatives are central differences, to 1e-6 of the largest relative one of a quantity.
/// @param solutions  that they take. @param share  of a parameter, of the differences
void checkDerivatives(EquilibriumSensitivity& body, const EquilibriumQuantity& q, const std::optional<Pose>& tool,
                      const std::vector<MaterialNumber>& numbers = all_numbers, int solutions = 1,
                      double share = 1e-4) {
  const int before = body.solutionCount();
  const std::vector<double> slopes = body.derivatives(q, numbers);
  CHECK(body.solutionCount() == before + solutions);
  double largest = 0;
  const auto sizeOf = [&](const MaterialNumber& n) {
    return body.materials()[static_cast<std::size_t>(n.material)].get(n.name)[0];
  };
  for (std::size_t k = 0; k < numbers.size(); ++k)
    largest = std::max(largest, std::abs(slopes[k]) * sizeOf(numbers[k]));
  REQUIRE(largest > 0);
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    INFO(static_cast<int>(q.kind) << ": material " << numbers[k].material << " " << numbers[k].name);
    // Differences over h and 2 h, so that their own error, of h^2, is gone (Richardson).
    const double h = centralDifference(body, q, numbers[k], tool, share),
                 h2 = centralDifference(body, q, numbers[k], tool, 2 * share), difference = (4 * h - h2) / 3;
    CAPTURE(slopes[k], difference);
    CHECK(std::abs(slopes[k] - difference) * sizeOf(numbers[k]) < 1e-6 * largest);
  }
}

}  // namespace

TEST_CASE("Forces and displacements under a tool change with materials as central differences say",
          "[simulation][sensitivity][whole]") {
  const Model model = test::blockModel(lumpScene());
  EquilibriumSensitivity body(model, 1);
  const Pose tool = pressed(model);
  body.settle(tool);
  const Vec3 aslant = Vec3(0.3, -0.2, 1).normalized();
  for (const Kind kind : {Kind::ToolForce, Kind::RegionForce, Kind::Displacement})
    checkDerivatives(body, quantity(kind, aslant, model), tool);
  // What the tool presses the region bears.
  for (const Vec3& axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitZ())})
    CHECK(body.valueOf(quantity(Kind::ToolForce, axis, model)) ==
          Approx(body.valueOf(quantity(Kind::RegionForce, axis, model))).margin(1e-9));
  const double force = body.valueOf(quantity(Kind::ToolForce, Vec3::UnitZ(), model));
  CHECK(force > 0.01);
  // Where all is stiffer the contact layer is, too.
  std::vector<Material> stiffer = body.materials();
  for (Material& material : stiffer) material.set("young", 50 * material.get("young")[0]);
  body.setMaterials(stiffer);
  body.settleFrom(AlignedVector<Double4>(body.u()), tool);
  CHECK(body.valueOf(quantity(Kind::ToolForce, Vec3::UnitZ(), model)) == Approx(50 * force).epsilon(1e-6));
}

TEST_CASE("The same for near-incompressible tissue with node patches, under gravity and another law",
          "[simulation][sensitivity][whole]") {
  Scene scene = lumpScene(0.49);
  scene.dynamics.gravity = Vec3(0, 0, -9.81);
  const double mu[1] = {1500}, alpha[1] = {-4};
  scene.materials[1].material = Material::ogden(mu, alpha, 1, 2e-5, 1000);
  const Model model = test::blockModel(scene);
  REQUIRE_FALSE(model.patches.empty());
  EquilibriumSensitivity body(model, 1);
  const Pose tool = pressed(model);
  body.settle(tool);
  checkDerivatives(body, quantity(Kind::ToolForce, Vec3::UnitZ(), model), tool,
                   {{0, "young"}, {0, "poisson"}, {1, "mu"}, {1, "alpha"}, {1, "D1"}});
}

TEST_CASE("Where tissue is at its limit of pressure, derivatives are the differences, too, by a solution for each",
          "[simulation][sensitivity][whole]") {
  const Model model = test::blockModel(lumpScene(0.49));
  EquilibriumSensitivity body(model, 1);
  const Pose tool = pressed(model, 0.01);
  body.settle(tool);
  for (const Kind kind : {Kind::ToolForce, Kind::RegionForce})
    checkDerivatives(body, quantity(kind, Vec3::UnitZ(), model), tool, {{0, "poisson"}, {1, "young"}}, 2, 3e-6);
}

TEST_CASE("Where a motion is imposed, forces are homogeneous in the moduli and displacements do not depend on all",
          "[simulation][sensitivity][whole]") {
  // Euler: sum_p p dq/dp is q of a force and 0 of a displacement, p being all moduli, at fixed Poisson's ratios.
  Scene scene = lumpScene();
  BoundarySpec top = scene.boundaries[0];
  top.region.point = Vec3(0, 0, 0.03);
  top.translation = Vec3(0.001, 0, -0.002);
  top.duration = 1;
  scene.boundaries.push_back(top);
  const Model model = test::blockModel(scene);
  EquilibriumSensitivity body(model, 1);
  body.settle({}, 1);
  EquilibriumQuantity q = quantity(Kind::RegionForce, Vec3(1, 0, -1).normalized(), model);
  q.region = 1;
  const auto weighted = [&] {
    const std::vector<double> slopes = body.derivatives(q, {{0, "young"}, {1, "young"}});
    CHECK(slopes[0] * slopes[1] != 0);
    return 3000 * slopes[0] + 9000 * slopes[1];
  };
  const double force = body.valueOf(q);
  REQUIRE(force > 0.1);
  CHECK(weighted() == Approx(force).epsilon(1e-8));
  checkDerivatives(body, q, {});
  q.kind = Kind::Displacement;
  CHECK(std::abs(weighted()) < 1e-8 * std::abs(3000 * body.derivatives(q, {{0, "young"}})[0]));
}

TEST_CASE("The derivative to a membership class is that to all points that have some of it",
          "[simulation][sensitivity][whole]") {
  Scene scene = lumpScene();
  auto membership = std::make_shared<Membership>();
  membership->share = Image(ImageGrid({20, 20, 10}, 4e-3 * Mat3::Identity(), Vec3(-0.038, -0.038, -0.001)));
  for (int k = 0; k < 10; ++k)
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 20; ++i) membership->share(i, j, k) = static_cast<float>(i) / 19.0F;
  scene.materials[1].membership = membership;
  const Model model = test::blockModel(scene);
  REQUIRE(model.materials.size() > 100);
  EquilibriumSensitivity body(model, 1);
  const Pose tool = pressed(model);
  body.settle(tool);
  checkDerivatives(body, quantity(Kind::ToolForce, Vec3::UnitZ(), model), tool, {{0, "young"}, {1, "young"}});
}

TEST_CASE("A polished equilibrium is that of the static solver, and the answer the same for any number of threads",
          "[simulation][sensitivity][whole]") {
  const Model model = test::blockModel(lumpScene());
  const Pose tool = pressed(model, 0.0015);  // no face of the skin is stretched by half
  StaticSolver solver(model, 1, 1e-4);
  const Equilibrium rough = solver.advanceTo(0, tool);
  REQUIRE(rough.converged);
  EquilibriumSensitivity one(model, 1), two(model, 2);
  one.settle(tool), two.settle(tool);
  const EquilibriumQuantity q = quantity(Kind::ToolForce, Vec3::UnitZ(), model);
  CHECK(one.valueOf(q) == Approx(rough.tool_force.z()).epsilon(1e-4));  // its contact is in float
  CHECK(one.valueOf(q) == two.valueOf(q));
  CHECK(one.derivatives(q, all_numbers) == two.derivatives(q, all_numbers));
}

TEST_CASE("Sensitivities that would be none are refused in a sentence", "[simulation][sensitivity]") {
  Scene rough = lumpScene();
  rough.tools[0].friction = 0.3;
  const Model rubbing = test::blockModel(rough), model = test::blockModel(lumpScene());
  CHECK_THROWS_WITH(EquilibriumSensitivity(rubbing, 1), Catch::Contains("without friction"));
  EquilibriumSensitivity body(model, 1);
  body.settle({});
  const EquilibriumQuantity q = quantity(Kind::Displacement, Vec3::UnitZ(), model);
  CHECK_THROWS_WITH(body.derivatives(q, {{0, "yuong"}}), Catch::Contains("yuong"));
  CHECK_THROWS_WITH(body.derivatives(q, {{2, "young"}}), Catch::Contains("no material 2"));
  CHECK_THROWS_WITH(body.derivatives(q, {{0, "young", 1}}), Catch::Contains("no entry 1"));
  CHECK_THROWS_WITH(body.derivatives(q, {{0, "density"}}), Catch::Contains("density"));
  int calls = 0;
  EquilibriumSensitivity stopped(model, 1, [&] { return ++calls < 5; });
  CHECK_THROWS_WITH(stopped.settle(pressed(model)), Catch::Contains("interrupted"));
}

TEST_CASE("An equilibrium is one of a tool that came from outside, or there is none",
          "[simulation][sensitivity][whole]") {
  const Model model = test::blockModel(lumpScene());
  EquilibriumSensitivity body(model, 1);
  const auto upward = quantity(Kind::ToolForce, Vec3::UnitZ(), model);
  body.settle(pressed(model));
  const double shallow = body.valueOf(upward);
  CHECK(body.expectedError() > 0.001);
  // From 2 radii on no vertex of the skin at rest is in the ball.
  for (const double radii : {0.5, 2.1, 2.5}) {
    CAPTURE(radii);
    try {
      body.settle(pressed(model, radii * model.scene.tools[0].shape.radius));
      CHECK(body.valueOf(upward) > shallow);
    } catch (const std::runtime_error& none) {
      CHECK(radii > 1);
      CHECK_THAT(none.what(), Catch::Contains("no equilibrium"));
    }
  }
}

TEST_CASE("A tool behind what holds the body has no equilibrium there", "[simulation][sensitivity]") {
  Scene scene = lumpScene();
  scene.discretization.spacing = 0.006;
  scene.boundaries[0].region.point.z() = 0.012;  // up to 6 mm below the skin
  scene.boundaries[0].region.distance = 0.0121;
  const Model model = test::blockModel(scene);
  EquilibriumSensitivity body(model, 1);
  CHECK_NOTHROW(body.settle(pressed(model)));
  CHECK_THROWS_WITH(body.settle(pressed(model, 0.006)), Catch::Contains("can't come there"));
  // Nor to beyond the body, where it would touch nothing.
  CHECK_THROWS_WITH(body.settle(pressed(model, 0.1)), Catch::Contains("in its way from outside"));
}

TEST_CASE("What points of stretched faces would bear is in the error to expect", "[simulation][sensitivity][whole]") {
  Scene scene = lumpScene();
  scene.tools[0].shape.radius = 0.005;
  const Model model = test::blockModel(scene);
  EquilibriumSensitivity body(model, 1);
  const Pose tool = pressed(model, 0.005);
  body.settle(tool);
  StaticSolver solver(model, 1, 1e-6);
  Vec3 force;
  for (int k = 0; k <= 4; ++k) force = solver.advanceTo(0, pressed(model, 0.005 * k / 4)).tool_force;
  const double lacks = 1 - body.valueOf(quantity(Kind::ToolForce, Vec3::UnitZ(), model)) / force.z();
  CHECK((lacks > 0.01 && lacks < 0.03));
  CHECK(body.lacking() == Approx(lacks).epsilon(0.2));
  CHECK(body.expectedError() > lacks);
  body.settle(pressed(model, 0.0005));
  CHECK(body.lacking() < 0.002);
}
