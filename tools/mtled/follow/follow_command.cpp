#include "mtled/follow/follow_command.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

#include "base/build_info.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "io/find_asset.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "mtled/follow/drag_ways.h"
#include "mtled/frontier/frontier_page.h"
#include "mtled/report/report_page.h"
#include "mtled/run/following_run.h"
#include "mtled/run/scene_spacing.h"

namespace palpate::tools {
namespace {

/// What the errors are measured against: fine in balls all along the way, each cell with a point of its own.
Scene referenceScene(const Scene& scene, const DragWay& way, double factor) {
  constexpr double outside = 0.85, inside = 0.45, inside_radii = 0.3, ball_radii = 2, safety = 0.4;
  Scene fine = scene;
  scaleSpacing(fine, factor * outside);
  const double spacing =
      factor * std::min(inside * scene.discretization.spacing, inside_radii * scene.tools[0].shape.radius);
  const int balls = static_cast<int>(std::ceil(way.length / scene.tools[0].shape.radius));
  for (int k = 0; k <= balls; ++k) {
    RefineSpec ball;
    ball.centre = way.tip[(way.tip.size() - 1) * static_cast<std::size_t>(k) / static_cast<std::size_t>(balls)];
    ball.radius = ball_radii * scene.tools[0].shape.radius;
    ball.spacing = spacing;
    fine.discretization.refine.push_back(ball);
  }
  fine.discretization.quadrature.cells_per_point = 1;
  fine.dynamics.time_step = 0;
  fine.dynamics.mass_scaling = 0;
  fine.dynamics.step_safety = std::min(scene.dynamics.step_safety, safety);
  return fine;
}

struct Row {
  std::string name;
  int nodes = 0, substeps = 0;
  double tick_us = NAN;  // median
  double error = NAN;    // of the force, root mean square over the largest
  double mean = NAN;     // mean of (|f| - |reference|) over the largest
  bool sound = false;
};

Row rowOf(const std::string& name, int nodes, int substeps, const ScriptedRun& run, const ScriptedRun& reference,
          double rate_hz) {
  Row row{name, nodes, substeps, costOf(run, rate_hz).tick_p50, NAN, NAN, run.sound()};
  if (!row.sound || run.force.size() != reference.force.size()) return row;
  row.error = errorOf(run, reference).force;
  double largest = 0, sum = 0;
  int count = 0;
  for (std::size_t k = 0; k < run.force.size(); ++k) {
    const double wanted = reference.force[k].norm();
    if (wanted == 0) continue;
    largest = std::max(largest, wanted);
    sum += run.force[k].norm() - wanted;
    ++count;
  }
  row.mean = sum / count / largest;
  return row;
}

double quantileOf(std::vector<double> values, double q) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(q * static_cast<double>(values.size() - 1)))];
}

/// Cost of uniform clouds at an error, from the rows that are uniform (uniformCostAt).
double uniformCost(const std::vector<Row>& rows, double error) {
  Frontier frontier;
  for (const Row& row : rows) {
    if (row.name.starts_with("following") || !row.sound) continue;
    FrontierRow r;
    r.group = row.name == "as it is" || row.name == "uniform" ? "present" : "spacing";
    r.name = row.name;
    r.cost.us_per_ms = row.tick_us;
    r.error.force = row.error;
    frontier.rows.push_back(r);
  }
  return uniformCostAt(frontier, error);
}

void print(const Row& row, double unit) {
  std::cout << format("  %-14s %6d nodes  %d steps  tick %7.0f us  x %5.2f  force error %6.2f %%  mean %+6.2f %%%s\n",
                      row.name.c_str(), row.nodes, row.substeps, row.tick_us, row.tick_us / unit, 100 * row.error,
                      100 * row.mean, row.sound ? "" : "  LOST");
}

/// Over all swaps under load.
struct Jumps {
  std::vector<double> first, worst;  // shares of the force: in the first tick, in 120 ms
  std::vector<double> apply_us;      // of all swaps
};

/// The drags over one scene.
struct Study {
  std::string scene;
  double fine = 0, coarse = 0;         // m
  std::vector<std::vector<Row>> ways;  // (way_count): the uniform cloud, the following one, then others
  std::vector<double> gain;            // (way_count) uniform nodes' cost at the following cloud's error, over its cost
  Jumps jumps;
  int place_count = 0;
  double place_seconds = 0;  // processor time of each

  bool lost() const {
    return std::any_of(ways.begin(), ways.end(), [](const std::vector<Row>& rows) {
      return std::any_of(rows.begin(), rows.end(), [](const Row& row) { return !row.sound; });
    });
  }
};

void goOn() {
  if (interrupted()) throw std::runtime_error("interrupted; nothing is kept");
}

void print(const Swap& swap) {
  std::cout << format("  swap at tick %4d: %3d new nodes, %4d rows, %3.0f us", swap.tick, swap.new_nodes, swap.rows,
                      swap.apply_us);
  if (swap.loaded)
    std::cout << format(", force %.2f %% in the first tick, %.2f %% in 120 ms\n", 100 * swap.first, 100 * swap.worst);
  else
    std::cout << ", no force yet\n";
}

Scene sceneOf(const std::string& file, double nu) {
  std::vector<SceneChange> changes;
  const std::string path = findScene(file);
  for (std::size_t m = 0; nu > 0 && m < readScene(path).materials.size(); ++m)
    changes.push_back({"material[" + std::to_string(m) + "].poisson", shortest(nu)});
  return readScene(path, changes);
}

Study studyOf(const Scene& scene, const FollowOptions& options) {
  const TriangleSurface organ = organSurface(scene);
  const SurfaceTree tree(organ);
  DragSettings settings;
  settings.count = options.ways;
  const auto ways = dragWays(scene, tree, settings);
  if (ways.empty())
    throw InputError(scene.place,
                     "there is no way of " + format("%g", 500 * settings.length) +
                         " mm over the organ that the tool could be dragged along",
                     "turn tool.direction towards the organ's open side");
  const Places places = makePlaces(scene, organ);
  const Scene uniform = uniformScene(scene);
  PlaceShelf shelf(places);
  // The same trade as uniform clouds make by their spacing.
  std::map<double, std::pair<Places, std::unique_ptr<PlaceShelf>>> others;
  const bool trades = !options.quick && scene.discretization.follow;
  for (const double factor : trades ? std::vector{0.8, 1.4} : std::vector<double>()) {
    Scene scaled = scene;
    scaleSpacing(scaled, factor);
    auto& other = others.try_emplace(factor, makePlaces(scaled, organ), nullptr).first->second;
    other.second = std::make_unique<PlaceShelf>(other.first);
  }
  Study study;
  study.scene = scene.name + (options.nu > 0 ? ", nu " + shortest(options.nu) : "");
  study.fine = places.sizes.fine;
  study.coarse = places.sizes.coarse;
  std::cout << format("%s: fine %.1f mm, coarse %.1f mm, %d nodes in all, %zu centres\n", study.scene.c_str(),
                      1e3 * study.fine, 1e3 * study.coarse, places.nodeCount(), places.centres.size());
  for (const DragWay& way : ways) {
    std::cout << format("way %zu: %.0f mm from (%.0f %.0f %.0f) to (%.0f %.0f %.0f) mm\n", study.ways.size() + 1,
                        1e3 * way.length, 1e3 * way.from.x(), 1e3 * way.from.y(), 1e3 * way.from.z(), 1e3 * way.to.x(),
                        1e3 * way.to.y(), 1e3 * way.to.z())
              << std::flush;
    const Model fine = loadModel(referenceScene(uniform, way, options.quick ? 1.2 : 1));
    const ToolTrajectory poses = othersStand(posturesOn(way, scene, settings), fine);
    const ScriptedRun reference = trajectoryOn(fine, poses);
    goOn();
    std::vector<Row>& rows = study.ways.emplace_back();
    const auto measure = [&](const std::string& name, const Scene& turned) {
      const Model model = loadModel(turned);
      rows.push_back(rowOf(name, model.nodeCount(), model.substeps_per_tick, trajectoryOn(model, poses), reference,
                           scene.dynamics.rate_hz));
      goOn();
    };
    measure(scene.discretization.follow ? "uniform" : "as it is", uniform);
    const FollowingRun following = followTrajectory(places, shelf, poses);
    goOn();
    rows.push_back(
        rowOf("following", following.most_nodes, following.substeps, following.run, reference, scene.dynamics.rate_hz));
    for (auto& [factor, other] : others) {
      const FollowingRun run = followTrajectory(other.first, *other.second, poses);
      rows.push_back(rowOf(format("following x %g", factor), run.most_nodes, run.substeps, run.run, reference,
                           scene.dynamics.rate_hz));
      goOn();
    }
    if (!options.quick) {
      for (const double factor : {0.8, 1.3}) {
        Scene turned = uniform;
        scaleSpacing(turned, factor);
        measure(format("spacing x %g", factor), turned);
      }
      study.gain.push_back(uniformCost(rows, rows[1].error) / rows[1].tick_us);
      measure("reference 1.35", referenceScene(uniform, way, 1.35));
    }
    print(rowOf("reference", fine.nodeCount(), fine.substeps_per_tick, reference, reference, scene.dynamics.rate_hz),
          rows[0].tick_us);
    for (const Row& row : rows) print(row, rows[0].tick_us);
    if (!options.quick)
      std::cout << format("  uniform nodes at the following cloud's error: x %.2f of its cost\n", study.gain.back());
    for (const Swap& swap : following.swaps) {
      print(swap);
      study.jumps.apply_us.push_back(swap.apply_us);
      if (!swap.loaded) continue;
      study.jumps.first.push_back(swap.first);
      study.jumps.worst.push_back(swap.worst);
    }
  }
  study.place_count = shelf.count();
  study.place_seconds = shelf.seconds() / shelf.count();
  return study;
}

std::string jumpsText(const Study& s) {
  return format(
      "%zu swaps under load: median / largest %.2f / %.2f %% in the first tick, %.2f / %.2f %% in 120 ms;"
      " swap %.0f us (median); %d places, %.2f s of processor time each",
      s.jumps.first.size(), 100 * quantileOf(s.jumps.first, 0.5), 100 * quantileOf(s.jumps.first, 1),
      100 * quantileOf(s.jumps.worst, 0.5), 100 * quantileOf(s.jumps.worst, 1), quantileOf(s.jumps.apply_us, 0.5),
      s.place_count, s.place_seconds);
}

CaseResult caseOf(const Study& s) {
  CaseResult one;
  one.name = s.scene;
  one.title = s.scene;
  one.reference = "a cloud that is fine along the whole way, with the tissue's own mass";
  one.text = format("Nodes %.1f mm apart in the ball, %.1f mm far from it. ", 1e3 * s.fine, 1e3 * s.coarse) +
             jumpsText(s) + ".";
  ResultTable table{"Drags of 60 mm, half a radius deep, 30 mm/s, one thread",
                    {"way", "cloud", "nodes", "steps a tick", "tick, us", "of the first", "force error", "mean"},
                    {},
                    "Force error: root mean square over the largest force. Times are of the machine that wrote this."};
  double follows = 0, uniform = 0, cost = 0;
  for (std::size_t w = 0; w < s.ways.size(); ++w) {
    for (const Row& row : s.ways[w])
      table.rows.push_back({std::to_string(w + 1), row.name + (row.sound ? "" : " (lost)"), std::to_string(row.nodes),
                            std::to_string(row.substeps), format("%.0f", row.tick_us),
                            format("%.2f", row.tick_us / s.ways[w][0].tick_us), format("%.2f %%", 100 * row.error),
                            format("%+.2f %%", 100 * row.mean)});
    uniform += s.ways[w][0].error / static_cast<double>(s.ways.size());
    follows += s.ways[w][1].error / static_cast<double>(s.ways.size());
    cost += s.ways[w][1].tick_us / s.ways[w][0].tick_us / static_cast<double>(s.ways.size());
  }
  one.tables.push_back(table);
  one.bounds.push_back({"Force error of the following cloud, mean of the ways", 100 * follows, 100 * uniform, true, "%",
                        "of the uniform cloud"});
  one.bounds.push_back({"Its tick over that of the uniform cloud", cost, 0.5, true, "", ""});
  if (!s.gain.empty())
    one.bounds.push_back({"Uniform nodes' cost at its error over its cost, median", quantileOf(s.gain, 0.5), 5, false,
                          "", "power law through the uniform rows"});
  one.bounds.push_back({"Largest change of the force in a swap's first tick", 100 * quantileOf(s.jumps.first, 1), 0.5,
                        true, "%", "beside the same run without the swap"});
  one.seconds = NAN;
  return one;
}

}  // namespace

int followCommand(const FollowOptions& options) {
  Report report;
  report.title = "A cloud that follows the tool";
  report.intro =
      "What `mtled follow` found: the tool is dragged over the organ on uniform clouds, and on one that is dense "
      "around "
      "the tool alone and changes every 10 mm. A bound that is not held is a goal not reached.";
  report.command = "build/release/tools/mtled follow";
  if (!options.report.empty()) checkReport(options.report);
  bool lost = false;
  for (const std::string& file : options.scenes) {
    const Study study = studyOf(sceneOf(file, options.nu), options);
    std::cout << jumpsText(study) << "\n";
    lost |= study.lost();
    report.cases.push_back(caseOf(study));
    report.command += " " + file;
  }
  report.command += format(" --ways %d", options.ways) + (options.nu > 0 ? " --nu " + shortest(options.nu) : "") +
                    (options.quick ? " --quick" : "") + " --report " + options.report;
  report.build = buildInfo();
  if (!options.report.empty()) writeReport(options.report, report);
  return lost ? 1 : 0;
}

}  // namespace palpate::tools
