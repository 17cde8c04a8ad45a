#include "mtled/identify/identify_regions.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "base/number_text.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "mtled/identify/pressed_regions.h"
#include "support/block_text.h"
#include "support/captured_output.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::tools;
using Catch::Contains;

namespace {

const std::vector<double> truth = {2400, 3900, 3100, 5200};  // Pa

const std::vector<double> start = {3000, 3000, 3000, 3000};  // Pa

/// The block in four quarters under a tool without friction.
std::string quarters(const std::vector<double>& young = start) {
  const auto quarter = [](const char* name, double modulus, const char* low, const char* high) {
    return format(
        "[[material]]\nname = \"%s\"\nmodel = \"neo-hookean\"\nyoung = %g\npoisson = 0.45\n"
        "region = { shape = \"box\", min = [%s, -1], max = [%s, 1] }\n",
        name, modulus, low, high);
  };
  const std::string text = replaced(test::touched_block_text, "young = 3000", format("young = %g", young[0]));
  return replaced(text, "[[fixed]]",
                  quarter("right", young[1], "0, -1", "1, 0") + quarter("back", young[2], "-1, 0", "0, 1") +
                      quarter("back right", young[3], "0, 0", "1, 1") + "[[fixed]]") +
         "friction = 0\n";
}

std::vector<SettledPress> places() {
  std::vector<SettledPress> presses;
  for (const double x : {-0.018, -0.006, 0.006, 0.018})
    for (const double y : {-0.015, 0.0, 0.015}) presses.push_back({Vec3(x, y, 0.0275), 0});
  return presses;
}

const std::vector<MaterialNumber> youngs = {{0, "young"}, {1, "young"}, {2, "young"}, {3, "young"}};

/// The presses as a table, their forces with noise. @param noise  N
std::string tableOf(std::vector<double> forces, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> scatter(0, noise > 0 ? noise : 1);
  std::string text = "x_mm,y_mm,z_mm,force_mN\n";
  const std::vector<SettledPress> presses = places();
  for (std::size_t k = 0; k < presses.size(); ++k) {
    const Vec3 x = 1e3 * presses[k].tip;
    if (noise > 0) forces[k] += scatter(random);
    text += format("%.17g,%.17g,%.17g,%.17g\n", x.x(), x.y(), x.z(), 1e3 * forces[k]);
  }
  return text;
}

struct Outcome {
  int code = 0;
  std::string said;
  nlohmann::json report;
};

Outcome outcome(const TempFolder& folder, const std::string& scene, const std::string& table, int threads = 1) {
  const CapturedOutput captured;
  IdentifyOptions options;
  options.scene = scene;
  options.regions = true;
  options.measured = folder.write("presses.csv", table);
  options.threads = threads;
  options.out = folder.path("out");
  Outcome outcome;
  outcome.code = identifyCommand(options);
  outcome.said = captured.said();
  outcome.report = nlohmann::json::parse(readAll(folder.path("out/identify.json")));
  return outcome;
}

}  // namespace

TEST_CASE("Derivatives of all presses are central differences of their forces", "[identify][regions]") {
  const TempFolder folder;
  const Model model = loadModel(readScene(folder.write("quarters.toml", quarters())));
  PressedRegions regions(model, {places()[4], places()[9]}, youngs, 2);
  regions.forces(truth);
  const std::vector<std::vector<double>> slopes = regions.derivatives();
  REQUIRE(slopes.size() == 2);
  for (std::size_t m = 0; m < truth.size(); ++m) {
    std::vector<double> less = truth, more = truth;
    less[m] *= 0.99, more[m] *= 1.01;
    const std::vector<double> low = regions.forces(less), high = regions.forces(more);
    for (std::size_t k = 0; k < 2; ++k) {
      const double largest = std::abs(slopes[k][0]) * truth[0] + std::abs(slopes[k][3]) * truth[3];
      CHECK(std::abs(slopes[k][m] * truth[m] - (high[k] - low[k]) / 0.02) < 1e-3 * largest);
    }
  }
}

TEST_CASE("A map of stiffness is found from presses at many places, with intervals that hold the truth",
          "[identify][regions][whole]") {
  const TempFolder folder;
  const std::string scene = folder.write("quarters.toml", quarters());
  const Model model = loadModel(readScene(folder.write("truth.toml", quarters(truth))));  // nor is its set-up known
  PressedRegions regions(model, places(), youngs, 2);
  const std::vector<double> forces = regions.forces(truth);
  const std::vector<std::string> names = {"material 1", "right", "back", "back right"};

  const Outcome exact = outcome(folder, scene, tableOf(forces, 0, 0));
  INFO(exact.said);
  for (std::size_t m = 0; m < names.size(); ++m)
    CHECK(exact.report["regions"][names[m]]["value"].get<double>() == Approx(truth[m]).epsilon(1e-3));
  // An iteration is an equilibrium of each press (two or three linear solutions) and one more for its derivatives.
  const int maps = exact.report["maps_solved"], presses = static_cast<int>(places().size());
  CHECK(maps < 11);  // of two set-ups
  CHECK(exact.report["linear_solutions"].get<int>() < 5 * maps * presses);

  int held = 0;
  double width = 0, error = 0;
  constexpr int seeds = 5;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const Outcome noisy = outcome(folder, scene, tableOf(forces, 5e-4, seed));
    CHECK(noisy.report["converged"]);
    for (std::size_t m = 0; m < names.size(); ++m) {
      const nlohmann::json& found = noisy.report["regions"][names[m]];
      const double low = found["noise_low_95"], high = found["noise_high_95"], value = found["value"];
      held += low < truth[m] && truth[m] < high;
      CHECK((found["low_95"] < low && high < found["high_95"]));  // the cloud's own error, too
      width += std::pow(std::log(high / low) / 2, 2);
      error += std::pow(std::log(value / truth[m]), 2);
    }
  }
  // Of 20 intervals of 95 %: 17 or more with 98 % certainty. Half an interval is 2.3 standard errors for eight degrees
  // of freedom, and the larger of several estimates of them.
  CHECK(held >= 17);
  CHECK(std::sqrt(width / error) > 1.5);
  CHECK(std::sqrt(width / error) < 5);
}

TEST_CASE("The map does not depend on the number of threads", "[identify][regions][whole]") {
  const TempFolder folder;
  const Model model = loadModel(readScene(folder.write("quarters.toml", quarters())));
  const std::vector<SettledPress> some = {places()[1], places()[4], places()[11]};
  PressedRegions one(model, some, youngs, 1), three(model, some, youngs, 3);
  CHECK(one.forces(truth) == three.forces(truth));
  CHECK(one.derivatives() == three.derivatives());
}

TEST_CASE("Presses that can't be used are refused with their place", "[identify][regions][whole]") {
  const TempFolder folder;
  const std::string scene = folder.write("quarters.toml", quarters());
  const auto refused = [&](const std::string& table, const std::string& of = "") {
    return refusal([&] { outcome(folder, of.empty() ? scene : of, table); });
  };
  const std::string header = "x_m,y_m,z_m,force_N\n", press = "0,0,0.0275,0.1\n";
  CHECK_THAT(refused("x_m,y_m,force_N\n0,0,1\n"), Contains("presses.csv:1") && Contains("z_m"));
  CHECK_THAT(refused(header + press + "0,0,,0.1\n"), Contains("presses.csv:3") && Contains("is missing"));
  CHECK_THAT(refused(header + press + press), Contains("2 presses for 4 materials"));
  const std::string far = "0,0,27.5,0.1\n";
  CHECK_THAT(refused(header + far + far + far + far + far), Contains("no press touches"));
  CHECK_THAT(refused(header + press + press + press + press + "0,0,0.06,0.1\n"),
             Contains("presses.csv:6: a press with a force of 0.1 N touches nothing"));
  CHECK_THAT(refused("x_m,x_mm,y_m,z_m,force_N\n0,0,0,0.0275,0.1\n"), Contains("columns x_m and x_mm for the same"));
  CHECK_THAT(refused(tableOf(std::vector<double>(12, -0.1), 0, 0)), Contains("no press has a force above 0"));
  CHECK_THAT(refused(tableOf(std::vector<double>(12, 100), 0, 0)), Contains("force_mN for millinewtons"));
  const std::string rough = folder.write("rough.toml", replaced(quarters(), "friction = 0", "friction = 0.3"));
  CHECK_THAT(refused(tableOf(std::vector<double>(12, 0.1), 0, 0), rough), Contains("without friction"));
  IdentifyOptions options;
  options.scene = scene, options.measured = folder.write("p.csv", header + press), options.regions = true;
  options.parameters = {"yuong"};
  CHECK_THAT(refusal([&] { identifyCommand(options); }), Contains("has no number \"yuong\""));
  options.parameters = {"young", "poisson"};
  CHECK_THAT(refusal([&] { identifyCommand(options); }), Contains("one parameter of each material"));
}
