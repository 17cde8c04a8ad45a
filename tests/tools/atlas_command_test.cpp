#include "mtled/atlas/atlas_command.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <set>

#include "mtled/atlas/atlas_block.h"
#include "mtled/atlas/atlas_page.h"
#include "mtled/atlas/atlas_run.h"
#include "mtled/report/pictures.h"
#include "setup/build_model.h"
#include "step/trust.h"
#include "support/captured_output.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::tools;
using Catch::Contains;

namespace {

AtlasMeasure ran() {
  AtlasMeasure m;
  m.nodes = 300;
  m.points = 1500;
  m.steps = 1000;
  return m;
}

AtlasMeasure compared(double deviation, double bound) {
  AtlasMeasure m = ran();
  m.compared = "force / closed form";
  m.deviation = deviation;
  m.bound = bound;
  return m;
}

/// Runs the command over cells of ours; what it prints goes to `said`.
int atlas(const AtlasOptions& options, const std::vector<AtlasCell>& cells, std::string* said = nullptr) {
  const CapturedOutput output;
  const int code =
      atlasCommand(options, {{"a", "First axis", "what is run"}, {"b", "Second axis", "what else"}}, cells);
  if (said) *said = output.said();
  return code;
}

using When = AtlasCell::When;

}  // namespace

TEST_CASE("A cell is stable, degraded, refused or silently wrong", "[atlas]") {
  CHECK(outcomeOf(ran()) == AtlasOutcome::Stable);
  CHECK(outcomeOf(compared(-0.01, 0.02)) == AtlasOutcome::Stable);
  CHECK(outcomeOf(compared(-0.03, 0.02)) == AtlasOutcome::Silent);
  CHECK(outcomeOf(compared(NAN, 0.02)) == AtlasOutcome::Silent);

  AtlasMeasure wrong = compared(0.03, 0.02);
  wrong.doubt_at = 0.1;
  wrong.doubt = "step";
  CHECK(outcomeOf(wrong) == AtlasOutcome::Silent);  // the doubt was gone when the numbers were read
  CHECK_THAT(howMuch(wrong), Contains("not doubted then"));
  wrong.doubted_then = true;
  CHECK(outcomeOf(wrong) == AtlasOutcome::Degraded);
  CHECK_THAT(howMuch(wrong), Contains("'step' from 100 ms") && Contains("+3.00 %"));

  AtlasMeasure lost = ran();
  lost.lost_at = 0.2;
  lost.loss = "blow-up";
  CHECK(outcomeOf(lost) == AtlasOutcome::Silent);
  lost.doubt_at = 0.2;
  CHECK(outcomeOf(lost) == AtlasOutcome::Silent);  // as late as the loss
  lost.doubt_at = 0.198;
  CHECK(outcomeOf(lost) == AtlasOutcome::Degraded);

  AtlasMeasure grown = ran();
  grown.growth = 2 * atlas_growth_bound;
  CHECK(outcomeOf(grown) == AtlasOutcome::Silent);
  grown.growth = NAN;
  CHECK(outcomeOf(grown) == AtlasOutcome::Silent);
  grown.doubt_at = 0.1;
  CHECK(outcomeOf(grown) == AtlasOutcome::Degraded);

  AtlasMeasure refused;
  refused.refused = "too flat";
  CHECK(outcomeOf(refused) == AtlasOutcome::Refused);
  CHECK(howMuch(refused) == "too flat");
}

TEST_CASE("An atlas comes back from its JSON as it was", "[atlas]") {
  Atlas atlas{"a build", "an identity", {{"a", "a/1", "1", compared(0.01, 0.02), 0.5}, {"a", "a/2", "2", ran(), 0.1}}};
  atlas.rows[1].measure.lost_at = 0.3;
  atlas.rows[1].measure.loss = "blow-up \"there\"";
  const Atlas back = atlasFromJson(jsonOf(atlas));
  CHECK(jsonOf(back) == jsonOf(atlas));
  CHECK(back.identity == atlas.identity);
  REQUIRE(back.rows.size() == 2);
  CHECK(std::isnan(back.rows[0].measure.lost_at));
  CHECK(back.rows[1].measure.lost_at == 0.3);
  CHECK(back.count(AtlasOutcome::Silent) == 1);
  CHECK_THROWS_WITH(atlasFromJson("{}"), Contains("atlas"));
  const std::string csv = csvOf(atlas);
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 3);
  CHECK_THAT(csv, Contains("\"blow-up \"\"there\"\"\""));
}

TEST_CASE("A cell that is silently wrong fails the atlas - one that is refused does not", "[atlas]") {
  const TempFolder folder;
  AtlasOptions options;
  options.out = folder.path("out");
  options.report = folder.path("page");
  options.json = folder.path("again.json");
  std::vector<AtlasCell> cells{
      {"a", "1", When::Always, [] { return compared(0.001, 0.02); }},
      {"a", "2", When::Always, []() -> AtlasMeasure { throw InputError({}, "too flat", "thicken it"); }}};
  std::string said;
  CHECK(atlas(options, cells, &said) == 0);
  CHECK_THAT(said, Contains("1 stable, 0 degraded, 1 refused, 0 silently wrong") && Contains("too flat; thicken it"));
  CHECK(readAll(options.json) == readAll(folder.path("out/atlas.json")));
  CHECK_THAT(readAll(folder.path("page/README.md")),
             Contains("First axis") && Contains(withoutPictures().empty() ? "](atlas.png)" : withoutPictures()) &&
                 !Contains("Second axis"));
  CHECK_THAT(
      said, Contains("picture      " + (withoutPictures().empty() ? folder.path("out/atlas.png") : withoutPictures())));
  for (const char* png : {"page/atlas.png", "out/atlas.png"})
    if (withoutPictures().empty())
      CHECK(readAll(folder.path(png)).substr(1, 3) == "PNG");
    else
      CHECK_FALSE(std::filesystem::exists(folder.path(png)));

  cells.push_back({"b", "1", When::Always, [] { return compared(0.05, 0.02); }});
  CHECK(atlas(options, cells, &said) == 1);
  CHECK_THAT(said, Contains("SILENT") && Contains("1 silently wrong"));
}

TEST_CASE("However many cells an axis has, its map is no wider than can be drawn", "[atlas]") {
  if (!withoutPictures().empty()) return;
  const TempFolder folder;
  AtlasOptions options;
  options.out = folder.path("out");
  std::vector<AtlasCell> cells;
  for (int k = 0; k < 100; ++k)
    cells.push_back({"a", "a_scene_with_a_long_name_" + std::to_string(k), When::Always, [] { return ran(); }});
  CHECK(atlas(options, cells) == 0);
  const std::string png = readAll(folder.path("out/atlas.png"));
  const auto size = [&](std::size_t at) {  // a PNG's header has them in two bytes of four
    return 256 * static_cast<unsigned char>(png[at + 2]) + static_cast<unsigned char>(png[at + 3]);
  };
  CHECK(size(16) < 4200);
  CHECK(size(20) > 700);  // several rows of 76 each
}

TEST_CASE("A resumed atlas runs only what is missing, and only of the same program", "[atlas]") {
  const TempFolder folder;
  AtlasOptions options;
  options.out = folder.path("out");
  std::atomic<int> runs = 0;  // cells are run by several threads
  const auto counted = [&] {
    ++runs;
    return ran();
  };
  // The last is begun first, whatever the number of threads.
  std::vector<AtlasCell> cells{{"a", "1", When::Always, []() -> AtlasMeasure { throw AtlasInterrupted(); }},
                               {"a", "2", When::Always, counted}};
  CHECK(atlas(options, cells) == 1);  // interrupted: what is done is kept
  CHECK(runs == 1);
  cells[0].run = counted;
  options.resume = true;
  CHECK(atlas(options, cells) == 0);
  CHECK(runs == 2);
  const Atlas whole = atlasFromJson(readAll(folder.path("out/atlas.json")));
  REQUIRE(whole.rows.size() == 2);
  CHECK(whole.rows[0].name == "a/1");  // in the map's order, not in that in which they were run
  CHECK(whole.rows[1].name == "a/2");

  Atlas other = atlasFromJson(readAll(folder.path("out/atlas.json")));
  other.identity = "another";
  folder.write("out/atlas.json", jsonOf(other));
  CHECK_THAT(refusal([&] { atlas(options, cells); }), Contains("another program"));
  folder.write("out/atlas.json", "no atlas");
  CHECK_THAT(refusal([&] { atlas(options, cells); }), Contains("no atlas"));
  options.out = folder.path("nowhere");
  CHECK_THAT(refusal([&] { atlas(options, cells); }), Contains("nothing to resume"));
  CHECK(runs == 2);
}

TEST_CASE("Cells are chosen by name, by axis and by --quick - an unknown one is refused with the names of all",
          "[atlas]") {
  const TempFolder folder;
  AtlasOptions options;
  options.out = folder.path("out");
  std::vector<AtlasCell> cells{{"a", "1", When::Always, ran},
                               {"a", "2 s", When::Quick, ran},
                               {"a", "60 s", When::Full, ran},
                               {"b", "1", When::Full, ran}};
  const auto names = [&](std::vector<std::string> asked, bool quick) {
    options.cells = std::move(asked);
    options.quick = quick;
    atlas(options, cells);
    std::set<std::string> found;
    for (const auto& r : atlasFromJson(readAll(folder.path("out/atlas.json"))).rows) found.insert(r.name);
    return found;
  };
  using Names = std::set<std::string>;
  CHECK(names({}, true) == Names{"a/1", "a/2_s"});
  CHECK(names({}, false) == Names{"a/1", "a/60_s", "b/1"});
  CHECK(names({"a"}, false) == Names{"a/1", "a/60_s"});
  CHECK(names({"b/1", "a/1"}, true) == Names{"a/1", "b/1"});

  options.cells = {"a/1", "a/3"};
  const std::string message = refusal([&] { atlas(options, cells); });
  CHECK_THAT(message, Contains("a/3"));
  for (const auto& c : cells) CHECK_THAT(message, Contains(c.name()));
}

TEST_CASE("The atlas' own cells have names of their own and axes", "[atlas]") {
  std::set<std::string> axes, names;
  for (const auto& axis : atlasAxes()) CHECK(axes.insert(axis.key).second);
  int quick = 0;
  for (const auto& cell : atlasCells()) {
    CHECK(names.insert(cell.name()).second);
    CHECK(axes.count(cell.axis) == 1);
    CHECK(cell.name().find(' ') == std::string::npos);
    quick += cell.when != AtlasCell::When::Full;
  }
  CHECK(quick > 20);
  CHECK(atlasCells().size() > 2 * static_cast<std::size_t>(quick));
}

TEST_CASE("The force of a block in closed form is Young's for small strains and the reference's for large", "[atlas]") {
  constexpr double E = 3000, nu = 0.3, area = 1e-4, strain = 1e-6;
  CHECK(blockForce(BlockFaces::Free, E, nu, 1 + strain, area) == Approx(E * strain * area).epsilon(1e-5));
  const double confined = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
  CHECK(blockForce(BlockFaces::Confined, E, nu, 1 + strain, area) == Approx(confined * strain * area).epsilon(1e-5));
  // An incompressible one: P = mu (l - 1 / l^2).
  const double mu = E / 3;
  for (const double l : {0.3, 2.0})
    CHECK(blockForce(BlockFaces::Free, E, 0.4999999, l, 1) == Approx(mu * (l - 1 / (l * l))).epsilon(1e-4));
}

TEST_CASE("A drive tells the first doubt, the loss after it, and measures only what was not lost", "[atlas]") {
  const Model model = test::blockModel();
  AtlasDrive still;
  still.seconds = 0.2;
  still.still_from = 0.1;
  const AtlasRun rest = drive(model, still);
  CHECK(outcomeOf(rest.measure) == AtlasOutcome::Stable);
  CHECK(rest.measure.steps == Approx(0.2 * model.scene.dynamics.rate_hz * model.substeps_per_tick));
  CHECK(rest.measure.growth == 0);

  const auto jolted = [&](double of_critical) {
    Model unstable = model;
    unstable.dt = of_critical * model.dt_critical;  // no scene may ask for this
    unstable.dt_critical = 2 * unstable.dt;         // nor is it known, or mass would be added
    AtlasDrive drives = still;
    drives.seconds = 2;
    drives.disturb = [](State& state) { state.du[0].z = 1e-6F; };
    return drive(unstable, drives);
  };
  // A little too long a step shakes the body as far as its points may turn, and no further.
  const AtlasRun shaken = jolted(1.1);
  CHECK_FALSE(shaken.lost());
  CHECK_FALSE(std::isnan(shaken.measure.doubt_at));

  const AtlasRun run = jolted(1.5);
  REQUIRE(run.lost());
  CHECK(run.measure.doubt_at < run.measure.lost_at);
  CHECK_FALSE(run.measure.loss.empty());
  CHECK(std::isnan(run.reaction.at(0).force.z()));
  CHECK(outcomeOf(compare(run, "force", run.reaction.at(0).force.z(), 1, 0.1)) == AtlasOutcome::Degraded);
  AtlasMeasure never_told = run.measure;
  never_told.doubt_at = NAN;
  CHECK(outcomeOf(never_told) == AtlasOutcome::Silent);
}
