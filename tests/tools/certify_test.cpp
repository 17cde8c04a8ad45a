#include "mtled/certify/certify_command.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "io/load_model.h"
#include "io/scene_file.h"
#include "model/model_hash.h"
#include "support/block_text.h"
#include "support/captured_output.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::tools;

TEST_CASE("A certificate's error is the largest of its depth, against the limit of two finer clouds", "[certify]") {
  const Model model = test::blockModel();
  constexpr int ticks = 100;
  constexpr double ratio = 1.5, deepest = 0.004;
  ToolTrajectory way;
  ScriptedRun run;
  ConvergedRun converged;
  // Too stiff, by less the deeper; the finer ones of second order in the spacing.
  const auto coarse = [](double depth) { return 0.0001 / depth; };
  const double fine = 0.01, coarser = fine * ratio * ratio;
  for (int k = 1; k <= ticks; ++k) {
    const double depth = deepest * k / ticks, truth = 100 * depth;
    way.emplace_back()[0].pose = test::toolAt(model, model.tools.first().first_contact_travel + depth);
    run.force.emplace_back(0, 0, truth * (1 + coarse(depth)));
    converged.run.force.emplace_back(0, 0, truth * (1 + fine));
    converged.coarser.force.emplace_back(0, 0, truth * (1 + coarser));
  }
  const auto rows = certifiedRows(advances(model, way), run, converged, ratio, 4);
  REQUIRE(rows.size() == 4);
  for (std::size_t r = 0; r < 4; ++r) {
    const double depth = deepest * static_cast<double>(r + 1) / 4, begin = r == 0 ? 0.5 * depth : depth - deepest / 4;
    CHECK(rows[r].advance == Approx(depth));
    CHECK(rows[r].force == Approx(100 * depth));  // extrapolated to the limit itself
    CHECK(rows[r].scene_force == Approx(100 * depth * (1 + coarse(depth))));
    CHECK(rows[r].error >= coarse(depth));
    CHECK(rows[r].error == Approx(coarse(begin + deepest / ticks)).epsilon(r == 0 ? 0.05 : 0.01));
    CHECK(rows[r].uncertainty == Approx(fine));
  }
  converged.about.layer_error = 0.2;  // not even the finest cloud sees all of a thin layer
  CHECK(certifiedRows(advances(model, way), run, converged, ratio, 1).at(0).uncertainty == Approx(0.2));

  const std::vector<Pose> poses = certifiedPoses(model, way);
  CHECK(poses.size() > 2);
  CHECK(poses.size() < 10);
  CHECK(poses.back().position == way.back()[0].pose.position);
}

TEST_CASE("certify leaves a certificate of the scene's own model beside it", "[certify][whole]") {
  const TempFolder folder;
  CertifyOptions options;
  options.scene = folder.write("block.toml", replaced(test::touched_block_text, "spacing = 0.012", ""));  // follows
  options.use_cache = false;
  const CapturedOutput captured;
  REQUIRE(certifyCommand(options) == 0);
  const Model model = loadModel(readScene(options.scene));
  const auto certificate = readCertificate(certificateFile(options.scene), modelHash(model));
  REQUIRE(certificate);
  REQUIRE(certificate->row.size() == 8);
  CHECK(certificate->deepest() > 0.003);
  for (const Certificate::Row& row : certificate->row) {
    CHECK(row.error > 0);
    CHECK(row.scene_force > 0);
    CHECK(row.uncertainty >= 0);
  }
  CHECK(certificate->row.back().error < certificate->row.front().error);
  CHECK(certificate->isOnWay(test::toolAt(model, model.tools.first().first_contact_travel + 0.002), 0.002, 1e-3));
  CHECK(certificate->displacement_error > 0);
  CHECK(certificate->displacement_error < 0.2);
}

TEST_CASE("certify does not certify what a layer thinner than the nodes of all clouds does", "[certify][whole]") {
  const TempFolder folder;
  CertifyOptions options;
  options.scene = folder.write("layer.toml", test::touched_block_text + R"([[material]]
model = "neo-hookean"
young = 100
poisson = 0.3
region = {shape = "half-space", point = [0, 0, 0.001], normal = [0, 0, 1]}
)");
  options.use_cache = false;
  const CapturedOutput captured;
  REQUIRE(certifyCommand(options) == 0);
  const Model model = loadModel(readScene(options.scene));
  REQUIRE(model.layer_error > 0.1);
  const auto certificate = readCertificate(certificateFile(options.scene), modelHash(model));
  REQUIRE(certificate);
  for (const Certificate::Row& row : certificate->row) CHECK(row.uncertainty > 0.1);
}

TEST_CASE("Where there are several tools, or jaws, each goes its way, and the errors are told over time", "[certify]") {
  const TempFolder folder;
  CertifyOptions options;
  options.use_cache = false;
  // Two that squeeze a block from both sides, the second deeper.
  folder.write("shallow.toml", "[[keyframe]]\ntime = 0.1\nadvance = 0.002\n");
  folder.write("deep.toml", "[[keyframe]]\ntime = 0.1\nadvance = 0.004\n");
  const std::string finger = "[[tool]]\nshape = \"sphere\"\nradius = 0.01\n";
  options.scene = folder.write("block.toml", test::block_text + finger + R"(position = [-0.041, 0, 0.02]
direction = [1, 0, 0]
input = "script:shallow.toml"
)" + finger + R"(position = [0.041, 0, 0.02]
direction = [-1, 0, 0]
input = "script:deep.toml"
)");
  const Model model = loadModel(readScene(options.scene));
  const ToolTrajectory way = scriptedTrajectory(model);
  CHECK(way.back()[0].pose.position.x() == Approx(-0.028));
  CHECK(way.back()[1].pose.position.x() == Approx(0.026));
  const ScriptedRun run = runTrajectory(model, way, {}, 1), in_double = runTrajectory(model, way, {}, 1, true);
  REQUIRE(run.force.size() == 2 * way.size());
  CHECK(run.force.back().x() > 1.5 * std::abs(run.force[run.force.size() - 2].x()));
  CHECK(errorOf(run, in_double).force < 1e-3);
  CHECK(contactRegions(model, way).size() == 2);

  const CapturedOutput captured;
  REQUIRE(certifyCommand(options) == 0);
  CHECK_FALSE(std::filesystem::exists(certificateFile(options.scene)));
  options.out = folder.path("certificate.json");
  CHECK_THROWS_WITH(certifyCommand(options), Catch::Contains("block.toml") && Catch::Contains("leave --out away"));
}

TEST_CASE("What jaws pinch with is a force of its own", "[certify]") {
  const TempFolder folder;
  folder.write("close.toml", "from_touch = false\n[[keyframe]]\ntime = 0.1\nadvance = 0\nopening = 0.054\n");
  const Model model = loadModel(readScene(folder.write("block.toml", test::block_text + R"([tool]
shape = "sphere"
radius = 0.008
opening = 0.062
friction = 0.5
position = [0, 0, 0.02]
input = "script:close.toml"
)")));
  const ToolTrajectory way = scriptedTrajectory(model);
  CHECK(way.back()[0].opening == Approx(0.054));
  const ScriptedRun run = runTrajectory(model, way, {}, 1);
  REQUIRE(run.sound());
  const double pinch = run.force.back().x();
  CHECK(pinch > 0.05);                                                 // N
  CHECK(std::abs(run.force[run.force.size() - 2].x()) < 0.1 * pinch);  // the two fingers' sum
  CHECK(contactRegions(model, way).size() == 2);
}

TEST_CASE("A certificate is not written over what it is of", "[certify]") {
  const TempFolder folder;
  const std::string text = replaced(test::touched_block_text, "0.012", "0.02");
  CertifyOptions options;
  options.scene = options.out = folder.write("block.toml", text);
  CHECK_THROWS_WITH(certifyCommand(options), Catch::Contains("block.toml") && Catch::Contains("would be lost"));
  options.tool_script = options.out = folder.write("way.toml", "[[keyframe]]\ntime = 0.1\nadvance = 0.002\n");
  CHECK_THROWS_WITH(certifyCommand(options), Catch::Contains("way.toml") && Catch::Contains("would be lost"));
  CHECK(readAll(options.scene) == text);
}
