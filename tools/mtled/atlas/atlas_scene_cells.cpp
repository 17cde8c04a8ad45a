// Cells of tools/mtled/atlas/atlas_cells.h: what a hand may do to the scenes of assets.
#include <algorithm>
#include <cmath>
#include <random>

#include "base/number_text.h"
#include "batch/static_solver.h"
#include "io/find_asset.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "mtled/atlas/atlas_cells.h"
#include "mtled/atlas/atlas_run.h"
#include "realtime/loop/tool_proxy.h"

namespace palpate::tools {
namespace {

using When = AtlasCell::When;

/// A scene of assets, and how much coarser its nodes lie here: 150 to 900 nodes.
struct CoarseScene {
  const char* name;
  double coarser;
};

/// All with one tool whose organ is held on all axes.
constexpr CoarseScene coarse_scenes[] = {{"liver", 2.0},        {"liver_1khz", 1.6},   {"lump_liver", 2.0},
                                         {"kidney", 1.6},       {"lump_breast", 1.9},  {"brain_half_ellipsoid", 1.4},
                                         {"gel_cylinder", 1.0}, {"layer_sphere", 1.0}, {"box_extension", 1.6}};

/// The scene as its file has it, but coarser, in one thread and with no imposed motion but the tool's.
Model coarse(const CoarseScene& which) {
  Scene scene = readScene(findScene(which.name));
  scene.set_up_values.clear();  // not the file's any more: nothing is kept
  scene.discretization.spacing *= which.coarser;
  for (RefineSpec& refine : scene.discretization.refine) refine.spacing *= which.coarser;
  std::erase_if(scene.boundaries, [](const BoundarySpec& b) { return !b.translation.isZero(0) || b.angle != 0; });
  scene.dynamics.threads = 1;
  return loadModel(scene);
}

/// m from the first touch to the tissue's other side along the tool's way.
double thicknessBefore(const Model& model) {
  double deepest = 0;
  for (const Vec3& X : model.skin.surface.vertices)
    deepest = std::max(deepest, -model.tools.first().start.pose.toLocal(X).z());
  return deepest - model.tools.first().first_contact_travel;
}

/// The tool's start, `travel` m further along its axis and `aside` across it.
Command toolAt(const Model& model, double travel, double aside = 0) {
  Command command;
  command.tools[0].pose = model.tools.first().start.pose;
  command.tools[0].pose.position += model.tools.first().start.pose.orientation * Vec3(aside, 0, -travel);
  return command;
}

/// N, along the tool's axis; NaN where it is none.
double forceIn(const Equilibrium& at, const Model& model) {
  return at.converged ? at.tool_force.dot(model.tools.first().start.pose.orientation * Vec3::UnitZ()) : NAN;
}

/// Force against the tool where it stands, N: the equilibrium in double. NaN where there is none.
double forceInEquilibrium(const Model& model, const Pose& tool) {
  return forceIn(ledTo(model, tool.position, 1e-3), model);
}

/// Where no equilibrium is found, at least the force should stay what it is.
AtlasMeasure againstItself(const AtlasRun& run, const std::string& what) {
  return compare(run, what + ", force at the end / at first", run.tool_force.norm(), run.early_tool_force.norm(), 0.02);
}

/// The same in the equilibrium nearest to where the run ended.
double forceFromThere(const Model& model, const AtlasRun& run) {
  StaticSolver solver(model, 1, 1e-3);
  AlignedVector<Double4> u;
  for (const Vec3& a : run.u) u.push_back({a.x(), a.y(), a.z(), 0});
  solver.resume(0, u, run.tool);
  return forceIn(solver.advanceTo(0, run.tool), model);
}

/// A quick press may leave the tissue in another equilibrium than a gentle one: folded elsewhere, or slipped to another
/// side of the tool. Then that one is what the force is held against, and the cell says so.
AtlasMeasure againstEquilibrium(const Model& model, const AtlasRun& run) {
  constexpr double bound = 0.05;
  if (run.lost()) return run.measure;
  const double held = run.tool_force.dot(run.tool.orientation * Vec3::UnitZ());
  const double force = forceInEquilibrium(model, run.tool);
  if (std::isnan(force)) return againstItself(run, "no equilibrium found");
  if (!(std::abs(held - force) <= bound * std::abs(force)))
    if (const double there = forceFromThere(model, run); std::abs(held - there) <= bound * std::abs(there))
      return compare(run, format("a gentle press has %.3g of it; held force / equilibrium there", force / held), held,
                     there, bound);
  return compare(run, "held force / equilibrium", held, force, bound);
}

/// What stays of the displacements when the tool is gone, as a share of the organ's size along the tool. A tool that
/// came out from under the organ may have hooked it, and then holds it up.
AtlasMeasure residual(const Model& model, const AtlasRun& run) {
  if (!run.lost() && !run.tool_force.isZero(0)) return againstItself(run, "hangs on the tool");
  double stays = 0;
  for (const Vec3& a : run.u) stays = std::max(stays, a.norm());
  const double size = thicknessBefore(model);
  return compare(run, "what stays / thickness", size + stays, size, 1e-3);
}

/// The hand goes down at `speed` (0: it is there at once, after a reset) to a share of the thickness, and is held.
AtlasMeasure down(const CoarseScene& scene, double share, double speed) {
  const Model model = coarse(scene);
  const double way = model.tools.first().first_contact_travel + share * thicknessBefore(model);
  // After a reset the tool comes at ToolProxy's gentle speed.
  const double arrival = way / (speed > 0 ? speed : ToolProxy::gentle_speed);
  AtlasDrive press;
  press.yields = true;
  press.put_back = speed == 0;
  press.still_from = arrival + 0.4;
  press.seconds = arrival + 1.4;
  press.command = [&](double time) { return toolAt(model, speed > 0 ? std::min(way, speed * time) : way); };
  return againstEquilibrium(model, drive(model, press));
}

/// Down to a share of the thickness, dragged out at one side and in at the other, and lifted off.
AtlasMeasure drag(const CoarseScene& scene, double share, double speed) {
  const Model model = coarse(scene);
  const double way = model.tools.first().first_contact_travel + share * thicknessBefore(model);
  double half = 0;  // m, to the organ's side and clear of it
  for (const Vec3& X : model.skin.surface.vertices)
    half = std::max(half, std::abs(model.tools.first().start.pose.toLocal(X).x()));
  half += 2 * model.scene.tools[0].shape.radius;
  const double in = way / speed, out = in + half / speed, back = out + 2 * half / speed, up = back + half / speed;
  AtlasDrive pull;
  pull.yields = true;
  pull.still_from = up + in + 1;
  pull.seconds = up + in + 2;
  pull.command = [&](double time) {
    if (time < in) return toolAt(model, speed * time);
    if (time < out) return toolAt(model, way, speed * (time - in));
    if (time < back) return toolAt(model, way, half - speed * (time - out));
    if (time < up) return toolAt(model, way, std::min(0.0, speed * (time - back) - half));
    return toolAt(model, std::max(0.0, way - speed * (time - up)));
  };
  return residual(model, drive(model, pull));
}

/// Told to be under the organ at once, held there, and told to be back at the start at once.
AtlasMeasure through(const CoarseScene& scene) {
  const Model model = coarse(scene);
  const double way = model.tools.first().first_contact_travel + 1.2 * thicknessBefore(model);
  constexpr double held = 2;  // s
  AtlasDrive jump;
  jump.yields = true;
  jump.still_from = held + 1;
  jump.seconds = held + 2;
  jump.command = [&](double time) { return toolAt(model, time < held ? way : 0); };
  return residual(model, drive(model, jump));
}

/// A hand that goes anywhere over, in and under the organ at up to 0.5 m/s or at once, for two seconds, then lifts off.
AtlasMeasure randomHand(const CoarseScene& scene, unsigned seed) {
  const Model model = coarse(scene);
  Vec3 low = model.tools.first().start.pose.toLocal(model.skin.surface.vertices.front()), high = low;
  for (const Vec3& X : model.skin.surface.vertices) {
    low = low.cwiseMin(model.tools.first().start.pose.toLocal(X));
    high = high.cwiseMax(model.tools.first().start.pose.toLocal(X));
  }
  std::mt19937 random(seed);
  const auto uniform = [&](double from, double to) { return from + (to - from) * (random() / 4294967296.0); };
  constexpr double rough_for = 2;  // s
  const double tick_s = 1 / model.scene.dynamics.rate_hz, size = (high - low).norm();
  Vec3 hand = Vec3::Zero(), goal = hand;
  double speed = 0, held_until = 0;
  AtlasDrive rough;
  rough.yields = true;
  rough.still_from = rough_for + 3;  // folds are found long before, and what hangs on the tool has come to rest
  rough.seconds = rough.still_from + 1;
  rough.command = [&](double time) {
    if (time > rough_for) {
      goal = Vec3(hand.x(), hand.y(), high.z() + model.scene.tools[0].shape.radius);
      speed = 1;
    } else if (hand == goal && time > held_until) {
      for (int c = 0; c < 3; ++c) goal[c] = uniform(low[c], high[c]);
      goal.z() = uniform(low.z() - 0.1 * size, high.z() + 0.2 * size);
      speed = random() % 4 == 0 ? 0 : uniform(0.05, 0.5);
      held_until = time + uniform(0, 0.3);
    }
    const Vec3 way = goal - hand;
    const double reach = speed * tick_s, distance = way.norm();
    hand = speed > 0 && distance > reach ? Vec3(hand + reach / distance * way) : goal;
    Command command;
    command.tools[0].pose = model.tools.first().start.pose;
    command.tools[0].pose.position = model.tools.first().start.pose.toWorld(hand);
    return command;
  };
  return residual(model, drive(model, rough));
}

bool is(const CoarseScene& scene, const char* name) { return scene.name == std::string(name); }

}  // namespace

void addSceneCells(std::vector<AtlasAxis>& axes, std::vector<AtlasCell>& cells) {
  const auto add = [&](const char* axis, std::string value, bool quick, std::function<AtlasMeasure()> run) {
    cells.push_back({axis, std::move(value), quick ? When::Always : When::Full, std::move(run)});
  };
  axes.push_back(
      {"press", "Scene, depth in % of its thickness, speed in m/s",
       "Scenes of assets with fewer nodes; the hand goes down at this speed and is held, the tool follows as "
       "far as the tissue lets it; held force beside the equilibrium in double at the tool's place."});
  for (const CoarseScene& scene : coarse_scenes)
    for (const double share : {0.1, 0.25, 0.5})
      for (const double speed : {0.05, 0.5})
        add("press", format("%s %g %g", scene.name, 100 * share, speed),
            is(scene, "layer_sphere") && share == 0.25 && speed == 0.5, [=] { return down(scene, share, speed); });
  axes.push_back({"deep", "Scene, a hand that stands deep at a reset",
                  "The same scenes; right after a reset the hand is at a third of the thickness, and stays there; held "
                  "force beside the equilibrium in double at the tool's place."});
  for (const CoarseScene& scene : coarse_scenes)
    add("deep", scene.name, is(scene, "layer_sphere"), [=] { return down(scene, 1.0 / 3, 0); });
  axes.push_back({"drag", "Scene, speed of a drag, m/s",
                  "The same scenes; the hand goes to a quarter of the thickness, out at one side, in again and out at "
                  "the other, back and up; what stays of the displacement."});
  for (const CoarseScene& scene : coarse_scenes)
    for (const double speed : {0.1, 0.5})
      add("drag", format("%s %g", scene.name, speed), is(scene, "layer_sphere") && speed == 0.5,
          [=] { return drag(scene, 0.25, speed); });
  axes.push_back({"through", "Scene, told to be under it",
                  "The same scenes; the hand is under the organ from one tick to the next, stays for 2 s, and is as "
                  "suddenly back; what stays of the displacement."});
  for (const CoarseScene& scene : coarse_scenes)
    add("through", scene.name, is(scene, "box_extension"), [=] { return through(scene); });
  axes.push_back({"hands", "Scene, random hand's seed",
                  "The same scenes; for 2 s a hand goes anywhere in and about the organ at up to 0.5 m/s, or at once, "
                  "then lifts off; what stays of the displacement."});
  for (const CoarseScene& scene : coarse_scenes)
    for (const unsigned seed : {1U, 2U, 3U})
      add("hands", format("%s %u", scene.name, seed), is(scene, "brain_half_ellipsoid") && seed == 1,
          [=] { return randomHand(scene, seed); });
}

}  // namespace palpate::tools
