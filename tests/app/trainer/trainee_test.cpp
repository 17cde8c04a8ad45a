#include "app/trainer/trainee.h"

#include "app/trainer/feel_check.h"
#include "app/trainer/felt_layout.h"

#include <catch2/catch.hpp>

#include "io/load_model.h"
#include "io/scene_lumps.h"
#include "realtime/loop/simulation_loop.h"
#include "realtime/recording/recording.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::app;

namespace {

constexpr double depth = 0.006, grid = 0.013;  // m

/// A block of soft tissue of 90 x 60 x 30 mm with a lump of the first level.
Model blockWithLump() {
  Scene scene = test::blockScene(0.012);
  scene.size = Vec3(0.09, 0.06, 0.03);
  scene.materials[0].material = Material::neoHookean(6600, 0.45, 1000);
  scene.tool.radius = 0.008;
  addLump(Vec3(0.02, 0, 0.018), 0.009, 50e3, {}, scene);
  return buildModel(scene, boxSurface(scene.size, 0.004));
}

struct Played {
  std::vector<ForceSample> samples;
  std::vector<TimedRequest> changes;
  std::vector<Vec3> marks;
  std::uint64_t hash = 0;
};

Played play(const Model& model, std::vector<TimedRequest> replayed = {}, std::int64_t ticks = 0) {
  TissuePhysics physics(model, 1);
  Trainee trainee(model, depth, grid);
  SimulationLoopOptions options;
  options.as_fast_as_possible = true;
  options.force_capacity = options.record_capacity = 1 << 15;
  if (replayed.empty()) {
    options.motion = &trainee;
    options.record = true;
    options.track_ticks = options.tick_limit = trainee.ticks();
  } else {
    options.track = std::move(replayed);
    options.track_ticks = options.tick_limit = ticks;
  }
  SimulationLoop loop(model, physics, nullptr, options);
  loop.run();
  Played played;
  ForceSample sample;
  while (loop.forces().pop(sample)) played.samples.push_back(sample);
  TimedRequest change;
  while (loop.recorded().pop(change)) played.changes.push_back(change);
  played.marks = trainee.marks();
  played.hash = loop.summary().state_hash;
  return played;
}

std::string scored(const Model& model, const Played& played, const std::vector<Vec3>& marks) {
  TaskScore score(model, lumpsOf(model));
  for (const ForceSample& sample : played.samples) score.add(sample);
  for (const Vec3& mark : marks) score.mark(mark, 2, score.seconds());
  return score.json("block");
}

}  // namespace

TEST_CASE("A trainee by rule finds a lump of the first level, and a replay has the same score bit for bit",
          "[trainer][whole]") {
  const Model model = blockWithLump();
  const Played played = play(model);
  TaskScore score(model, lumpsOf(model));
  for (const ForceSample& sample : played.samples) score.add(sample);
  for (const Vec3& mark : played.marks) score.mark(mark, 2, score.seconds());
  const TaskScore::Sheet sheet = score.sheet();
  CHECK(sheet.hits == 1);
  CHECK(sheet.misses == 0);
  CHECK(sheet.false_alarms == 0);
  CHECK(sheet.mean_error_mm < 13);
  CHECK(sheet.covered_share > 0.1);
  CHECK(sheet.peak_force_N > sheet.mean_force_N);

  const Played again = play(model, played.changes, static_cast<std::int64_t>(played.samples.size()));
  CHECK(again.hash == played.hash);
  CHECK(scored(model, again, played.marks) == scored(model, played, played.marks));
}

TEST_CASE("A lump of the first level is felt as clearly stiffer; a small deep one is not", "[trainer]") {
  const std::vector<LumpFeel> feels = feelLumps(blockWithLump(), depth);
  REQUIRE(feels.size() == 1);
  CHECK(feels[0].ratio() > least_feel);
  Scene scene = test::blockScene(0.012);
  scene.tool.radius = 0.008;
  addLump(Vec3(0.01, 0, 0.012), 0.004, 20e3, {}, scene);
  const std::vector<LumpFeel> deep = feelLumps(buildModel(scene, boxSurface(scene.size, 0.004)), depth);
  CHECK(deep[0].ratio() < least_feel);
}

TEST_CASE("A layout that can't be felt is refused with its lump, and what was felt is kept", "[trainer]") {
  Scene scene = test::blockScene(0.012);
  scene.tool.radius = 0.008;
  addLump(Vec3(0.01, 0, 0.012), 0.004, 20e3, {"x.toml", 7}, scene);
  const Model model = buildModel(scene, boxSurface(scene.size, 0.004));
  const TempFolder folder;
  const auto problem = [&] {
    try {
      requireFelt(model, folder.path("cache"));
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string first = problem();
  CHECK(first.starts_with("x.toml:7: lump 1 (8 mm across, "));
  CHECK(first.find("can't be felt") != std::string::npos);
  CHECK(problem() == first);
  // Only what was kept can say that it is felt now.
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path("cache"))) {
    std::ofstream(entry.path()) << "2.5\n";
    ++files;
  }
  CHECK(files == 1);
  CHECK(problem().empty());
}

TEST_CASE("Of lumps at random the first layout in which all can be felt is taken, of a dozen", "[trainer][whole]") {
  Scene scene = test::blockScene(0.012);
  scene.tool.radius = 0.008;
  scene.places["lumps.count"] = scene.place = {"x.toml", 7};
  Scene hidden = scene;
  addLump(Vec3(0.01, 0, 0.012), 0.004, 20e3, {"x.toml", 7}, hidden);
  const Model unfelt = buildModel(hidden, boxSurface(scene.size, 0.004)), felt = blockWithLump();
  const TempFolder folder;
  std::vector<int> asked;
  std::string said;
  int first_felt = 3;
  TaskMaking making;
  making.read = [&](int layout) {
    asked.push_back(layout);
    return scene;
  };
  making.build = [&](const Scene&) { return asked.empty() || asked.back() < first_felt ? unfelt : felt; };
  making.say = [&](const std::string& line) { said += line + "\n"; };
  making.cache_folder = folder.path("cache");
  CHECK(lumpsOf(makeTask(scene, making)).at(0).radius == 0.009);
  CHECK(asked == std::vector<int>{2, 3});
  CHECK(said.find("taking layout 3") != std::string::npos);

  first_felt = 100;
  asked.clear();
  CHECK_THROWS_WITH(makeTask(scene, making), Catch::StartsWith("x.toml:7: none of the first 12 layouts"));
  CHECK(asked.size() == most_layouts - 1);

  scene.places["lumps.layout"] = {"x.toml", 8};  // named: that one, or none
  asked.clear();
  CHECK_THROWS_WITH(makeTask(scene, making), Catch::Contains("lump 1") && Catch::Contains("can't be felt"));
  CHECK(asked.empty());
}

TEST_CASE("A score counts each lump once, what is marked beside it, and force above the limit", "[trainer]") {
  const Model model = blockWithLump();
  TaskScore score(model, lumpsOf(model));
  const Vec3 foot = score.lumps().at(0).foot.point;
  score.mark(foot + Vec3(0.004, 0, 0), 3, 1);
  score.mark(foot - Vec3(0.004, 0, 0), 3, 2);  // the same lump again
  score.mark(foot - Vec3(0.04, 0, 0), 1, 3);
  for (int k = 0; k < 500; ++k) {
    ForceSample sample;
    sample.time_s = 0.002 * (k + 1);
    sample.tool_pose.position = foot - Vec3(0, 0, 0.004);
    sample.depth_m = 0.004;
    sample.force_raw.z() = k < 250 ? 2 : 5;
    score.add(sample);
  }
  const TaskScore::Sheet sheet = score.sheet();
  CHECK(sheet.hits == 1);
  CHECK(sheet.false_alarms == 2);
  CHECK(sheet.mean_error_mm == Approx(4).margin(0.1));
  CHECK(sheet.mean_force_N == Approx(3.5));
  CHECK(sheet.seconds_above_limit == Approx(0.5));
  CHECK(score.json("x").find("\"hits\":1") != std::string::npos);
  score.unmark();
  CHECK(score.sheet().false_alarms == 1);
}

TEST_CASE("A probe's path stays bounded over hours, from its beginning to its end, and its length exact", "[trainer]") {
  const Model model = blockWithLump();
  TaskScore score(model, lumpsOf(model));
  ForceSample sample;
  sample.force_raw = Vec3(0, 0, 1);
  constexpr int steps = 100000;
  for (int k = 0; k <= steps; ++k) {
    sample.time_s = 0.01 * k;
    sample.tool_pose.position = Vec3(0.0025 * k, 0, 0);
    score.add(sample);
  }
  CHECK(score.path().size() <= TaskScore::most_path_points);
  CHECK(score.path().size() > TaskScore::most_path_points / 4);
  CHECK(score.path().front() == Vec3(0, 0, 0));
  CHECK(score.path().back().x() == Approx(0.0025 * steps).epsilon(1e-3));
  CHECK(score.sheet().path_m == Approx(0.0025 * steps));
}
