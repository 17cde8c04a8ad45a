// Cells of tools/mtled/atlas/atlas_cells.h: what a hand may do with the tool.
#include <algorithm>
#include <cmath>
#include <memory>

#include "base/number_text.h"
#include "io/load_model.h"
#include "mtled/atlas/atlas_cells.h"
#include "mtled/atlas/atlas_run.h"
#include "mtled/report/case_result.h"
#include "mtled/verify/verification_case.h"

namespace palpate::tools {
namespace {

using When = AtlasCell::When;

constexpr double width = 0.05, height = 0.02, tool_radius = 0.008, above = 0.002;  // m

/// A slab bonded to its base under a sphere.
Scene slab() {
  Scene scene = caseScene(3000, 0.48);
  scene.name = "atlas slab";
  scene.organs[0].solid = OrganSpec::Solid::Box;
  scene.organs[0].size = Vec3(width, width, height);
  scene.discretization.spacing = 0.006;
  scene.dynamics.damping = 60;
  scene.dynamics.threads = 1;
  scene.boundaries = {planeBoundary("base", Vec3::Zero(), Vec3::UnitZ())};
  scene.tools[0].shape.radius = tool_radius;
  scene.tools[0].position = Vec3(0, 0, height + above);
  return scene;
}

Command tipAt(const Vec3& tip) {
  Command command;
  command.tools[0].pose.position = tip;
  return command;
}

/// Force on the tool along z with its tip there, N: the equilibrium in double. NaN where there is none.
double restingForce(const Model& model, const Vec3& tip) {
  const Equilibrium at = ledTo(model, tip, 1e-4);
  return at.converged ? at.tool_force.z() : NAN;
}

double largest(const std::vector<Vec3>& u) {
  double most = 0;
  for (const Vec3& a : u) most = std::max(most, a.norm());
  return most;
}

/// What stays of the displacements when the tool is gone, as a share of the height.
AtlasMeasure residual(const AtlasRun& run) {
  return compare(run, "what stays / height", height + largest(run.u), height, 1e-3);
}

/// Down at `speed` to `depth`, abruptly held.
AtlasMeasure poke(double speed) {
  constexpr double depth = 0.006;
  Scene scene = slab();
  scene.tools[0].max_speed = std::max(1.0, speed);
  const Model model = loadModel(scene);
  const double way = above + depth, arrival = way / speed;
  AtlasDrive poke;
  poke.still_from = arrival + 0.05;
  poke.seconds = arrival + 0.8;
  poke.command = [&](double time) { return tipAt(Vec3(0, 0, height + above - std::min(way, speed * time))); };
  const AtlasRun run = drive(model, poke);
  return compare(run, "held force / equilibrium", run.tool_force.z(), restingForce(model, Vec3(0, 0, height - depth)),
                 0.03);
}

/// The tool is told to be elsewhere at once; it follows at tool.max_speed.
AtlasMeasure teleport(const std::vector<Vec3>& places, bool lifted_off) {
  const Model model = loadModel(slab());
  constexpr double stay = 0.25;
  AtlasDrive jumps;
  jumps.still_from = stay * static_cast<double>(places.size() - 1) + 0.15;
  jumps.seconds = jumps.still_from + 0.7;
  jumps.command = [&](double time) {
    return tipAt(places[std::min(places.size() - 1, static_cast<std::size_t>(time / stay))]);
  };
  const AtlasRun run = drive(model, jumps);
  if (lifted_off) return residual(run);
  return compare(run, "held force / equilibrium", run.tool_force.z(), restingForce(model, places.back()), 0.03);
}

/// Pushed to a share of the thickness and held.
AtlasMeasure bottom(double share, double seconds) {
  const Model model = loadModel(slab());
  const double way = above + share * height, speed = 0.05;
  AtlasDrive push;
  push.still_from = way / speed + 0.1;
  push.seconds = push.still_from + seconds;
  push.command = [&](double time) { return tipAt(Vec3(0, 0, height + above - std::min(way, speed * time))); };
  const AtlasRun run = drive(model, push);
  return compare(run, "force at the end / at first", run.tool_force.z(), run.early_tool_force.z(), 0.02);
}

/// Pushed there, held for a second, and lifted off again.
AtlasMeasure bottomAndBack(double share) {
  const Model model = loadModel(slab());
  const double way = above + share * height, speed = 0.05, down = way / speed, up = down + 1;
  AtlasDrive push;
  push.still_from = up + down + 0.1;
  push.seconds = push.still_from + 0.8;
  push.command = [&](double time) {
    const double gone = time < up ? std::min(way, speed * time) : std::max(0.0, way - speed * (time - up));
    return tipAt(Vec3(0, 0, height + above - gone));
  };
  return residual(drive(model, push));
}

std::string percent(double share) { return std::to_string(std::lround(100 * share)); }

}  // namespace

void addToolCells(std::vector<AtlasAxis>& axes, std::vector<AtlasCell>& cells) {
  axes.push_back({"speed", "Tool speed, m/s",
                  "Slab of 50 x 50 x 20 mm bonded to its base; a sphere of 8 mm goes 6 mm deep at this speed and "
                  "stops; held force beside the equilibrium in double."});
  for (const double speed : {0.1, 0.5, 1.0, 2.0})
    cells.push_back({"speed", format("%g", speed), speed == 0.5 || speed == 2 ? When::Always : When::Full,
                     [=] { return poke(speed); }});
  axes.push_back({"teleport", "Teleport",
                  "The tool is told to be elsewhere from one tick to the next, every 0.25 s: across the slab 6 mm deep "
                  "(held force beside the equilibrium); sideways through all of it, and through its base and back "
                  "(what stays when it is gone)."});
  const double deep = height - 0.006, side = 0.4 * width, off = height + above;
  cells.push_back({"teleport", "across", When::Always, [=] {
                     return teleport({{-side, 0, deep}, {side, 0, deep}, {-side, side, deep}, {0, 0, deep}}, false);
                   }});
  cells.push_back({"teleport", "sideways", When::Always, [=] {
                     return teleport({{-width, 0, 0.5 * height}, {width, 0, 0.5 * height}, {width, 0, off}}, true);
                   }});
  cells.push_back({"teleport", "through", When::Always, [=] {
                     return teleport({{0, 0, off}, {0, 0, -2 * height}, {0, 0, off}}, true);
                   }});
  axes.push_back({"bottom", "To the bottom, % of thickness",
                  "The tool goes down to this share of the slab's thickness at 50 mm/s and is held for a minute "
                  "(quick: 5 s); force at the end beside that of the hold's begin."});
  for (const double share : {0.5, 0.8, 0.95, 1.0, 1.2}) {
    if (share == 0.5 || share == 1)
      cells.push_back({"bottom", percent(share) + " 5s", When::Quick, [=] { return bottom(share, 5); }});
    cells.push_back({"bottom", percent(share), When::Full, [=] { return bottom(share, 60); }});
  }
  axes.push_back({"bottom-back", "There and back, % of thickness",
                  "The same held for a second and lifted off; what stays of the displacement."});
  for (const double share : {0.5, 0.8, 0.95, 1.0, 1.2})
    cells.push_back({"bottom-back", percent(share), share == 0.8 || share == 1.2 ? When::Always : When::Full,
                     [=] { return bottomAndBack(share); }});
}

}  // namespace palpate::tools
