#include <catch2/catch.hpp>

#include "discretization/surface/solids.h"
#include "io/load_model.h"
#include "setup/body_points.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

/// Sphere on a bonded elastic layer of any Poisson's ratio: Dimitriadis et al., Biophys. J. 82 (2002), eq. 12.
double dimitriadis(double E, double nu, double R, double h, double d) {
  const double a = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1 - nu);
  const double b = (0.6387 - 1.0277 * nu + 1.5164 * nu * nu) / (1 - nu);
  const double x = std::sqrt(R * d) / h, pi = M_PI;
  return 4 * E / (3 * (1 - nu * nu)) * std::sqrt(R) * std::pow(d, 1.5) *
         (1 - 2 * a / pi * x + 4 * a * a / (pi * pi) * x * x -
          8 / std::pow(pi, 3) * (a * a * a + 4 * pi * pi / 15 * b) * x * x * x +
          16 * a / std::pow(pi, 4) * (a * a * a + 3 * pi * pi / 5 * b) * std::pow(x, 4));
}

/// The scene layer_sphere with another refinement under the sphere.
Scene layerScene(double spacing_under_sphere) {
  Scene scene;
  scene.organs[0].solid = OrganSpec::Solid::Cylinder;
  scene.organs[0].radius = 0.04;
  scene.organs[0].height = 0.015;
  scene.discretization.spacing = 0.006;
  scene.discretization.quadrature.points_per_cell = 1;
  scene.discretization.refine.push_back({Vec3(0, 0, 0.015), 0.005, spacing_under_sphere, 0.01, {}});
  scene.discretization.formulation.consistent_gradients = true;  // as in the scene; without, 2 - 5 % below, not 1 - 2 %
  scene.materials.emplace_back();
  scene.materials[0].material.set("young", 3000);
  scene.materials[0].material.set("poisson", 0.49);
  scene.boundaries = {test::planeBoundary(Vec3::Zero())};
  scene.dynamics.step_safety = 0.8;
  scene.dynamics.damping = 150;  // settles within 0.1 s; the static force does not depend on it
  scene.tools[0].shape.radius = 0.01;
  scene.tools[0].position = Vec3(0, 0, 0.0152);
  return scene;
}

/// Forces at rest at increasing depths.
std::vector<double> pressLayer(double spacing_under_sphere, const std::vector<double>& depths) {
  const Model model = loadModel(layerScene(spacing_under_sphere));
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  std::vector<double> forces;
  double from = 0;
  for (const double depth : depths) {
    const double to = model.tools.first().first_contact_travel + depth;
    StepReport report;
    for (int k = 1; k <= 80; ++k) {
      command.tools[0].pose = model.tools.first().start.pose;
      command.tools[0].pose.position.z() -= from + (to - from) * std::min(1.0, k / 30.0);
      report = tick(model, state, command, workspace);
      REQUIRE(report.flags == 0);
    }
    from = to;
    // At rest: the base carries what the sphere presses.
    CHECK(report.base_reaction.z() == Approx(report.tool_force.z()).epsilon(0.01));
    CHECK(report.max_penetration < 0.02 * model.scene.tools[0].shape.radius);
    forces.push_back(report.tool_force.z());
  }
  return forces;
}

}  // namespace

TEST_CASE("A sphere on a bonded layer meets the closed form, and refinement brings it closer",
          "[validation][contact]") {
  // The formula itself is 1 - 2.5 % above a converged finite-strain solution in this range.
  const std::vector<double> depths{0.3e-3, 0.6e-3, 1.0e-3};
  const auto worst = [&](double spacing) {
    const auto forces = pressLayer(spacing, depths);
    double error = 0;
    for (std::size_t k = 0; k < depths.size(); ++k) {
      const double expected = dimitriadis(3000, 0.49, 0.01, 0.015, depths[k]);
      UNSCOPED_INFO("spacing " << spacing * 1e3 << " mm, depth " << depths[k] * 1e3 << " mm: " << forces[k]
                               << " N, closed form " << expected << " N, " << (forces[k] / expected - 1) * 100 << " %");
      error = std::max(error, std::abs(forces[k] / expected - 1));
    }
    return error;
  };
  const double coarse = worst(0.004), fine = worst(0.0015);
  CHECK(fine < 0.05);
  CHECK(fine < 0.7 * coarse);
}

TEST_CASE("Unconstrained compression of the cube: NRMSE of u_z beside the paper's Table 1", "[validation]") {
  // Section 3.1: edge 100 mm, top down by 20 mm, E 3000 Pa, nu 0.49; u_z = -0.2 z exactly. The paper has
  // 3.08e-3 with 260 nodes and one point per cell, 6.92e-4 with four.
  const auto nrmse = [](int points_per_cell, bool consistent) {
    Scene scene;
    scene.organs[0].solid = OrganSpec::Solid::Box;
    scene.organs[0].size = Vec3(0.1, 0.1, 0.1);
    scene.discretization.spacing = 0.0195;
    scene.discretization.mmls_weight = 0.1;
    scene.discretization.quadrature.points_per_cell = points_per_cell;
    scene.discretization.formulation.consistent_gradients = consistent;
    scene.materials.emplace_back();
    scene.dynamics.damping = 40;
    scene.dynamics.rate_hz = 200;
    scene.tools[0].position = Vec3(0, 0, 0.5);
    scene.boundaries = {test::roller(Vec3::Zero(), 2), test::roller(Vec3(-0.05, 0, 0), 0),
                        test::roller(Vec3(0, -0.05, 0), 1), test::roller(Vec3(0, 0, 0.1), 2)};
    scene.boundaries.back().translation = Vec3(0, 0, -0.02);
    scene.boundaries.back().duration = 0.5;
    const Model model = buildModel(scene, boxSurface(scene.organs[0].size, 0.02));
    State state = initialState(model);
    Workspace workspace(model, 1);
    Command command;
    command.tools[0].pose = model.tools.first().start.pose;
    for (int k = 0; k < 260; ++k) REQUIRE(tick(model, state, command, workspace).flags == 0);

    const ShapeTable at_nodes = shapeAt(model, model.X);
    double sum = 0, boundary = 0;
    for (int i = 0; i < model.nodeCount(); ++i) {
      double uz = 0;
      for (int e = at_nodes.begin[i]; e < at_nodes.begin[i + 1]; ++e) uz += at_nodes.N[e] * state.u[at_nodes.node[e]].z;
      const double error = std::abs(uz + 0.2 * model.X[i].z());
      sum += error * error;
      if (model.imposed[i] & 4) boundary = std::max(boundary, error);
    }
    const double result = std::sqrt(sum / model.nodeCount()) / 0.02;
    UNSCOPED_INFO((consistent ? "consistent gradients, " : "plain MMLS, ")
                  << points_per_cell << " points per cell: " << model.nodeCount() << " nodes, " << model.pointCount()
                  << " points, NRMSE " << result << ", boundary error " << boundary << " m");
    CHECK(boundary < 1e-7);  // float32 of a 0.1 m body over 2000 steps
    return result;
  };
  // Without the correction 3.7e-3 - 6e-3 with one point per cell and 1.0e-3 - 2.5e-3 with four, by cloud. It is
  // a patch test: with gradients that satisfy the divergence theorem to 1e-4, only 1e-4 of that and float32 are left.
  CHECK(nrmse(1, false) < 6e-3);
  CHECK(nrmse(4, false) < 3e-3);
  CHECK(nrmse(1, true) < 1e-5);
  CHECK(nrmse(4, true) < 1e-5);
}
