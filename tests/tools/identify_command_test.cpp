#include "mtled/identify/identify_command.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "io/load_model.h"
#include "io/scene_file.h"
#include "mtled/identify/force_curve.h"
#include "mtled/identify/identify.h"
#include "support/block_text.h"
#include "support/captured_output.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::tools;
using Catch::Contains;

namespace {

constexpr double press_seconds = 0.3;

/// Forces of the block with other parameters, 4 mm deep, with 1 % noise.
std::string measured(const TempFolder& folder, const std::string& scene, const std::vector<SceneChange>& truth) {
  const ForceCurve curve = simulateForceCurve(loadModel(readScene(scene, truth)), 0.004, press_seconds);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.01);
  std::string text = "depth_m,force_N,trust\n-0.001,0,good\n";
  for (std::size_t k = 9; k < curve.depth.size(); k += 10)
    text += std::to_string(curve.depth[k]) + "," + std::to_string(curve.force[k] * (1 + noise(random))) + ",good\n";
  return folder.write("force.csv", text + "0.001,5,good\n");  // and on the way out
}

nlohmann::json found(const TempFolder& folder, const std::string& scene, const std::string& curve,
                     const std::vector<std::string>& parameters) {
  const CapturedOutput quiet;
  IdentifyOptions options;
  options.scene = scene;
  options.measured = curve;
  options.parameters = parameters;
  options.seconds = press_seconds;
  options.out = folder.path("out");
  CHECK(identifyCommand(options) == 0);
  return nlohmann::json::parse(readAll(folder.path("out/identify.json")));
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
  const Identified result = identify({{"slope", {}, 1}, {"offset", {}, 0}}, [&](const std::vector<double>& p) {
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

TEST_CASE("Held-out parameters come back from a noisy force curve", "[identify]") {
  const TempFolder folder;
  const std::string scene = folder.write("block.toml", replaced(test::touched_block_text, "0.012", "0.02"));
  const std::string curve = measured(folder, scene, {{"material[0].young", "4321"}});
  const nlohmann::json one = found(folder, scene, curve, {});
  const auto& young = one["parameters"]["young"];
  CHECK(young["value"].get<double>() == Approx(4321).epsilon(0.02));
  CHECK(young["low_95"] < young["value"]);
  CHECK(young["high_95"] > young["value"]);
  CHECK(young["high_95"].get<double>() - young["low_95"].get<double>() < 0.04 * 4321);
  CHECK(one["misfit_of_largest_force"] < 0.02);
}

TEST_CASE("A file that is no force curve is refused with its place", "[identify]") {
  const TempFolder folder;
  const auto refused = [&](const std::string& text) {
    return refusal([&] { readForceCurve(folder.write("f.csv", text)); });
  };
  CHECK_THAT(refused("time,force\n1,2\n"), Contains("f.csv:1: there is no column depth_m"));
  CHECK_THAT(refused("depth_m,force_N\n0.001,x\n"), Contains("f.csv:2: \"x\" in force_N"));
  CHECK_THAT(refused("depth_m,force_N\n0.001,1\n-1,2\n"), Contains("only 1 rows"));
  const ForceCurve curve = readForceCurve(folder.write("f.csv",
                                                       "depth_m,force_raw_N_x,force_raw_N_y,force_raw_N_z,trust\n1,0,0,"
                                                       "1,good\n2,0,3,4,good\n2,0,0,7,good\n3,0,0,7,good\n"
                                                       "4,0,0,8,good\n5,0,0,9,good\n4,0,0,90,good\n"));
  CHECK(curve.depth == std::vector<double>{1, 2, 3, 4, 5});
  CHECK(curve.force == std::vector<double>{1, 6, 7, 8, 9});
  CHECK(forceAt(curve, 0.5) == 0.5);
  CHECK(forceAt(curve, 2.5) == 6.5);
}
