#include "setup/sharp_interfaces.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "batch/batch_body.h"
#include "batch/static_solver.h"
#include "io/load_model.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

constexpr double stack_height = 0.04, soft = 300, stiff = 3000, nu = 0.45, shear = 0.3;  // m, Pa

/// The shear stress of the two layers, Pa, which is the same in both, and how far a plane at z goes, m: of neo-Hookean
/// tissue in simple shear the stress is the shear modulus times the shear.
double shearStress() { return shear * 2 / (2 * (1 + nu) * (1 / soft + 1 / stiff)); }
double slide(double z) {
  const double low = std::min(z, stack_height / 2);
  return shearStress() * 2 * (1 + nu) * (low / soft + (z - low) / stiff);
}

/// A soft layer under a stiff one between two plates, the upper of which slides by 30 % of the height.
Scene layers(double spacings, bool sharp) {
  Scene scene;
  scene.organs[0].solid = OrganSpec::Solid::Box;
  scene.organs[0].size = Vec3(stack_height, 0.6 * stack_height, stack_height);
  scene.discretization.spacing = stack_height / spacings;
  scene.discretization.formulation.sharp_interfaces = sharp;
  scene.materials.resize(2);
  for (MaterialSpec& m : scene.materials) m.material.set("poisson", nu);
  scene.materials[0].material.set("young", stiff);
  scene.materials[1].material.set("young", soft);
  scene.materials[1].everywhere = false;
  scene.materials[1].region.point = Vec3(0, 0, stack_height / 2);
  scene.tools[0].position = Vec3(0, 0, 1);
  const auto plane = [&](const Vec3& point, int normal) {
    const bool all = normal == 2;
    scene.boundaries.push_back(test::planeBoundary(point, Vec3::Unit(normal), {all, all || normal == 1, all}));
  };
  plane(Vec3::Zero(), 2);
  plane(Vec3(0, 0, stack_height), 2);
  for (const double side : {-0.5, 0.5}) plane(side * scene.organs[0].size.cwiseProduct(Vec3::UnitY()), 1);
  scene.boundaries[1].translation = Vec3(shear * stack_height, 0, 0);
  return scene;
}

/// With each node of the faces to which the shear is normal where the closed form has it: the exact solution is then
/// the closed form's everywhere.
Model shearedLayers(double spacings, bool sharp) {
  Scene scene = layers(spacings, sharp);
  scene.boundaries[1].duration = 1;
  scene.boundaries[1].curve.kind = LoadCurve::Kind::Linear;
  const Model model = loadModel(scene);
  for (const Vec3& X : model.X) {
    if (std::abs(std::abs(X.x()) - scene.organs[0].size.x() / 2) > 1e-9 || X.z() < 1e-9 || X.z() > stack_height - 1e-9)
      continue;
    BoundarySpec& b = scene.boundaries.emplace_back(scene.boundaries[1]);
    b.region.kind = Region::Kind::Sphere;
    b.region.point = X;
    b.region.radius = 1e-8;
    b.component[1] = false;
    b.translation = Vec3(slide(X.z()), 0, 0);
  }
  return loadModel(scene);
}

double shearForceError(const Model& model) {
  StaticSolver solver(model, 1, 1e-4);
  REQUIRE(solver.advanceTo(1).converged);
  const double area = model.scene.organs[0].size.x() * model.scene.organs[0].size.y();
  return solver.body().reactions()[1].force.x() / (area * shearStress()) - 1;
}

/// Two layers that are pressed between five walls, each of its own material: the exact solution is a uniform strain of
/// each layer, P_zz = mu J^(-2/3) (l - (2 + l^2) / (3 l)) + K (J - 1) with J = l, the same in both.
struct ConfinedLayers {
  double young[2], poisson[2], pressed;  // Pa, 1, share of the height
  double field_error = 1e-3;             // of the way of the plate; more where the cells hold the volume at its bonds
  double spacings = 6, cells_per_point = 1;

  double stress(int layer, double l) const {
    const double mu = young[layer] / (2 * (1 + poisson[layer])), K = young[layer] / (3 * (1 - 2 * poisson[layer]));
    return mu * std::pow(l, -2.0 / 3) * (l - (2 + l * l) / (3 * l)) + K * (l - 1);
  }
  /// Stretch of the lower layer, so that both together are as high as they may be.
  double lower() const {
    double a = 1 - 2 * pressed, b = 1;
    for (int k = 0; k < 100; ++k) {
      const double l = (a + b) / 2;
      (stress(1, l) < stress(0, 2 * (1 - pressed) - l) ? a : b) = l;
    }
    return (a + b) / 2;
  }
  Scene scene() const {
    Scene scene = layers(spacings, true);
    scene.discretization.quadrature.cells_per_point = cells_per_point;
    for (int m = 0; m < 2; ++m) {
      scene.materials[m].material.set("young", young[m]);
      scene.materials[m].material.set("poisson", poisson[m]);
    }
    BoundarySpec wall = scene.boundaries.back();
    wall.component[0] = true;
    wall.component[1] = false;
    wall.region.normal = Vec3::UnitX();
    for (const double side : {-0.5, 0.5}) {
      wall.region.point = side * scene.organs[0].size.cwiseProduct(Vec3::UnitX());
      scene.boundaries.push_back(wall);
    }
    scene.boundaries[1].translation = Vec3(0, 0, -pressed * stack_height);
    scene.boundaries[1].duration = 1;
    return scene;
  }
};

}  // namespace

TEST_CASE("Two confined layers meet the closed form, whatever their moduli and the pressure",
          "[sharp_interfaces][whole]") {
  const ConfinedLayers cases[] = {{{4000, 500}, {0.4, 0.3}, 0.15},
                                  {{4000, 500}, {0.4, 0.3}, 0.15, 1e-3, 6, 1.5},
                                  {{3000, 300}, {0.3, 0.49}, 0.2, 0.04},
                                  {{1000, 3000}, {0.49, 0.49}, 0.15, 0.06},
                                  {{500, 4000}, {0.2, 0.25}, 0.2}};
  for (const ConfinedLayers& c : cases) {
    const Model model = loadModel(c.scene());
    StaticSolver solver(model, 1, 1e-6);
    REQUIRE(solver.advanceTo(1).converged);
    const double area = model.scene.organs[0].size.x() * model.scene.organs[0].size.y(), l = c.lower(),
                 exact = area * c.stress(1, l);
    const double force = solver.body().reactions()[1].force.z();
    INFO("E " << c.young[0] << " over " << c.young[1] << " Pa, nu " << c.poisson[0] << " over " << c.poisson[1]
              << ": force " << force << " N, exact " << exact << " N, error " << 100 * (force / exact - 1) << " %");
    CHECK(std::abs(force / exact - 1) < 1e-3);
    double worst = 0;
    const auto u = fieldAt(model.node_shape, solver.body().u);
    for (int i = 0; i < model.nodeCount(); ++i) {
      const double z = model.X[i].z(), half = stack_height / 2;
      const double moved = std::min(z, half) * (l - 1) + std::max(z - half, 0.0) * (1 - 2 * c.pressed - l);
      worst = std::max(worst, (u[i] - Vec3(0, 0, moved)).norm());
    }
    CHECK(worst < c.field_error * c.pressed * stack_height);
  }
}

TEST_CASE("Two layers sheared by 30 % meet the closed form where supports end at their border",
          "[sharp_interfaces][whole]") {
  const double smeared = shearForceError(shearedLayers(8, false)), sharp = shearForceError(shearedLayers(8, true));
  INFO("smeared " << smeared << ", sharp " << sharp);
  CHECK(smeared > 0.01);
  CHECK(std::abs(sharp) < 0.006);
}

TEST_CASE("Nodes are put on borders, and no support reaches over one", "[sharp_interfaces]") {
  const Model smeared = loadModel(layers(5, false)), sharp = loadModel(layers(5, true));
  const auto onBorder = [](const Model& model) {
    return std::count_if(model.X.begin(), model.X.end(),
                         [](const Vec3& X) { return std::abs(X.z() - stack_height / 2) < 1e-6; });
  };
  CHECK(sharp.nodeCount() >= smeared.nodeCount());  // holes in the border are closed
  CHECK(sharp.nodeCount() < 1.05 * smeared.nodeCount());
  CHECK(onBorder(sharp) > 10);
  CHECK(onBorder(sharp) > 2 * onBorder(smeared));
  double closest = 1;
  for (int i = 0; i < sharp.nodeCount(); ++i)
    for (int j = 0; j < i; ++j) closest = std::min(closest, (sharp.X[i] - sharp.X[j]).norm());
  CHECK(closest > 0.44 * sharp.scene.discretization.spacing);

  // Of which materials the nodes' cells are; a point has only nodes of its own in its support.
  std::vector<GroupBits> materials(sharp.X.size(), 0);
  for (int q = 0; q < sharp.pointCount(); ++q)
    for (const int i : sharp.cells[sharp.point_cell[q]]) materials[i] |= GroupBits{1} << sharp.point_material[q];
  for (int q = 0; q < sharp.pointCount(); ++q)
    for (int e = sharp.point_shape.begin[q]; e < sharp.point_shape.begin[q + 1]; ++e)
      REQUIRE((materials[sharp.point_shape.node[e]] >> sharp.point_material[q] & 1) == 1);
}

TEST_CASE("No cell reaches over a border of layers that are hardly thicker than a spacing", "[sharp_interfaces]") {
  Scene scene = layers(4.3, true);
  const double border[] = {0.24, 0.5, 0.78};  // of the height
  for (int k = 2; k >= 0; --k) {
    MaterialSpec& below = k == 2 ? scene.materials[1] : scene.materials.emplace_back(scene.materials[1]);
    below.region.point = Vec3(0, 0, border[k] * stack_height);
  }
  for (const unsigned seed : {1U, 2U, 3U}) {
    scene.discretization.seed = seed;
    const Model model = loadModel(scene);
    CAPTURE(seed);
    double worst = 0;  // m, of a node beyond the border of a cell that it belongs to
    for (int q = 0; q < model.pointCount(); ++q) {
      const double z = model.point_X[q].z() / stack_height;
      double low = 0, high = 1;
      for (const double b : border) (b < z ? low : high) = b < z ? std::max(low, b) : std::min(high, b);
      for (const int i : model.cells[model.point_cell[q]]) {
        const double at = model.X[i].z() / stack_height;
        worst = std::max({worst, low - at, at - high});
      }
    }
    CHECK(worst < 1e-4);
  }
}

TEST_CASE("The sides of a sharp border balance under one traction, whatever else their stresses are",
          "[sharp_interfaces]") {
  // sum_q V_q gradN_i over the points of both sides vanishes at inner nodes; over those of one side at its own ones.
  const Model model = loadModel(layers(8, true));
  std::vector<std::array<Vec3, 2>> sum(model.X.size(), {Vec3::Zero(), Vec3::Zero()});
  for (int q = 0; q < model.pointCount(); ++q)
    for (int e = model.point_shape.begin[q]; e < model.point_shape.begin[q + 1]; ++e)
      sum[model.point_shape.node[e]][model.point_material[q]] += model.point_volume[q] * model.point_shape.gradN[e];
  const double h = model.scene.discretization.spacing;
  int inner = 0;
  for (int i = 0; i < model.nodeCount(); ++i) {
    const Vec3 depth =
        (model.scene.organs[0].size / 2 - (model.X[i] - Vec3(0, 0, stack_height / 2)).cwiseAbs()) / (2 * h);
    if (depth.minCoeff() < 1) continue;  // N of the outer faces reaches here
    ++inner;
    CHECK((sum[i][0] + sum[i][1]).norm() < 1e-4 * h * h);
  }
  CHECK(inner > 0);
}

TEST_CASE("One material has no border: sharp interfaces change nothing", "[sharp_interfaces]") {
  Scene scene = layers(4, true);
  scene.materials.resize(1);
  const Model sharp = loadModel(scene);
  scene.discretization.formulation.sharp_interfaces = false;
  const Model plain = loadModel(scene);
  CHECK(sharp.point_shape.N == plain.point_shape.N);
  CHECK(sharp.mass == plain.mass);
}

TEST_CASE("A core and a lump have the volume that they should, however few nodes are around them",
          "[sharp_interfaces][whole]") {
  // Flat faces between nodes on the border would leave an octagon, a tenth too small.
  Scene scene;
  scene.organs[0].solid = OrganSpec::Solid::Cylinder;
  scene.organs[0].radius = 0.014;
  scene.organs[0].height = 0.03;
  scene.discretization.spacing = 0.0048;
  scene.materials.resize(2);
  scene.materials[1].material.set("young", 20000);
  scene.materials[1].everywhere = false;
  scene.tools[0].position = Vec3(0, 0, 1);
  BoundarySpec base;
  base.region.kind = Region::Kind::NearPlane;
  base.region.distance = 1e-6;
  scene.boundaries.push_back(base);
  Region& inside = scene.materials[1].region;
  for (const bool core : {true, false}) {
    inside.kind = core ? Region::Kind::Cylinder : Region::Kind::Sphere;
    inside.point = core ? Vec3(0, 0, -0.01) : Vec3(0, 0, 0.015);
    inside.height = 0.05;
    inside.radius = core ? 0.0065 : 0.008;
    const double exact =
        core ? M_PI * std::pow(inside.radius, 2) * scene.organs[0].height : 4.0 / 3 * M_PI * std::pow(inside.radius, 3);
    for (const unsigned seed : {1U, 2U, 3U}) {
      scene.discretization.seed = seed;
      const Model model = loadModel(scene);
      double volume = 0;
      for (int q = 0; q < model.pointCount(); ++q)
        if (model.point_material[q] == 1) volume += model.point_volume[q];
      INFO((core ? "core" : "lump") << ", seed " << seed << ": " << 100 * (volume / exact - 1) << " % off");
      CHECK(std::abs(volume / exact - 1) < 0.02);
    }
  }
}

namespace {

/// N, of a ball that is pressed 3 mm into a slab that is held up to a height, m.
double forceOnSlab(double height, double held, double& pierced) {
  Scene scene = test::blockScene(0.004);
  scene.organs[0].size = Vec3(0.06, 0.06, height);
  scene.materials[0].material.set("poisson", 0.45);
  scene.boundaries[0].region.kind = Region::Kind::HalfSpace;
  scene.boundaries[0].region.point = Vec3(0, 0, held);
  scene.tools[0].position.z() = height + 0.001;
  const Model model = test::blockModel(scene);
  int across = 0, edges = 0;
  for (const auto& cell : model.cells)
    for (const int i : cell)
      for (const int j : cell) {
        const double below = held - model.X[i].z(), above = model.X[j].z() - held;
        if (below < -1e-8 || above < -1e-8 || below + above < 1e-8) continue;
        ++edges;
        across += std::min(below, above) > 0.1 * (below + above) ? 1 : 0;
      }
  pierced = edges > 0 ? static_cast<double>(across) / edges : 0;
  Workspace workspace(model, 2);
  State state = initialState(model);
  const auto travelAt = [](int k) { return 0.004 * std::min(1.0, k / 150.0); };
  return test::moveAlong(model, state, workspace, 300, travelAt).tool_force.norm();
}

}  // namespace

TEST_CASE("What is held inside of an organ ends where its region does, not at the nodes that happen to lie in it",
          "[sharp_interfaces][whole]") {
  double pierced = 0, none = 0;
  const double held = forceOnSlab(0.012, 0.0025, pierced), thinner = forceOnSlab(0.0095, 0, none);
  CAPTURE(held, thinner, pierced);
  CHECK(pierced < 0.05);
  CHECK(held == Approx(thinner).epsilon(0.04));  // 0.82 of it, when its nodes lay anywhere
}
