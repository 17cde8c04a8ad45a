#include "app/run/run_checks.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "app/run/picture_choice.h"
#include "base/input_error.h"
#include "realtime/recording/run_report.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::app;
using Catch::Contains;

namespace {

std::string blank() { return toJson(RunReport()); }

Picture grey(int width, int height, std::uint8_t value) {
  return {width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(3 * width * height), value)};
}

}  // namespace

TEST_CASE("A report is held to a baseline: equal where exact, near where there is a tolerance", "[run_checks]") {
  const TempFolder folder;
  folder.write("baseline.json", R"({"nodes": 10, "state_hash": "00ff", "peak_force_N": {"value": 2, "rel": 0.01},
                                    "min_J": {"value": 0.5, "abs": 0.1}})");
  const Baseline baseline(folder.path("baseline.json"), blank());
  CHECK(baseline.differences(R"({"nodes": 10, "state_hash": "00ff", "peak_force_N": 2.01, "min_J": 0.45, "more": 1})")
            .empty());
  const std::vector<std::string> lines =
      baseline.differences(R"({"nodes": 11, "state_hash": "00ff", "peak_force_N": 2.03})");
  REQUIRE(lines.size() == 3);
  CHECK(lines[0] == "nodes is 11, not 10");
  CHECK(lines[1].find("peak_force_N is 2.03, not 2") == 0);
  CHECK(lines[2].find("no \"min_J\"") != std::string::npos);
}

TEST_CASE("A baseline that says nothing clear is refused before the run", "[run_checks]") {
  const TempFolder folder;
  for (const char* text : {"[1, 2]", "{}", "{\"nodes\": }", R"({"min_J": 0.5})", R"({"min_J": {"value": 1}})",
                           R"({"min_J": {"value": 1, "abs": -1}})", R"({"min_J": {"value": 1, "rel": 1, "abss": 2}})",
                           R"({"min_J": {"value": 1, "rel": "a lot"}})"}) {
    CAPTURE(text);
    folder.write("b.json", text);
    CHECK_THROWS_AS(Baseline(folder.path("b.json"), blank()), InputError);
  }
  CHECK_THROWS_AS(Baseline(folder.path("none.json"), blank()), InputError);
}

TEST_CASE("A baseline's key that the run's report won't have is told before the run, with its line", "[run_checks]") {
  const TempFolder folder;
  const auto read = [&](const std::string& line, const RunReport& report = {}) {
    return Baseline(folder.write("b.json", "{\"nodes\": 10,\n " + line + "}\n"), toJson(report));
  };
  const auto problem = [&](const std::string& line) { return refusal([&] { read(line); }); };
  CHECK_THAT(problem(R"("peak_force": {"value": 1, "rel": 0.1})"),
             Contains("b.json:2: ") && Contains("no \"peak_force\"; did you mean \"peak_force_N\"?"));
  CHECK_THAT(problem(R"("zzz": 1)"), Contains("it has scene, nodes"));
  CHECK_THAT(problem(R"("trust": 1)"), Contains("\"trust\" is a text"));
  CHECK_THAT(problem(R"("min_J": "low")"), Contains("\"min_J\" is a number"));
  CHECK_THAT(problem(R"("flags": "none")"), Contains("a list"));
  CHECK_NOTHROW(read(R"("first_doubt_s": {"value": 1, "abs": 0.1})"));
  CHECK(read(R"("first_doubt_s": null)").differences(R"({"nodes": 10, "first_doubt_s": null})").empty());
  CHECK(read(R"("first_doubt_s": null)").differences(R"({"nodes": 10, "first_doubt_s": 0.5})").size() == 1);
  const std::string skull = R"("skull_penetration_m": {"value": 0, "abs": 1e-4})";
  CHECK_THAT(problem(skull), Contains("will have no \"skull_penetration_m\""));
  RunReport with_skull;
  with_skull.rigid.push_back({"skull", Vec3::Zero(), 0, {}});
  CHECK_NOTHROW(read(skull, with_skull));
}

TEST_CASE("Two pictures are compared as an eye would", "[run_checks]") {
  CHECK(pictureDifference(grey(40, 30, 100), grey(40, 30, 100), 0.5, "").empty());
  CHECK(pictureDifference(grey(40, 30, 100), grey(40, 30, 101), 0.5, "").empty());
  CHECK(pictureDifference(grey(40, 30, 100), grey(40, 30, 110), 0.5, "").find("mean delta E") != std::string::npos);
  CHECK(pictureDifference(grey(40, 30, 100), grey(40, 30, 110), 20, "").empty());
  CHECK(pictureDifference(grey(40, 30, 100), grey(41, 30, 100), 0.5, "").find("pixels") != std::string::npos);

  // Which of the two limits was missed: a small spot is far below the mean's.
  Picture spot = grey(100, 60, 100);
  for (int y = 20; y < 25; ++y)
    for (int x = 30; x < 35; ++x)
      for (int k = 0; k < 3; ++k) spot.rgb[static_cast<std::size_t>(3 * (100 * y + x) + k)] = 255;
  CHECK_THAT(pictureDifference(grey(100, 60, 100), spot, 0.5, ""),
             Contains("within the 0.5 of --tolerance") && Contains("more than the 0.2 % that go with it"));
  CHECK_THAT(pictureDifference(grey(40, 30, 100), grey(40, 30, 104), 0.5, ""),
             Contains("more than the 0.5 of --tolerance") && Contains("within the 0.2 %"));
}

TEST_CASE("The picture's options reach the view", "[run_checks]") {
  PictureChoice choice;
  choice.show = "nodes,contact";
  choice.hide = "fixed";
  REQUIRE(readPictureChoice("-30,40,0.3", "", "von_mises", "0:2000", choice).empty());
  View view;
  applyChoice(choice, view);
  CHECK(view.camera.azimuth_deg == -30);
  CHECK(view.camera.elevation_deg == 40);
  CHECK(view.camera.distance == 0.3);
  CHECK(view.colour_map == ColourMap::VonMises);
  CHECK_FALSE(view.colour_auto);
  CHECK(view.colour_max == 2000);
  CHECK(view.show_nodes);
  CHECK(view.show_contact);
  CHECK_FALSE(view.show_fixed);
  CHECK(view.show_tool);
}
