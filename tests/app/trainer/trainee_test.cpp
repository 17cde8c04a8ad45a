#include "app/trainer/trainee.h"

#include "app/trainer/class_scores.h"
#include "app/trainer/feel_check.h"
#include "app/trainer/felt_layout.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/load_model.h"
#include "io/scene_lumps.h"
#include "realtime/loop/simulation_loop.h"
#include "realtime/recording/recording.h"
#include "setup/place.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::app;

namespace {

constexpr double depth = 0.006, grid = 0.013;  // m

/// A block of soft tissue of 90 x 60 x 30 mm with a lump of the first level.
Model blockWithLump() {
  Scene scene = test::blockScene(0.012);
  scene.organs[0].size = Vec3(0.09, 0.06, 0.03);
  scene.materials[0].material = Material::neoHookean(6600, 0.45, 1000);
  scene.tools[0].shape.radius = 0.008;
  addLump(Vec3(0.02, 0, 0.018), 0.009, 50e3, {}, scene);
  return buildModel(scene, boxSurface(scene.organs[0].size, 0.004));
}

TaskBody bodyOf(Model model) { return {std::make_shared<const Model>(std::move(model))}; }

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
  return score.json({.scene = "block"}, "score-pressure.csv") + score.pressureCsv();
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
  CHECK(sheet.mean_error_mm.value() < 13);
  CHECK(sheet.covered_share > 0.1);
  CHECK(sheet.peak_force_N > sheet.mean_force_N);

  const Played again = play(model, played.changes, static_cast<std::int64_t>(played.samples.size()));
  CHECK(again.hash == played.hash);
  CHECK(scored(model, again, played.marks) == scored(model, played, played.marks));
}

TEST_CASE("A lump of the first level is felt as clearly stiffer - a small deep one is not", "[trainer]") {
  const std::vector<LumpFeel> feels = feelLumps(bodyOf(blockWithLump()), depth);
  REQUIRE(feels.size() == 1);
  CHECK(feels[0].ratio() > least_feel);
  Scene scene = test::blockScene(0.012);
  scene.tools[0].shape.radius = 0.008;
  addLump(Vec3(0.01, 0, 0.012), 0.004, 20e3, {}, scene);
  const std::vector<LumpFeel> deep =
      feelLumps(bodyOf(buildModel(scene, boxSurface(scene.organs[0].size, 0.004))), depth);
  CHECK(deep[0].ratio() < least_feel);
  // What fine nodes say is expected to hold, what coarse ones say near the limit is not.
  CHECK(deep[0].error > 0.01);
  const LumpFeel coarse{1.3, 1, 0.05}, fine{1.3, 1, 0.03};
  CHECK_FALSE(coarse.isSure());
  CHECK(fine.isSure());
}

TEST_CASE("A lump outside of the organ is told, not taken for a deep one", "[trainer]") {
  Scene scene = test::blockScene(0.012);
  const double top = scene.organs[0].size.z();
  addLump(Vec3(0, 0, top + 0.01), 0.004, 20e3, {"x.toml", 7}, scene);
  const Model model = buildModel(scene, boxSurface(scene.organs[0].size, 0.004));
  CHECK(misplaced(lumpsOf(model).at(0)) == "is 10.0 mm outside of the organ");
  const std::optional<Unfelt> outside = outsideLump(model);
  REQUIRE(outside);
  CHECK(outside->place.line == 7);
  Lump lump = lumpsOf(model)[0];
  lump.top = -0.002;
  CHECK(misplaced(lump) == "reaches 2.0 mm out of the skin");
  lump.top = 0.002;
  CHECK(misplaced(lump).empty());
}

TEST_CASE("Where the cloud follows the tool, a lump far from its start is felt as on nodes that are dense everywhere",
          "[trainer][place][whole]") {
  Scene scene = test::barScene();
  addLump(Vec3(0.05, 0, 0.018), 0.009, 50e3, {}, scene);
  const Places places = makePlaces(scene, test::barSurface());
  int made = 0;
  TaskBody body = bodyOf(makePlace(places, startPlace(places)).model);
  const double coarse = feelLumps(body, depth).at(0).above_N_per_m;
  body.near = [&](const Vec3& point) {
    ++made;
    return std::make_shared<const Model>(makePlace(places, placeAt(places, point)).model);
  };
  const LumpFeel feel = feelLumps(body, depth).at(0);
  CHECK(made == 2);
  Scene fine = scene;
  fine.discretization.spacing = places.sizes.fine;
  fine.discretization.refine.clear();
  const LumpFeel dense = feelLumps(bodyOf(buildModel(fine, test::barSurface())), depth).at(0);
  INFO(feel.above_N_per_m << " and " << feel.beside_N_per_m << " N/m, dense " << dense.above_N_per_m << " and "
                          << dense.beside_N_per_m << ", coarse " << coarse);
  CHECK(feel.above_N_per_m == Approx(dense.above_N_per_m).epsilon(0.03));
  CHECK(feel.beside_N_per_m == Approx(dense.beside_N_per_m).epsilon(0.03));
  CHECK(std::abs(coarse / dense.above_N_per_m - 1) > 0.03);
}

TEST_CASE("A layout that can't be felt is refused with its lump, and what was felt is kept", "[trainer]") {
  Scene scene = test::blockScene(0.012);
  scene.tools[0].shape.radius = 0.008;
  addLump(Vec3(0.01, 0, 0.012), 0.004, 20e3, {"x.toml", 7}, scene);
  const TaskBody body = bodyOf(buildModel(scene, boxSurface(scene.organs[0].size, 0.004)));
  const TempFolder folder;
  const auto feel = [&] { requireFelt(body, folder.path("cache")); };
  const std::string first = refusal(feel);
  CHECK(first.starts_with("x.toml:7: lump 1 (8 mm across, "));
  CHECK(first.find("can't be felt") != std::string::npos);
  CHECK(refusal(feel) == first);
  // Only what was kept can say that it is felt now.
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path("cache"))) {
    std::ofstream(entry.path()) << "2.5\n";
    ++files;
  }
  CHECK(files == 1);
  CHECK_NOTHROW(feel());
}

TEST_CASE("Of lumps at random the first layout in which all can be felt is taken, of a dozen", "[trainer][whole]") {
  Scene scene = test::blockScene(0.012);
  scene.tools[0].shape.radius = 0.008;
  scene.places["lumps.count"] = scene.place = {"x.toml", 7};
  Scene hidden = scene;
  addLump(Vec3(0.01, 0, 0.012), 0.004, 20e3, {"x.toml", 7}, hidden);
  const TaskBody unfelt = bodyOf(buildModel(hidden, boxSurface(scene.organs[0].size, 0.004))),
                 felt = bodyOf(blockWithLump());
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
  CHECK(lumpsOf(*makeTask(scene, making).model).at(0).radius == 0.009);
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
  CHECK(sheet.mean_error_mm.value() == Approx(4).margin(0.1));
  CHECK(sheet.mean_force_N == Approx(3.5));
  CHECK(sheet.seconds_above_limit == Approx(0.5));
  score.unmark();
  CHECK(score.sheet().false_alarms == 1);
}

TEST_CASE("A mark's hardness is judged by how much stiffer the lump is: three times, ten times", "[trainer]") {
  for (const auto& [times, hardness] : {std::pair{2.9, 1}, {3.1, 2}, {9.9, 2}, {10.1, 3}}) {
    Lump lump;
    lump.stiffness = times;
    CHECK(hardnessOf(lump) == hardness);
  }
  const Model model = blockWithLump();
  for (int told = 1; told <= 3; ++told) {
    TaskScore score(model, lumpsOf(model));
    REQUIRE(hardnessOf(score.lumps().at(0)) == 2);  // 50 kPa in 6.6
    score.mark(score.lumps()[0].foot.point, told, 1);
    score.mark(Vec3(-0.03, 0.02, 0.03), 2, 1);  // beside it, where there is nothing to judge
    CHECK(score.sheet().hardness_right == (told == 2 ? 1 : 0));
  }
}

TEST_CASE("A sheet says who, where and under which conditions, and what is not known is null", "[trainer]") {
  using Json = nlohmann::json;
  const Model model = blockWithLump();
  TaskScore score(model, lumpsOf(model));
  SheetHead head{.scene = "block", .trainee = "Ann \"A\" M\xFC", .date = "2025-03-01 14:05", .scene_hash = "0123"};
  head.conditions.probe = "sphere, radius 8 mm";
  Json json = Json::parse(score.json(head, "score-1-pressure.csv"));
  CHECK(json["trainee"].get<std::string>().starts_with("Ann \"A\" M"));  // the byte that is no UTF-8 is no fault
  CHECK(json["date"] == "2025-03-01 14:05");
  CHECK(json["scene_hash"] == "0123");
  CHECK(json["seed"].is_null());
  CHECK(json["mean_error_mm"].is_null());
  CHECK(json["conditions"]["moved_by"] == "hand");
  CHECK(json["conditions"]["probe"] == "sphere, radius 8 mm");
  CHECK(json["conditions"]["inside_shown"] == false);
  CHECK(json["lumps"][0]["hardness"] == 2);
  CHECK(json["pressure_file"] == "score-1-pressure.csv");
  CHECK_FALSE(json.contains("peak_pressure_Pa"));
  const std::string pressures = score.pressureCsv();
  CHECK(pressures.starts_with("x_mm,y_mm,z_mm,peak_pressure_Pa\n"));
  CHECK(static_cast<std::size_t>(std::count(pressures.begin(), pressures.end(), '\n')) ==
        1 + model.skin.surface.vertices.size());
  head.lump_draw = LumpDraw{1, 42, 2};
  json = Json::parse(score.json(head, ""));
  CHECK(json["seed"] == 42);
  CHECK(json["layout"] == 2);
  CHECK(head.conditions.asTheSceneHasThem());
  head.conditions.changes = {"1.000 s: friction is now 0.3"};
  CHECK_FALSE(head.conditions.asTheSceneHasThem());
  CHECK(head.conditions.text().find("friction is now 0.3") != std::string::npos);
}

TEST_CASE("The sheets of a class become one table, other files are left alone, and a broken sheet is told",
          "[trainer]") {
  const Model model = blockWithLump();
  TaskScore score(model, lumpsOf(model));
  const TempFolder folder;
  std::filesystem::create_directories(folder.path("b/deep"));
  SheetHead head{.scene = "block", .trainee = "Bo, \"B\""};
  head.conditions.changes = {"a", "b"};
  folder.write("b/deep/bo.json", score.json(head, ""));
  score.mark(score.lumps().at(0).foot.point, 2, 1);
  folder.write("score-1.json", score.json({.scene = "block", .trainee = "=1+Ann"}, ""));
  folder.write("report.json", "{\"peak_force_N\": 1}");
  folder.write("broken.json", "{");
  const ClassScores scores = classScores(folder.path(""));
  CHECK(scores.sheets == 2);
  CHECK(scores.problems.empty());
  std::istringstream lines(scores.csv);
  std::string header, bo, ann, rest;
  std::getline(lines, header);
  std::getline(lines, bo);
  std::getline(lines, ann);
  CHECK_FALSE(std::getline(lines, rest));
  CHECK(header.starts_with("file,trainee,date,scene,scene_hash,"));
  CHECK(std::count(header.begin(), header.end(), ',') == std::count(ann.begin(), ann.end(), ','));
  CHECK(bo.starts_with("\"b/deep/bo.json\",\"Bo, \"\"B\"\"\",\"\",\"block\","));
  CHECK(bo.find(",0,1,0,0,,0.0,") != std::string::npos);  // no hit, hence no error
  CHECK(bo.ends_with(",2,0,0,0"));
  CHECK(ann.find(",1,0,0,1,0.0,0.0,") != std::string::npos);
  CHECK(ann.find(",\"'=1+Ann\",") != std::string::npos);  // or a spreadsheet would compute it

  folder.write("score-2.json", "{\"hits\": 1,");  // cut off
  const ClassScores worse = classScores(folder.path(""));
  CHECK(worse.sheets == 2);
  REQUIRE(worse.problems.size() == 1);
  CHECK_THAT(worse.problems[0], Catch::Contains("score-2.json") && Catch::Contains("damaged or cut short"));
  auto altered = nlohmann::json::parse(score.json({.scene = "block"}, ""));
  altered["conditions"] = nullptr;
  folder.write("score-2.json", altered.dump());
  CHECK_THAT(classScores(folder.path("")).problems.at(0), Catch::Contains("\"conditions\" is not in it"));
  altered = nlohmann::json::parse(score.json({.scene = "block"}, ""));
  altered["hits"] = "7";
  folder.write("score-2.json", altered.dump());
  CHECK_THAT(classScores(folder.path("")).problems.at(0), Catch::Contains("\"hits\" is no whole number"));
  CHECK_THAT(refusal([&] { classScores(folder.path("absent")); }), Catch::Contains("absent"));
}

TEST_CASE("The way on the skin ends where the probe lifts off and begins where it comes down", "[trainer]") {
  const Model model = blockWithLump();
  TaskScore score(model, lumpsOf(model));
  ForceSample sample;
  const auto add = [&](double x, double force) {
    sample.time_s += 0.002;
    sample.tool_pose.position = Vec3(x, 0, 0.03);
    sample.force_raw = Vec3(0, 0, force);
    score.add(sample);
  };
  for (int k = 0; k <= 10; ++k) add(0.0025 * k, 1);           // 25 mm on the skin,
  for (int k = 0; k <= 10; ++k) add(0.025 - 0.004 * k, 0);    // 40 mm back through the air,
  for (int k = 0; k <= 10; ++k) add(-0.015 + 0.0025 * k, 1);  // 25 mm again
  CHECK(score.sheet().path_m == Approx(0.05));
  const auto ways = [&] {
    return std::count_if(score.path().begin(), score.path().end(), [](const auto& point) { return point.begins; });
  };
  CHECK(ways() == 2);
  // A probe that trembles on the skin has not lifted off: 20 mm.
  for (int k = 0; k < 40; ++k) add(0.01 + 0.0005 * (k + 1), k % 3 == 1 ? 0 : 1);
  CHECK(ways() == 2);
  CHECK(score.sheet().path_m == Approx(0.07).margin(TaskScore::path_step));
  // Put elsewhere in the midst of a press, as by Undo.
  score.breakPath();
  add(-0.02, 1);
  CHECK(ways() == 3);
  CHECK(score.sheet().path_m == Approx(0.07).margin(TaskScore::path_step));
  const nlohmann::json json = nlohmann::json::parse(score.json({}, ""));
  CHECK(json["path_mm"].size() == 3);
  CHECK(json["path_mm"][2].size() == 1);
}

TEST_CASE("A probe's path stays bounded over hours, from its beginning to its end, and its length exact",
          "[trainer][whole]") {
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
  CHECK(score.path().front().tip == Vec3(0, 0, 0));
  CHECK(score.path().back().tip.x() == Approx(0.0025 * steps).epsilon(1e-3));
  CHECK(score.sheet().path_m == Approx(0.0025 * steps));
}
