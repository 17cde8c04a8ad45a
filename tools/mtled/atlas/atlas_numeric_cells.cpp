// Cells of tools/mtled/atlas/atlas_cells.h: time step, single precision, quadrature.
#include <algorithm>
#include <cmath>

#include "base/number_text.h"
#include "batch/static_solver.h"
#include "io/load_model.h"
#include "mtled/atlas/atlas_block.h"
#include "mtled/atlas/atlas_cells.h"
#include "mtled/report/case_result.h"
#include "mtled/verify/cases/cases.h"

namespace palpate::tools {
namespace {

using When = AtlasCell::When;

/// Noise of a nanometre a step in all nodes, which the fastest modes can grow from. The same at each run.
void nudge(State& state) {
  unsigned seed = 1;
  const auto next = [&] {
    seed = seed * 1664525u + 1013904223u;
    return 1e-9F * (static_cast<float>(seed >> 8) / 8388608.0F - 1);
  };
  for (auto& a : state.du) a = {next(), next(), next(), 0};
}

/// A step of a share of the limit, which the scene asks for, or which is set behind the set-up's back.
AtlasMeasure timeStep(double share, bool forced) {
  constexpr double young = 3000, poisson = 0.45, stretch = 0.9;
  Scene scene = blockScene(BlockFaces::Free, young, poisson, stretch);
  scene.tools[0].max_speed = 0.1;  // the contact follows it at any of these steps
  const double limit = loadModel(scene).dt_critical;
  if (!forced) {
    scene.dynamics.time_step = share * limit;
    scene.dynamics.rate_hz =
        1 / (scene.dynamics.time_step * std::max(1.0, std::floor(2e-3 / scene.dynamics.time_step)));
  }
  Model model = loadModel(scene);
  if (forced) {
    model.dt = share * limit;
    model.scene.dynamics.rate_hz = 1 / (model.dt * model.substeps_per_tick);
  }
  AtlasDrive steps = blockDrive();
  steps.disturb = nudge;
  steps.seconds = 3;
  const AtlasRun run = drive(model, steps);
  return compare(
      run, "force / closed form", run.reaction[1].force.z(),
      blockForce(BlockFaces::Free, young, poisson, stretch, scene.organs[0].size.x() * scene.organs[0].size.y()), 0.02);
}

Scene tinyBlock() {
  Scene scene = blockScene(BlockFaces::Bonded, 3000, 0.49, 0.85);
  scene.discretization.spacing = 0.016;  // 27 nodes: 10^7 steps within a minute or two
  scene.dynamics.rate_hz = 100;          // many steps a tick: the steps are what counts here
  return scene;
}

AtlasDrive forSteps(const Model& model, double steps) {
  AtlasDrive drive;
  drive.still_from = 2.5;
  drive.seconds = std::max(4.0, steps * model.dt);
  return drive;
}

AtlasMeasure heldForce(double steps) {
  const Scene scene = tinyBlock();
  const Model model = loadModel(scene);
  const AtlasRun run = drive(model, forSteps(model, steps));
  StaticSolver solver(model, 1, 1e-6);
  const bool solved = solver.advanceTo(scene.boundaries[1].duration).converged;
  return compare(run, "force / double", run.reaction[1].force.z(),
                 solved ? solver.body().reactions()[1].force.z() : NAN, 1e-3);
}

AtlasMeasure restingDrift(double steps) {
  Scene scene = tinyBlock();
  LoadCurve& there_and_back = scene.boundaries[1].curve;
  there_and_back.kind = LoadCurve::Kind::Table;
  there_and_back.time = {0, 0.5, 1, 1.5};
  there_and_back.fraction = {0, 1, 1, 0};
  scene.boundaries[1].duration = 1.5;
  const Model model = loadModel(scene);
  const AtlasRun run = drive(model, forSteps(model, steps));
  double most = 0;
  for (const Vec3& u : run.u) most = std::max(most, u.norm());
  const double size = scene.organs[0].size.z();
  return compare(run, "what stays / size", size + most, size, 1e-5);
}

AtlasMeasure poorestMode(const Variant& variant, int points_per_cell) {
  const auto modelOf = [](const Variant& of, int points) {
    Scene scene = caseScene(3000, 0.49);
    scene.name = "atlas modes";
    scene.organs[0].solid = OrganSpec::Solid::Box;
    scene.organs[0].size = Vec3(0.1, 0.1, 0.1);
    scene.discretization.spacing = 0.026;
    scene.tools[0].shape.radius = 0.05;
    scene.discretization.quadrature.points_per_cell = points;
    scene.boundaries = {planeBoundary("base", Vec3::Zero(), Vec3::UnitZ())};  // a model needs one; it is not used
    apply(of, scene);
    return loadModel(scene);
  };
  const Model model = modelOf(variant, points_per_cell);
  AtlasRun run;
  run.measure.nodes = model.nodeCount();
  run.measure.points = model.pointCount();
  const double poorest = energyShares(model).front(), of_four = energyShares(modelOf(variants[0], 4)).front();
  // More than with four points is no fault.
  return compare(run, "poorest mode's energy / 4 points", std::min(poorest, of_four), of_four, 0.5);
}

}  // namespace

void addNumericCells(std::vector<AtlasAxis>& axes, std::vector<AtlasCell>& cells) {
  axes.push_back({"dt", "Time step / stable step",
                  "Block pressed by 10 % between plates and held, all nodes jolted by 1 nm at the start; force beside "
                  "the closed form."});
  for (const double share : {0.5, 0.7, 0.8, 0.9, 0.95, 1.0, 1.02, 1.05})
    cells.push_back({"dt", format("%.2f", share),
                     share == 0.5 || share == 0.9 || share == 1.05 ? When::Always : When::Full,
                     [=] { return timeStep(share, false); }});
  axes.push_back({"dt-forced", "The same, not refused",
                  "Steps that the set-up refuses, set behind its back: the doubt has to come before the loss."});
  for (const double share : {1.01, 1.02, 1.05, 1.2, 1.5})
    cells.push_back({"dt-forced", format("%.2f", share), share == 1.05 ? When::Always : When::Full,
                     [=] { return timeStep(share, true); }});
  axes.push_back({"float32", "Single precision, steps",
                  "Small block pressed by 15 % and held (force beside the equilibrium in double), or released (what "
                  "stays of the displacement), after so many steps."});
  for (const auto& [name, steps, when] : {std::tuple("1e5", 1e5, When::Always), std::tuple("1e7", 1e7, When::Full)}) {
    cells.push_back({"float32", std::string("held ") + name, when, [steps = steps] { return heldForce(steps); }});
    cells.push_back({"float32", std::string("rest ") + name, when, [steps = steps] { return restingDrift(steps); }});
  }
  axes.push_back({"modes", "Points a cell, scheme",
                  "Free cube at rest: energy that the poorest deformation has in the scheme, beside the same with 4 "
                  "points a cell (mtled verify modes)."});
  const char* const names[] = {"1 paper", "1 patches", "1 consistent", "1 both"};
  for (int v = 0; v < 4; ++v)
    cells.push_back(
        {"modes", names[v], v == 3 ? When::Always : When::Full, [v] { return poorestMode(variants[v], 1); }});
}

}  // namespace palpate::tools
