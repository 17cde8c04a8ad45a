// Scenes with several tools and jaws: reading, refusals, scripts.

#include <catch2/catch.hpp>
#include <vector>

#include "base/build_info.h"
#include "io/indent_script.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "io/scene_texts.h"
#include "model/model_hash.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/block_text.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::test;
using Catch::Contains;

namespace {

const std::string second_tool = R"([[tool]]
shape = "capsule"
radius = 0.005
position = [0.02, 0, 0.04]
)";

/// The same with its tool in a list.
std::string listed(const std::string& text) { return replaced(text, "[tool]", "[[tool]]"); }

Model load(const TempFolder& folder, const std::string& text) {
  return loadModel(readScene(folder.write("s.toml", text)), {}, ModelCache(""));
}

std::uint64_t pressedHash(const Model& model) {
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  command.tools[0].pose = model.tools.first().start.pose;
  command.tools[0].pose.position.z() -= model.tools.first().first_contact_travel + 0.003;
  for (int k = 0; k < 20; ++k) tick(model, state, command, workspace);
  return stateHash(model, state);
}

}  // namespace

TEST_CASE("One tool in a list is the same tool, bit for bit", "[io][several_tools]") {
  const TempFolder folder;
  const Model table = load(folder, touched_block_text), list = load(folder, listed(touched_block_text));
  CHECK_FALSE(list.tools.several());
  CHECK(modelHash(list) == modelHash(table));
  CHECK(pressedHash(list) == pressedHash(table));
}

TEST_CASE("Tools in a list have keys of their own", "[io][several_tools]") {
  const TempFolder folder;
  const Scene scene = readScene(folder.write(
      "s.toml", listed(touched_block_text) + second_tool + "opening = 0.01\nfriction = 0.7\nmax_speed = 0.3\n"));
  REQUIRE(scene.tools.size() == 2);
  const ToolSpec& tool = scene.tools[1];
  CHECK(scene.tools[0].shape.radius == 0.01);
  CHECK(tool.shape.radius == 0.005);
  CHECK(tool.jaws());
  CHECK(tool.friction == 0.7);
  CHECK(tool.direction == Vec3(0, 0, -1));
  CHECK(smallestToolRadius(scene) == 0.005);
  CHECK(largestToolSpeed(scene) == 1);
  CHECK(scene.places.at("tool[1].opening").line == scene.places.at("tool[1].position").line + 1);
}

TEST_CASE("Bad tools are refused at their place", "[io][several_tools]") {
  const TempFolder folder;
  const auto message = [&](const std::string& text) {
    return refusal([&] { readScene(folder.write("s.toml", text)); });
  };
  const std::string one = listed(touched_block_text);
  CHECK_THAT(message(one + second_tool + second_tool + second_tool + second_tool),
             Contains("s.toml:33:1: more than 4 tools"));
  CHECK_THAT(message(one + "input = \"mouse\"\n"),
             Contains("s.toml:21:1") && Contains("\"mouse\" is no input") && Contains("script:FILE"));
  CHECK_THAT(message(one + "input = \"script:none.toml\"\n"), Contains("there is no tool script"));
  CHECK_THAT(message(one + "opening = -0.01\n"), Contains("out of range"));
  CHECK_THAT(message(one + second_tool + "edge_radius = 0.001\n"), Contains("means nothing to a capsule"));
  CHECK_THAT(message(one + second_tool + "colour = 1\n"), Contains("unknown key \"colour\" in [[tool]]"));
}

TEST_CASE("Jaws without friction are warned of", "[io][several_tools]") {
  const TempFolder folder;
  std::vector<std::string> warnings;
  const auto warn = [&](const std::string& text) { warnings.push_back(text); };
  const std::string jaws = touched_block_text + "opening = 0.02\n";
  loadModel(readScene(folder.write("s.toml", jaws)), {}, ModelCache(""), warn);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("s.toml:20:1: jaws without friction hold nothing"));
  warnings.clear();
  loadModel(readScene(folder.write("s.toml", jaws + "friction = 0.5\n")), {}, ModelCache(""), warn);
  CHECK(warnings.empty());
}

TEST_CASE("A script opens and closes jaws, and a second tool's becomes its path", "[io][several_tools]") {
  const TempFolder folder;
  folder.write(
      "way.toml",
      "from_touch = false\n[[keyframe]]\ntime = 0.1\nadvance = 0.002\n[[keyframe]]\ntime = 0.3\nadvance = 0.002\n"
      "opening = 0.004\n[[keyframe]]\ntime = 0.5\nadvance = 0.0\n");
  const std::string input = "input = \"script:way.toml\"\nopening = 0.01\nfriction = 0.5\n";
  const Model model = load(folder, listed(touched_block_text) + input + second_tool + input);
  REQUIRE(model.tools.toolCount() == 2);
  CHECK(model.tools.first().path.empty());  // a hand may have it; runs without one take its script
  ScriptTrajectory way = trajectoryOf(indentScript(model), model);
  const std::vector<ToolPosture>& path = model.tools.tool[1].path;
  REQUIRE(static_cast<std::int64_t>(path.size()) == way.ticks());
  const ToolPosture& start = model.tools.tool[1].start;
  for (const ToolPosture& posture : path) {
    const Pose pose = way.next();
    CHECK(posture.opening == way.opening());  // both scripts are the same
    CHECK((posture.pose.position - start.pose.position - (pose.position - model.tools.first().start.pose.position))
              .norm() < 1e-12);
  }
  CHECK(path.front().opening == Approx(0.01));
  CHECK(path.back().opening == Approx(0.004));
  CHECK(path.back().pose.position.z() == Approx(start.pose.position.z()));
  CHECK(path[path.size() / 2].pose.position.z() < start.pose.position.z() - 0.001);
  CHECK(modelHash(model) !=
        modelHash(load(folder, listed(touched_block_text) + input + second_tool + "opening = 0.01\nfriction = 0.5\n")));
}

TEST_CASE("The scenes with several tools load, with their scripts", "[io][several_tools]") {
  const std::string folder = sourceFolder() + "/assets/scenes/";
  for (const char* name : {"strip_grasp.toml", "two_fingers.toml"}) {
    INFO(name);
    std::vector<std::string> warnings;
    const Model model = loadModel(readScene(folder + name), {}, ModelCache(""),
                                  [&](const std::string& text) { warnings.push_back(text); });
    CHECK(warnings.empty());
    CHECK(model.tools.toolCount() + static_cast<int>(model.rigid.body.size()) == 2);
    CHECK(model.nodeCount() < 600);
    CHECK(trajectoryOf(indentScript(model), model).ticks() > 500);
  }
}
