#include "mtled/follow/follow_command.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/interrupt.h"
#include "base/number_text.h"
#include "io/find_asset.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/scene_file.h"
#include "mtled/follow/drag_ways.h"
#include "mtled/run/following_run.h"
#include "mtled/frontier/frontier_page.h"
#include "mtled/frontier/frontier_settings.h"

namespace palpate::tools {
namespace {

using Json = nlohmann::json;

/// What the errors are measured against: fine in balls all along the way, each cell with a point of its own.
Scene referenceScene(const Scene& scene, const DragWay& way, double factor) {
  constexpr double outside = 0.85, inside = 0.45, inside_radii = 0.3, ball_radii = 2, safety = 0.4;
  Scene fine = scene;
  scaleSpacing(fine, factor * outside);
  const double spacing = factor * std::min(inside * scene.spacing, inside_radii * scene.tool.radius);
  const int balls = static_cast<int>(std::ceil(way.length / scene.tool.radius));
  for (int k = 0; k <= balls; ++k) {
    RefineSpec ball;
    ball.centre = way.tip[(way.tip.size() - 1) * static_cast<std::size_t>(k) / static_cast<std::size_t>(balls)];
    ball.radius = ball_radii * scene.tool.radius;
    ball.spacing = spacing;
    fine.refine.push_back(ball);
  }
  fine.quadrature.cells_per_point = 1;
  fine.time_step = 0;
  fine.step_safety = std::min(scene.step_safety, safety);
  return fine;
}

/// What stays where the scene's own cloud follows: about as many nodes as such scenes had before.
Scene uniformScene(Scene scene, const FollowSizes& sizes) {
  constexpr double of_fine = 1.3;
  scene.follow = false;
  scene.spacing = of_fine * sizes.fine;
  scene.set_up_values.clear();
  return scene;
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
    if (row.name == "following" || !row.sound) continue;
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

Json toJson(const Row& row) {
  return {{"name", row.name},         {"nodes", row.nodes},     {"substeps", row.substeps}, {"tick_us", row.tick_us},
          {"force_error", row.error}, {"mean_error", row.mean}, {"sound", row.sound}};
}

}  // namespace

int followCommand(const FollowOptions& options) {
  const Scene scene = readScene(findScene(options.scene));
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
  const Scene uniform = scene.follow ? uniformScene(scene, places.sizes) : scene;
  PlaceShelf shelf(places);
  std::cout << format("%s: fine %.1f mm, coarse %.1f mm, %d nodes in all, %zu centres\n", scene.name.c_str(),
                      1e3 * places.sizes.fine, 1e3 * places.sizes.coarse, places.cloud.nodeCount(),
                      places.centres.size());
  Json all = Json::array();
  std::vector<double> first, worst, apply;
  bool lost = false;
  const auto goOn = [] {
    if (interrupted()) throw std::runtime_error("interrupted; nothing is kept");
  };
  for (std::size_t w = 0; w < ways.size(); ++w) {
    const DragWay& way = ways[w];
    const ToolTrajectory poses = trajectoryOf(way, scene, settings);
    std::cout << format("way %zu: %.0f mm from (%.0f %.0f %.0f) to (%.0f %.0f %.0f) mm\n", w + 1, 1e3 * way.length,
                        1e3 * way.from.x(), 1e3 * way.from.y(), 1e3 * way.from.z(), 1e3 * way.to.x(), 1e3 * way.to.y(),
                        1e3 * way.to.z())
              << std::flush;
    const Model fine = loadModel(referenceScene(uniform, way, options.quick ? 1.2 : 1));
    const ScriptedRun reference = trajectoryOn(fine, poses);
    goOn();
    std::vector<Row> rows;
    const auto measure = [&](const std::string& name, const Scene& turned) {
      const Model model = loadModel(turned);
      rows.push_back(rowOf(name, model.nodeCount(), model.substeps_per_tick, trajectoryOn(model, poses), reference,
                           scene.rate_hz));
      goOn();
    };
    measure(scene.follow ? "uniform" : "as it is", uniform);
    const FollowingRun following = followTrajectory(places, shelf, poses);
    goOn();
    rows.push_back(
        rowOf("following", following.most_nodes, following.substeps, following.run, reference, scene.rate_hz));
    if (!options.quick) {
      for (const double factor : {0.8, 1.3}) {
        Scene turned = uniform;
        scaleSpacing(turned, factor);
        measure(format("spacing x %g", factor), turned);
      }
      measure("reference 1.35", referenceScene(uniform, way, 1.35));
    }
    print(rowOf("reference", fine.nodeCount(), fine.substeps_per_tick, reference, reference, scene.rate_hz),
          rows[0].tick_us);
    for (const Row& row : rows) print(row, rows[0].tick_us);
    if (!options.quick) {
      const std::vector<Row> others(rows.begin(), rows.end() - 1);
      std::cout << format("  uniform nodes at the following cloud's error: x %.2f of its cost\n",
                          uniformCost(others, rows[1].error) / rows[1].tick_us);
    }
    for (const Swap& swap : following.swaps) {
      std::cout << format("  swap at tick %4d: %3d new nodes, %4d rows, %3.0f us", swap.tick, swap.new_nodes, swap.rows,
                          swap.apply_us);
      apply.push_back(swap.apply_us);
      if (swap.loaded) {
        first.push_back(swap.first);
        worst.push_back(swap.worst);
        std::cout << format(", force %.2f %% in the first tick, %.2f %% in 120 ms\n", 100 * swap.first,
                            100 * swap.worst);
      } else {
        std::cout << ", no force yet\n";
      }
    }
    Json json = {{"length_m", way.length}, {"rows", Json::array()}, {"swaps", Json::array()}};
    for (const Row& row : rows) {
      json["rows"].push_back(toJson(row));
      lost |= !row.sound;
    }
    for (const Swap& swap : following.swaps)
      json["swaps"].push_back({{"tick", swap.tick},
                               {"loaded", swap.loaded},
                               {"first", swap.first},
                               {"worst", swap.worst},
                               {"apply_us", swap.apply_us},
                               {"rows", swap.rows}});
    all.push_back(json);
  }
  std::cout << format(
      "%zu swaps under load: median / largest %.2f / %.2f %% in the first tick, %.2f / %.2f %% in 120 ms;"
      " swap %.0f us (median); %d places, %.2f s of processor time each\n",
      first.size(), 100 * quantileOf(first, 0.5), 100 * quantileOf(first, 1), 100 * quantileOf(worst, 0.5),
      100 * quantileOf(worst, 1), quantileOf(apply, 0.5), shelf.count(), shelf.seconds() / shelf.count());
  if (!options.json.empty()) writeWholeFile(options.json, all.dump(2) + "\n");
  return lost ? 1 : 0;
}

}  // namespace palpate::tools
