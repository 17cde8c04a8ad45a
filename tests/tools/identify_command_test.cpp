#include "mtled/identify/identify_command.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "io/load_model.h"
#include "io/scene_file.h"
#include "mtled/identify/coarse_to_fine.h"
#include "mtled/identify/force_curve.h"
#include "mtled/identify/identify.h"
#include "mtled/identify/identify_remarks.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/block_text.h"
#include "support/captured_output.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::tools;
using Catch::Contains;

namespace {

constexpr double press_seconds = 0.3;

/// Forces of the block with other parameters, with 1 % noise. @param deepest  m
std::string measured(const TempFolder& folder, const std::string& scene, const std::vector<SceneChange>& truth,
                     double deepest = 0.004) {
  const ForceCurve curve = simulateForceCurve(loadModel(readScene(scene, truth)), {deepest, press_seconds});
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.01);
  std::string text = "depth_m,force_N,trust\n-0.001,0,good\n";
  for (std::size_t k = 9; k < curve.depth.size(); k += 10)
    text += std::to_string(curve.depth[k]) + "," + std::to_string(curve.force[k] * (1 + noise(random))) + ",good\n";
  return folder.write("force.csv", text);
}

/// What the command does with a scene and a curve.
struct Outcome {
  int code = 0;
  std::string said;
  nlohmann::json report;
};
Outcome outcome(const TempFolder& folder, const std::string& scene, const std::string& curve,
                const std::vector<std::string>& parameters = {}, double seconds = press_seconds) {
  const CapturedOutput captured;
  IdentifyOptions options;
  options.scene = scene;
  options.measured = curve;
  options.parameters = parameters;
  options.seconds = seconds;
  options.out = folder.path("out");
  Outcome outcome;
  outcome.code = identifyCommand(options);
  outcome.said = captured.said();
  outcome.report = nlohmann::json::parse(readAll(folder.path("out/identify.json")));
  return outcome;
}

nlohmann::json found(const TempFolder& folder, const std::string& scene, const std::string& curve,
                     const std::vector<std::string>& parameters) {
  const Outcome result = outcome(folder, scene, curve, parameters);
  INFO(result.said);
  const nlohmann::json doubts = result.report.at("doubts");
  CHECK(result.code == (doubts.empty() ? 0 : 3));
  // The block's cloud is coarse for shallow presses; what made the curve had the same.
  for (const nlohmann::json& doubt : doubts)
    CHECK_THAT(doubt.get<std::string>(), Contains("the scene's cloud puts its force off by some"));
  return result.report;
}

/// A curve with as many rows as depths, in a file.
std::string written(const TempFolder& folder, const std::string& header, const std::function<double(double)>& force) {
  std::string text = header + "\n";
  for (int k = 1; k <= 20; ++k) text += std::to_string(0.0002 * k) + "," + std::to_string(force(0.0002 * k)) + "\n";
  return folder.write("curve.csv", text);
}

/// Names, units and places of an Ogden material of one term in the block.
std::string ogdenBlock() {
  return replaced(replaced(test::touched_block_text, "0.012", "0.02"),
                  "model = \"neo-hookean\"\nyoung = 3000\npoisson = 0.45",
                  "model = \"ogden\"\nmu = [1000]\nalpha = [-4]\nD1 = 2e-4");
}

}  // namespace

TEST_CASE("On a linear problem the identification is the normal equations' solution, intervals included",
          "[identify]") {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.1);
  Eigen::MatrixXd A(30, 2);
  Eigen::VectorXd y(30);
  for (int k = 0; k < 30; ++k) {
    A.row(k) << k / 10.0, 1;
    y[k] = 3 * k / 10.0 - 2 + noise(random);
  }
  const Identified result = identify({{"slope", {}, 0}, {"offset", {}, 0}}, [&](const std::vector<double>& p) {
    const Eigen::VectorXd r = A * Eigen::Vector2d(p[0], p[1]) - y;
    return std::vector<double>(r.begin(), r.end());
  });
  CHECK(result.converged);
  CHECK(result.told_apart);
  const Eigen::Vector2d best = (A.transpose() * A).inverse() * A.transpose() * y;
  const double variance = (A * best - y).squaredNorm() / 28;
  const Eigen::Matrix2d covariance = variance * (A.transpose() * A).inverse();
  for (std::size_t k = 0; k < 2; ++k) {
    const auto e = static_cast<Eigen::Index>(k);
    CHECK(result.value[k] == Approx(best[e]).epsilon(1e-4));
    // Student's t for 28 is 2.0484; noise that happens to be uneven or to follow itself can only widen it.
    const double plain = 2 * 2.0484 * std::sqrt(covariance(e, e));
    CHECK(result.high[k] - result.low[k] > 0.998 * plain);
    CHECK(result.high[k] - result.low[k] < 1.6 * plain);
  }

  const Identified twins = identify({{"a", above(0), 1}, {"b", above(0), 1}}, [&](const std::vector<double>& p) {
    std::vector<double> r;
    for (int k = 0; k < 30; ++k) r.push_back(p[0] * p[1] * k - 6.0 * k);
    return r;
  });
  CHECK_FALSE(twins.told_apart);
  CHECK(twins.value[0] * twins.value[1] == Approx(6).epsilon(1e-3));
}

TEST_CASE("What the shape of a curve tells is no surer than forces whose error falls with the contact", "[identify]") {
  // Hertz, and a parameter that bends the curve. The simulation has an error of 3 % at the deepest row and more above.
  constexpr double share = 0.03, stiffness = 2, bend = 0.4;
  std::vector<double> depth, measured;
  for (int k = 1; k <= 30; ++k) depth.push_back(k / 30.0);
  const auto force = [](double a, double b, double d) { return a * std::pow(d, 1.5) * (1 + b * d); };
  for (const double d : depth) measured.push_back(force(stiffness, bend, d));
  const std::vector<SoughtParameter> sought = {{"stiffness", {0, INFINITY}, 1}, {"bend", {0, INFINITY}, 1}};
  const auto identified = [&] {
    return identify(sought, [&](const std::vector<double>& p) {
      std::vector<double> r;
      for (std::size_t k = 0; k < depth.size(); ++k) {
        const double right = force(p[0], p[1], depth[k]);
        r.push_back(right * (1 + share * std::cbrt(measured.back() / measured[k])) - measured[k]);
      }
      return r;
    });
  };
  const auto holds = [](const Identified& found, std::size_t k, double value) {
    return found.low[k] <= value && value <= found.high[k];
  };
  Identified evenly = identified(), along = evenly;
  widenForError(share, measured, sought, evenly);
  widenForErrorAlong(share, measured, sought, along);
  CHECK_FALSE(holds(evenly, 1, bend));
  CHECK(holds(along, 0, stiffness));
  CHECK(holds(along, 1, bend));
  CHECK(along.high[1] - along.low[1] < 0.5);
}

TEST_CASE("The 95 % interval of each of two parameters holds the truth that often, for noise of other kinds too",
          "[identify]") {
  // A curve a d + b d^2 with 1 % of noise that grows with the force, or that follows itself from row to row.
  const double alike = GENERATE(0.0, 0.6);
  constexpr int rows = 80, trials = 200;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.01);
  int held = 0, narrow = 0;
  for (int t = 0; t < trials; ++t) {
    std::vector<double> depth, force;
    double e = noise(random);
    for (int k = 1; k <= rows; ++k) {
      e = alike * e + std::sqrt(1 - alike * alike) * noise(random);
      depth.push_back(static_cast<double>(k) / rows);
      force.push_back((depth.back() + 0.5 * depth.back() * depth.back()) * (1 + e));
    }
    const Identified result = identify({{"a", above(0), 0.7}, {"b", above(0), 0.7}}, [&](const std::vector<double>& p) {
      std::vector<double> r;
      for (std::size_t k = 0; k < depth.size(); ++k)
        r.push_back(p[0] * depth[k] + p[1] * depth[k] * depth[k] - force[k]);
      return r;
    });
    held += result.low[0] <= 1 && 1 <= result.high[0];
    held += result.low[1] <= 0.5 && 0.5 <= result.high[1];
    narrow += result.high[1] - result.low[1] < 0.25;
  }
  INFO(held << " of " << 2 * trials);
  CHECK(held > (alike > 0 ? 0.8 : 0.9) * 2 * trials);  // without regard to it: two thirds; 80 rows tell little of it
  CHECK(narrow > 0.9 * trials);
}

TEST_CASE("Held-out parameters come back from a noisy force curve", "[identify][whole]") {
  const TempFolder folder;
  const std::string scene = folder.write("block.toml", replaced(test::touched_block_text, "0.012", "0.02"));
  const std::string curve = measured(folder, scene, {{"material[0].young", "4321"}});
  const nlohmann::json one = found(folder, scene, curve, {});
  const auto& young = one["parameters"]["young"];
  CHECK(young["value"].get<double>() == Approx(4321).epsilon(0.02));
  CHECK(young["low_95"] < young["value"]);
  CHECK(young["high_95"] > young["value"]);
  CHECK(young["noise_high_95"].get<double>() - young["noise_low_95"].get<double>() < 0.04 * 4321);
  // The block's cloud is as coarse as the ball: whoever has a real curve does not know more than that.
  CHECK(one["expected_force_error"] > 0.1);
  CHECK(young["high_95"].get<double>() > (1 + one["expected_force_error"].get<double>()) * 4321);
  CHECK(one["misfit_of_largest_force"] < 0.02);
}

TEST_CASE("The shear modulus of an Ogden term is identified by its scene key", "[identify][whole]") {
  const TempFolder folder;
  const std::string scene = folder.write("block.toml", ogdenBlock());
  const std::string curve = measured(folder, scene, {{"material[0].mu", "[1500]"}}, 0.006);
  const auto mu = found(folder, scene, curve, {"mu"})["parameters"]["mu"];
  CHECK(mu["low_95"] < 1500);
  CHECK(mu["high_95"] > 1500);
  CHECK(mu["value"].get<double>() == Approx(1500).epsilon(0.01));
  const auto alpha = outcome(folder, scene, curve, {"alpha"}).report["parameters"]["alpha"];
  CHECK(alpha["value"].get<double>() < 0);  // keeps the scene's sign
  CHECK_THAT(refusal([&] { outcome(folder, scene, curve, {"young"}); }),
             Contains("Ogden has no parameter \"young\"; there is mu, alpha and D1"));
}

TEST_CASE("A curve that the scene can't follow is doubted, with another exit code", "[identify]") {
  const TempFolder folder;
  const std::string scene = folder.write("block.toml", replaced(test::touched_block_text, "0.012", "0.02"));
  const Outcome result =
      outcome(folder, scene, written(folder, "depth_m,force_N", [](double d) { return 3e6 * d * d * d + 0.1; }));
  CHECK(result.code == 3);
  CHECK(result.report["misfit_of_largest_force"] > 0.1);
  CHECK_THAT(result.said, Contains("DOUBTED") && Contains("the scene can't follow this curve"));
}

TEST_CASE("Depths or forces in another unit than their header's are refused, and read under their own", "[identify]") {
  const TempFolder folder;
  const std::string scene = folder.write("block.toml", replaced(test::touched_block_text, "0.012", "0.02"));
  const auto file = [&](const std::string& header, double depth_unit, double force_unit) {
    std::string text = header + "\n";
    for (int k = 1; k <= 8; ++k)
      text += std::to_string(0.0005 * k / depth_unit) + "," + std::to_string(0.02 * k / force_unit) + "\n";
    return folder.write("units.csv", text);
  };
  CHECK_THAT(refusal([&] { outcome(folder, scene, file("depth_m,force_N", 1e-3, 1)); }),
             Contains("units.csv: the deepest row is 4000 mm in, and the organ 30 mm thick") && Contains("depth_mm"));
  CHECK_THAT(refusal([&] { outcome(folder, scene, file("depth_m,force_N", 1, 1e-3)); }),
             Contains("the force at the deepest row is 160 N") && Contains("force_mN"));
  const MeasuredCurve curve = readForceCurve(file("depth_mm,force_mN", 1e-3, 1e-3));
  CHECK(curve.deepest() == Approx(0.004));
  CHECK(curve.force.back() == Approx(0.16));
  CHECK(curve.change.empty());
}

TEST_CASE("What noise does while the tool is held is no relaxation", "[identify]") {
  const TempFolder folder;
  const auto change = [&](double fall) {
    std::string text = "time_s,depth_m,force_N\n";
    for (int k = 1; k <= 48; ++k) {
      const double depth = 1e-4 * std::min(k, 40), held = std::max(0, k - 40) / 8.0;
      const double noise = 0.02 * std::sin(2.7 * k * k);
      text += std::to_string(k) + "," + std::to_string(depth) + "," +
              std::to_string(std::pow(depth / 0.004, 1.5) * (1 - fall * held) + noise) + "\n";
    }
    return readForceCurve(folder.write("force.csv", text)).change;
  };
  CHECK(change(0).empty());
  REQUIRE_FALSE(change(0.2).empty());
  CHECK(change(0.2).back() == Approx(-0.2).margin(0.06));
}

TEST_CASE("A curve that had not settled is doubted, and its interval reaches to what fits it then",
          "[identify][whole]") {
  const TempFolder folder;
  const std::string elastic = replaced(test::touched_block_text, "0.012", "0.02");
  const std::string scene = folder.write("block.toml", elastic);
  // A third relaxes in half the time of the press, which is then held for as long, or drawn out again.
  const Model model = loadModel(readScene(folder.write(
      "relaxing.toml", replaced(elastic, "poisson = 0.45", "poisson = 0.45\nrelaxation = [[0.33, 0.15]]"))));
  const bool held = GENERATE(true, false);
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  std::string text = "time_s,depth_m,force_N\n";
  const double ticks = press_seconds * model.scene.dynamics.rate_hz, touch = model.tools.first().first_contact_travel;
  for (int k = 1; k <= 2 * ticks; ++k) {
    const double way = k / ticks, depth = 0.004 * (way < 1 ? way : held ? 1 : 2 - way);
    command.tools[0].pose = model.tools.first().start.pose;
    command.tools[0].pose.position.z() -= touch + depth;
    const StepReport report = tick(model, state, command, workspace);
    if (k % 5 == 0)
      text += std::to_string(k / model.scene.dynamics.rate_hz) + "," + std::to_string(depth) + "," +
              std::to_string(report.tool_force.norm()) + "\n";
  }
  const std::string curve = folder.write("force.csv", text);
  CHECK(readForceCurve(curve).seconds == Approx(press_seconds).margin(0.02));
  const Outcome result = outcome(folder, scene, curve, {}, 0);
  INFO(result.said);
  const auto& young = result.report["parameters"]["young"];
  CHECK(result.report["pressed_in_s"] == Approx(press_seconds).margin(0.02));
  CHECK(result.code == 3);
  CHECK_THAT(result.said, Contains("the curve had not settled"));
  CHECK(young["value"].get<double>() > 1.1 * 0.67 * 3000);  // of the tissue at rest
  CHECK(young["low_95"] < 1.08 * 0.67 * 3000);              // the hold leaves an eighth of what relaxes
  if (!held) return;
  // A scene that relaxes is held as long: by its own share it is followed, with another one it is doubted.
  for (const double share : {0.33, 0.6}) {
    const Outcome relaxed = outcome(
        folder,
        folder.write("other.toml", replaced(elastic, "poisson = 0.45",
                                            "poisson = 0.45\nrelaxation = [[" + std::to_string(share) + ", 0.15]]")),
        curve, {}, 0);
    INFO(relaxed.said);
    const auto& same = relaxed.report["parameters"]["young"];
    CHECK((same["low_95"] < 3000 && 3000 < same["high_95"]));
    CHECK((relaxed.said.find("its \"relaxation\" is another") != std::string::npos) == (share != 0.33));
    CHECK(same["value"].get<double>() == Approx(3000).epsilon(share == 0.33 ? 0.01 : 0.3));
  }
}

TEST_CASE("Forces that do not count from 0 are told, and the interval reaches to what fits then", "[identify]") {
  MeasuredCurve measured;
  for (int k = 1; k <= 60; ++k) {
    measured.depth.push_back(1e-4 * k);
    measured.force.push_back(120 * std::pow(1e-4 * k, 1.5) * (1 + 0.002 * std::sin(40.0 * k)) + 0.003);
    measured.change.push_back(0);
  }
  const std::vector<SoughtParameter> sought{{"young", {0, 1e6, true}, 3000}};
  Identified found = identify(sought, [&](const std::vector<double>& value) {
    std::vector<double> residuals;
    for (std::size_t k = 0; k < measured.depth.size(); ++k)
      residuals.push_back(0.03 * value[0] * std::pow(measured.depth[k], 1.5) - measured.force[k]);
    return residuals;
  });
  CHECK(found.high[0] > 4050);
  const Remarks remarks = judge(measured, {}, sought, found);
  CHECK((found.low[0] < 4000 && 4000 < found.high[0]));
  REQUIRE(remarks.notes.size() == 1);
  CHECK_THAT(remarks.notes[0], Contains("Forces that are all 0.003 N too large"));
}

TEST_CASE("Depths that do not count from the touch are told, and the interval reaches to what fits then",
          "[identify]") {
  const double shift = GENERATE(0.0003, -0.0002, 0.0), young = 4000;
  const auto forceOf = [](double modulus, double depth) { return 30 * modulus * std::pow(std::max(depth, 0.0), 1.5); };
  MeasuredCurve measured;
  for (int k = 1; k <= 60; ++k) {
    measured.depth.push_back(1e-4 * k);
    measured.force.push_back(forceOf(young, 1e-4 * k - shift) * (1 + 0.002 * std::sin(40.0 * k)));
    measured.change.push_back(0);
  }
  const std::vector<SoughtParameter> sought{{"young", {0, 1e6, true}, 3000}};
  Identified found = identify(sought, [&](const std::vector<double>& value) {
    std::vector<double> residuals;
    for (std::size_t k = 0; k < measured.depth.size(); ++k)
      residuals.push_back(forceOf(value[0], measured.depth[k]) - measured.force[k]);
    return residuals;
  });
  CHECK(std::abs(found.value[0] - young) > (shift == 0 ? 0 : 0.03) * young);
  const Remarks remarks = judge(measured, {}, sought, found);
  CAPTURE(found.value[0], found.low[0], found.high[0]);
  CHECK((found.low[0] < young && young < found.high[0]));
  std::string said;
  for (const auto* list : {&remarks.notes, &remarks.doubts})
    for (const std::string& one : *list) said += one;
  if (shift == 0) {
    CHECK_THAT(said, !Contains("the touch"));
    return;
  }
  CHECK_THAT(said, Contains(shift > 0 ? "mm before the touch" : "mm after the touch"));
  const std::string before = "Depths that count from ";
  REQUIRE_THAT(said, Contains(before));
  CHECK(std::stod(said.substr(said.find(before) + before.size())) == Approx(1e3 * std::abs(shift)).epsilon(0.1));
}

TEST_CASE("A search on a coarse model asks the fine one two to four times", "[identify]") {
  // The coarse one is a third too stiff, more so the deeper, and feels the second parameter less.
  const auto curve = [](double stiffer, double softer, const std::vector<double>& p) {
    std::vector<double> force;
    for (int k = 1; k <= 40; ++k) {
      const double d = k / 40.0;
      force.push_back(stiffer * p[0] * std::pow(d, 1.5) * (1 + 0.2 * (stiffer - 1) * d) *
                      (1 + (p.size() > 1 ? softer * p[1] * d : 0)));
    }
    return force;
  };
  const Answer coarse = [&](const std::vector<double>& p) { return curve(1.33, 0.7, p); };
  const Answer fine = [&](const std::vector<double>& p) { return curve(1, 1, p); };
  const bool two = GENERATE(false, true);
  std::vector<SoughtParameter> sought{{"E", above(0), 1}};
  std::vector<double> truth{4.2};
  if (two) {
    sought.push_back({"b", above(0), 1});
    truth.push_back(0.4);
  }
  std::vector<double> measured = fine(truth);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.01);
  for (double& force : measured) force *= 1 + noise(random);
  const CoarseToFine search = identifyCoarseToFine(sought, measured, coarse, fine);
  const CoarseToFine direct = identifyFine(sought, measured, fine);
  CHECK(search.fine_solves <= (two ? 4 : 3));
  CHECK(search.fine_solves < direct.fine_solves / 2);
  CHECK(search.found.converged);
  for (std::size_t k = 0; k < sought.size(); ++k) {
    const double half = 0.5 * (direct.found.high[k] - direct.found.low[k]);
    CHECK(search.found.value[k] == Approx(direct.found.value[k]).margin(0.15 * half));
    CHECK(search.found.high[k] - search.found.low[k] ==
          Approx(2 * half).epsilon(0.3));  // derivatives are the coarse one's
  }
  CHECK_THROWS_AS(
      identifyCoarseToFine(
          sought, measured,
          [](const std::vector<double>&) -> std::vector<double> { throw std::runtime_error("no answer"); }, fine),
      CoarseFailed);
}

TEST_CASE("A fine scene is pressed two to four times, its search being on a coarser cloud", "[identify][whole]") {
  const TempFolder folder;
  const std::string scene = folder.write("block.toml", replaced(test::touched_block_text, "0.012", "0.0042"));
  const std::string curve = measured(folder, scene, {{"material[0].young", "4321"}});
  const nlohmann::json one = found(folder, scene, curve, {});
  CHECK(one["coarser_by"] > 1.2);
  CHECK(one["curves_simulated"] >= 2);
  CHECK(one["curves_simulated"] <= 4);
  CHECK(one["curves_on_a_coarser_cloud"] > one["curves_simulated"]);
  const auto& young = one["parameters"]["young"];
  CHECK(young["value"].get<double>() == Approx(4321).epsilon(0.01));
  CHECK(young["low_95"] < 4321);
  CHECK(young["high_95"] > 4321);
}

TEST_CASE("A narrow, bent valley is gone along to its end, and a step that is only damped is no arrival",
          "[identify]") {
  // A curve of which b matters a hundredth of what a b^1.7 does, as Poisson's ratio may beside Young's modulus.
  const auto valley = [](const std::vector<double>& p) {
    const auto force = [](double a, double b, double depth) {
      return a * std::pow(b, 1.7) * depth + 0.05 * b * depth * depth;
    };
    std::vector<double> r;
    for (int k = 1; k <= 20; ++k) r.push_back(force(p[0], p[1], 0.1 * k) - force(2, 3, 0.1 * k));
    return r;
  };
  for (const std::vector<double>& start : {std::vector<double>{20, 3}, {2, 0.3}, {8, 0.6}, {0.4, 9}}) {
    const Identified found = identify({{"a", above(0), start[0]}, {"b", above(0), start[1]}}, valley);
    INFO(found.value[0] << " " << found.value[1]);
    const bool right = std::abs(found.value[0] - 2) < 0.01 && std::abs(found.value[1] - 3) < 0.01;
    CHECK(found.converged == right);
    CHECK((right || start[0] == 8 || start[0] == 0.4));  // from far along the valley the way is long
  }
}

TEST_CASE("A file that is no force curve is refused with its place", "[identify]") {
  const TempFolder folder;
  const auto refused = [&](const std::string& text) {
    return refusal([&] { readForceCurve(folder.write("f.csv", text)); });
  };
  CHECK_THAT(refused("depth_m,depth_mm,force_N\n0.001,1,2\n"),
             Contains("f.csv:1: columns depth_m and depth_mm for the same"));
  CHECK_THAT(refused("time,force\n1,2\n"), Contains("f.csv:1: there is no column depth_m"));
  CHECK_THAT(refused("depth_m,force_N\n0.001,x\n"),
             Contains("f.csv:2:7: \"x\" is not a number") && Contains("force_N"));
  CHECK_THAT(refused("depth_m,force_N\n0.001,1\n-1,2\n"), Contains("only 1 rows on the way in"));
  CHECK_THAT(refused("depth_m,force_N\n0.001,1\n0.002,nan\n"), Contains("f.csv:3: the force is no number"));
  CHECK_THAT(refused("depth_m,force_N\n0.001,1\n,2\n"), Contains("f.csv:3: the depth is no number"));
  const MeasuredCurve from_spreadsheet = readForceCurve(
      folder.write("f.csv", "\xEF\xBB\xBFwhat;depth_mm;force_mN\nin;1,5;20\nin;2;30\nin;2,5;40\nin;3;50\nin;3,5;60\n"));
  CHECK(from_spreadsheet.depth.front() == Approx(0.0015));
  CHECK(from_spreadsheet.force.back() == Approx(0.06));
  const MeasuredCurve curve =
      readForceCurve(folder.write("f.csv",
                                  "depth_m,force_raw_N_x,force_raw_N_y,force_raw_N_z,trust\n1,0,0,"
                                  "1,good\n2,0,3,4,good\n2,0,0,7,good\n3,0,0,7,good\n"
                                  "4,0,0,8,good\n5,0,0,9,good\n4,0,0,90,good\n"));
  const MeasuredCurve signed_forces = readForceCurve(
      folder.write("f.csv", "depth_m,force_N\n0.001,-0.1\n0.001,0.3\n0.002,-0.4\n0.003,-0.6\n0.004,-0.8\n0.005,-1\n"));
  CHECK(signed_forces.force.front() == Approx(-0.1));  // noise about the touch keeps its sign
  CHECK(signed_forces.force.back() == Approx(1));      // a push counts up, whatever the file's sign
  CHECK(curve.depth == std::vector<double>{1, 2, 3, 4, 5});
  CHECK(curve.force == std::vector<double>{1, 6, 7, 8, 9});
  CHECK(forceAt(curve, 0.5) == 0.5);
  CHECK(forceAt(curve, 2.5) == 6.5);
  CHECK(curve.change.empty());  // one row on the way out tells nothing
}
