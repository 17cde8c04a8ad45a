// Every two settings of a scene together, in scenes drawn by lot: whoever writes such a scene gets a sentence, or
// tissue that stays whole under a press.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "io/load_model.h"
#include "io/scene_file.h"
#include "realtime/loop/physics.h"
#include "support/temp_folder.h"

using namespace palpate;

namespace {

/// Of one setting: what stands in which table. A name that ends in a number is one more table of a list.
using Setting = std::vector<std::pair<std::string, std::string>>;
/// Settings of which a scene has one; the first is the plainest.
using Choice = std::vector<Setting>;

const std::string motion = "duration = 0.2\n", turn = "axis_point = [0, 0, 0.02]\naxis = [0, 0, 1]\nangle = 4\n",
                  beside = "region = { shape = \"box\", min = [-0.03, -0.03, 0.007], max = [-0.012, 0.03, 0.03] }\n",
                  lid = "shape = \"box\"\nmin = [-0.03, -0.03, 0.007]\nmax = [-0.012, 0.03, 0.03]\n";

const std::vector<Choice> choices = {
    {{{"organ", "solid = \"box\"\nsize = [0.04, 0.04, 0.024]\n"}},
     {{"organ", "solid = \"cylinder\"\nradius = 0.022\nheight = 0.024\n"}},
     {{"organ", "solid = \"ellipsoid\"\nsemi_axes = [0.025, 0.022, 0.024]\nupper_half = true\n"}}},
    {{}, {{"organ", "axis = [0, 0, 1]\nangle = 20\n"}}},
    {{}, {{"organ", "friction = 0.3\n"}}},
    {{{"discretization", "spacing = 0.007\n"}},
     {{"discretization", "spacing = 0.008\n"},
      {"discretization.refine", "centre = [0, 0, 0.024]\nradius = 0.006\nspacing = 0.004\n"}},
     {{"discretization", "follow = true\n"}}},
    {{},
     {{"discretization", "points_per_cell = 4\n"}},
     {{"discretization", "cells_per_point = 1.5\n"}},
     {{"discretization", "quadrature_accuracy = 0.2\nquadrature_division = 4\nquadrature_depth = 1\n"}}},
    {{}, {{"discretization", "seed = 7\n"}}},
    {{}, {{"discretization", "basis = \"linear\"\n"}}},
    {{}, {{"discretization", "support_factor = 1.8\n"}}},
    {{}, {{"discretization", "mu = 0.1\n"}}},
    {{}, {{"discretization", "scheme = \"paper\"\n"}}},
    {{}, {{"discretization", "boundary_method = \"ebciem\"\n"}}},
    {{{"material", "model = \"neo-hookean\"\nyoung = 3000\npoisson = 0.45\n"}},
     {{"material", "model = \"neo-hookean\"\nyoung = 3000\npoisson = 0.49\n"}},
     {{"material", "model = \"neo-hookean\"\nyoung = 3000\npoisson = 0.1\n"}},
     {{"material", "model = \"mooney-rivlin\"\nc10 = 300\nc01 = 200\nD1 = 2e-4\n"}},
     {{"material", "model = \"ogden\"\nmu = [600, 400]\nalpha = [-1.1, 2]\nD1 = 2e-4\n"}},
     {{"material",
       "model = \"fibre-reinforced\"\nyoung = 2000\npoisson = 0.45\nk1 = 800\nk2 = 2\nfibre = [1, 0, 1]\n"}}},
    {{}, {{"material", "relaxation = [[0.3, 0.1]]\n"}}},
    {{}, {{"material", "density = 1200\n"}}},
    {{},
     {{"material1",
       "model = \"neo-hookean\"\nyoung = 20000\npoisson = 0.45\n"
       "region = { shape = \"sphere\", centre = [0, 0, 0.012], radius = 0.007 }\n"}},
     {{"material1",
       "model = \"ogden\"\nmu = [300]\nalpha = [2]\nD1 = 3e-4\n"
       "region = { shape = \"half-space\", point = [0, 0, 0.01], normal = [0, 0, 1] }\n"}}},
    {{},
     {{"fixed1",
       "shape = \"near-plane\"\npoint = [0.02, 0, 0]\nnormal = [1, 0, 0]\ndistance = 1e-3\n"
       "components = [\"y\"]\nsurface_only = true\n"}}},
    {{},
     {{"prescribed", lid + "translation = [0.001, 0, 0]\n" + motion}},
     {{"prescribed", lid + turn + motion}},
     {{"prescribed", lid + "translation = [0, 0.001, 0]\n" + motion + "curve = \"linear\"\n"}}},
    {{},
     {{"rigid", "region = { shape = \"half-space\", point = [0, 0, -0.0005], normal = [0, 0, 1] }\nfriction = 0.5\n"}},
     {{"rigid", "region = { shape = \"half-space\", point = [-0.03, 0, 0], normal = [1, 0, 0] }\n" + turn + motion}}},
    {{}, {{"skull", "from = \"organ\"\nopen = [{ shape = \"sphere\", centre = [0, 0, 0.024], radius = 0.015 }]\n"}}},
    {{},
     {{"load", beside + "pressure = 100\n" + motion}},
     {{"load", beside + "pressure = 100\nkind = \"dead\"\n" + motion}},
     {{"load", beside + "traction = [0, 0, 50]\n" + motion}}},
    {{}, {{"dynamics", "rate = 1000\n"}}},
    {{}, {{"dynamics", "catch_up = 0\n"}}},
    {{}, {{"dynamics", "step_safety = 0.4\n"}}},
    {{}, {{"dynamics", "mass_scaling = 0.1\n"}}},
    {{}, {{"dynamics", "damping = 80\n"}}},
    {{}, {{"dynamics", "gravity = [0, 0, -9.81]\n"}}},
    {{}, {{"dynamics", "threads = 2\n"}}},
    {{}, {{"dynamics", "gradient_precision = \"int16\"\n"}}},
    {{}, {{"solve", "load_steps = 2\n"}}, {{"solve", "mode = \"transient\"\nend_time = 0.1\n"}}},
    {{{"tool", "shape = \"sphere\"\nradius = 0.006\n"}},
     {{"tool", "shape = \"cylinder\"\nradius = 0.006\nlength = 0.03\nedge_radius = 0.001\n"}},
     {{"tool", "shape = \"capsule\"\nradius = 0.006\nlength = 0.03\n"}},
     {{"tool", "shape = \"cone\"\nradius = 0.006\nlength = 0.03\nhalf_angle = 40\ntip_radius = 0.003\n"}}},
    {{}, {{"tool", "opening = 0.02\ngrip_force = 1\n"}}},
    {{}, {{"tool", "max_force = 1\n"}}},
    {{}, {{"tool", "max_speed = 0.3\n"}}},
    {{}, {{"tool", "friction = 0.4\n"}}},
    {{}, {{"tool1", "shape = \"sphere\"\nradius = 0.006\nposition = [0.012, 0, 0.05]\n"}}},
    {{}, {{"force", "cutoff = 40\n"}}},
    {{}, {{"force", "rate_limit = 50\n"}}},
    {{},
     {{"lump", "centre = [0, 0, 0.012]\nradius = 0.006\nyoung = 30000\n"}},
     {{"lumps", "count = 1\nlevel = 3\nseed = 3\n"}}},
};

/// Of each choice the setting taken.
using Draw = std::vector<std::size_t>;

std::string textOf(const Draw& draw) {
  static const std::set<std::string> lists = {
      "discretization.refine", "material", "fixed", "prescribed", "rigid", "load", "tool", "lump"};
  std::map<std::string, std::string> tables = {
      {"fixed", "shape = \"half-space\"\npoint = [0, 0, 0.001]\nnormal = [0, 0, 1]\n"},
      {"tool", "position = [0, 0, 0.03]\n"}};
  const std::string order[] = {"organ",    "discretization", "discretization.refine",
                               "material", "material1",      "fixed",
                               "fixed1",   "prescribed",     "rigid",
                               "skull",    "load",           "dynamics",
                               "solve",    "tool",           "tool1",
                               "force",    "lump",           "lumps"};
  for (std::size_t k = 0; k < choices.size(); ++k)
    for (const auto& [table, lines] : choices[k][draw[k]]) tables[table] += lines;
  std::string text;
  for (const std::string& table : order) {
    const auto lines = tables.find(table);
    if (lines == tables.end()) continue;
    std::string name = table;
    if (name.back() == '1') name.pop_back();
    text += (lists.count(name) ? "[[" + name + "]]\n" : "[" + name + "]\n") + lines->second;
  }
  return text;
}

/// Loads the scene; at will the tool then presses it. @throws InputError where it is refused
void tryScene(const TempFolder& folder, const Draw& draw, bool press) {
  const Scene scene = readScene(folder.write("pairs.toml", textOf(draw)));
  std::shared_ptr<PlaceSource> following;
  std::optional<Model> still;
  if (scene.discretization.follow)
    following = loadFollowing(scene);
  else
    still = loadModel(scene);
  if (!press) return;
  std::shared_ptr<ReadyPlace> start;
  if (following)
    start = std::make_shared<ReadyPlace>(following->start(), std::make_shared<SpinTeam>(scene.dynamics.threads));
  const Model& model = start ? start->place.model : *still;
  auto physics = start ? std::make_unique<TissuePhysics>(following->places(), start)
                       : std::make_unique<TissuePhysics>(model, scene.dynamics.threads);
  constexpr int ticks = 60;
  double force = 0;
  for (int k = 1; k <= ticks; ++k) {
    Command command;
    command.tools[0].pose = model.tools.first().start.pose;
    command.tools[0].pose.position.z() -= (model.tools.first().first_contact_travel + 0.003) * k / ticks;
    const StepReport report = physics->tick(command);
    CAPTURE(textOf(draw), k, report.min_J);
    REQUIRE((report.flags & (kNotFinite | kBlowUp | kInvertedPoints)) == 0);
    force = report.tool_force.norm();
  }
  CAPTURE(textOf(draw), force);
  CHECK(std::isfinite(force));
}

}  // namespace

TEST_CASE("Every two settings of a scene stand together and press, or are refused with what to do", "[pairs]") {
  const TempFolder folder;
  std::mt19937 lot(1);
  using One = std::pair<std::size_t, std::size_t>;  // choice, setting
  std::set<std::pair<One, One>> missing;
  for (std::size_t a = 0; a < choices.size(); ++a)
    for (std::size_t b = a + 1; b < choices.size(); ++b)
      for (std::size_t i = 0; i < choices[a].size(); ++i)
        for (std::size_t j = 0; j < choices[b].size(); ++j) missing.insert({{a, i}, {b, j}});
  std::map<std::vector<One>, std::string> refused;

  // What is left of a refused scene when all that it is not refused for is as plain as can be.
  const auto keepRefusal = [&](Draw draw) {
    std::string sentence;
    for (std::size_t k = 0; k <= draw.size(); ++k) {  // the last time for the sentence
      Draw plainer = draw;
      if (k < draw.size() && plainer[k] == 0) continue;
      if (k < draw.size()) plainer[k] = 0;
      try {
        tryScene(folder, plainer, false);
      } catch (const InputError& error) {
        draw = plainer;
        sentence = error.what();
      }
    }
    std::vector<One> left;
    for (std::size_t k = 0; k < draw.size(); ++k)
      if (draw[k] != 0) left.emplace_back(k, draw[k]);
    refused[left] = sentence;
    std::erase_if(missing, [&](const std::pair<One, One>& pair) {
      return std::all_of(left.begin(), left.end(), [&](const One& o) { return o == pair.first || o == pair.second; });
    });
  };
  int scenes = 0;
  for (int round = 0; !missing.empty() && round < 400; ++round) {
    const auto wanted = *std::next(missing.begin(), static_cast<std::ptrdiff_t>(lot() % missing.size()));
    Draw draw(choices.size(), 0);
    std::vector<One> taken = {wanted.first, wanted.second};
    for (const One& one : taken) draw[one.first] = one.second;
    const auto isRefused = [&] {
      return std::any_of(refused.begin(), refused.end(), [&](const auto& known) {
        return std::all_of(known.first.begin(), known.first.end(),
                           [&](const One& one) { return draw[one.first] == one.second; });
      });
    };
    std::vector<std::size_t> order(choices.size());
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), lot);
    for (const std::size_t k : order) {  // what brings most that is missing
      if (k == wanted.first.first || k == wanted.second.first) continue;
      std::size_t best = 0;
      std::ptrdiff_t most = -1;
      for (std::size_t i = 0; i < choices[k].size(); ++i) {
        const One one{k, i};
        const auto count = std::count_if(taken.begin(), taken.end(), [&](const One& other) {
          return missing.count({std::min(one, other), std::max(one, other)}) > 0;
        });
        draw[k] = i;
        if (count > most && !isRefused()) {
          best = i;
          most = count;
        }
      }
      draw[k] = best;
      taken.emplace_back(k, best);
    }
    try {
      tryScene(folder, draw, true);
    } catch (const InputError&) {
      keepRefusal(draw);
      continue;
    }
    ++scenes;
    for (std::size_t a = 0; a < draw.size(); ++a)
      for (std::size_t b = a + 1; b < draw.size(); ++b) missing.erase({{a, draw[a]}, {b, draw[b]}});
  }
  CHECK(missing.empty());
  CAPTURE(scenes);
  for (const auto& [settings, sentence] : refused) FAIL_CHECK(sentence);
}
