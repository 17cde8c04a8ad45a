#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <utility>
#include <vector>

#include "api/pressed_block.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::test;

namespace {

/// The block under jaws whose fingers stand on either side of its upper end, and a ball above it.
const std::string jaws_text =
    replaced(block_text, "size = [0.06, 0.06, 0.03]", "size = [0.024, 0.03, 0.03]") + R"([[tool]]
shape = "capsule"
radius = 0.006
position = [0, 0, 0.014]
opening = 0.03
friction = 0.6
max_speed = 0.2
[[tool]]
shape = "sphere"
radius = 0.008
position = [0, 0, 0.035]
max_speed = 0.2
)";

palpate_tool_state readTool(const SimulationHandle& simulation, int tool) {
  auto state = sized<palpate_tool_state>();
  REQUIRE(palpate_read_tool(simulation.get(), tool, &state) == PALPATE_OK);
  return state;
}

/// Closes the jaws to 20 mm and presses the ball in by 2 mm. @return the hash after 80 ticks
std::uint64_t play(const SimulationHandle& simulation) {
  const auto ball = readTool(simulation, 1);
  std::array<double, 7> pose{};
  std::copy_n(ball.pose, 7, pose.begin());
  pose[2] = 0.028;
  REQUIRE(palpate_set_opening(simulation.get(), 0, 0.02) == PALPATE_OK);
  REQUIRE(palpate_set_tool_target(simulation.get(), 1, pose.data(), 0) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 80, nullptr, nullptr) == PALPATE_OK);
  std::uint64_t hash = 0;
  REQUIRE(palpate_hash(simulation.get(), &hash) == PALPATE_OK);
  return hash;
}

}  // namespace

TEST_CASE("Each tool is moved and read by its number, and jaws by their opening", "[api][several_tools]") {
  const ModelHandle model = loadBlock(jaws_text);
  std::int32_t count = 0;
  REQUIRE(palpate_tool_count(model.get(), &count) == PALPATE_OK);
  CHECK(count == 2);
  const SimulationHandle simulation = create(model);
  CHECK(readTool(simulation, 0).opening == 0.03);
  CHECK(readTool(simulation, 1).pose[2] == 0.035);
  play(simulation);
  const palpate_tool_state jaws = readTool(simulation, 0), ball = readTool(simulation, 1);
  auto whole = sized<palpate_state>();
  REQUIRE(palpate_read(simulation.get(), &whole) == PALPATE_OK);
  CHECK(jaws.tick == 80);
  CHECK(jaws.opening == Approx(0.02));
  CHECK(jaws.pinch > 0.05);
  CHECK(std::equal(jaws.force, jaws.force + 3, whole.force));  // the first tool's
  CHECK(ball.force[2] > 0.02);
  CHECK(ball.contact_count > 0);
  CHECK(ball.pinch == 0);

  const double pose[7] = {0, 0, 0.05, 0, 0, 0, 1};
  CHECK(palpate_set_tool_target(simulation.get(), 2, pose, 0) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_tool_target(simulation.get(), -1, pose, 0) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_opening(simulation.get(), 1, 0.01) == PALPATE_BAD_ARGUMENT);  // no jaws
  CHECK(palpate_set_opening(simulation.get(), 0, -0.01) == PALPATE_BAD_ARGUMENT);
  auto state = sized<palpate_tool_state>();
  CHECK(palpate_read_tool(simulation.get(), 2, &state) == PALPATE_BAD_ARGUMENT);
}

TEST_CASE("The friction of each tool is its own, and stays in a saved state", "[api][several_tools]") {
  const ModelHandle model = loadBlock(jaws_text);
  const auto dragged = [&](double friction) {
    const SimulationHandle simulation = create(model), other = create(model);
    REQUIRE(palpate_set_tool_friction(simulation.get(), 1, friction) == PALPATE_OK);
    play(simulation);
    copyState(simulation, other);
    const double aside[7] = {0.003, 0, 0.028, 0, 0, 0, 1};
    for (const SimulationHandle* one : {&simulation, &other}) {
      REQUIRE(palpate_set_tool_target(one->get(), 1, aside, 0) == PALPATE_OK);
      REQUIRE(palpate_step(one->get(), 40, nullptr, nullptr) == PALPATE_OK);
    }
    CHECK(readTool(other, 1).force[0] == readTool(simulation, 1).force[0]);
    return std::abs(readTool(simulation, 1).force[0]);
  };
  CHECK(dragged(1) > 2 * dragged(0));
  const SimulationHandle simulation = create(model);
  CHECK(palpate_set_tool_friction(simulation.get(), 2, 0.1) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_tool_friction(simulation.get(), -1, 0.1) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_tool_friction(simulation.get(), 1, 2.1) == PALPATE_BAD_ARGUMENT);
}

TEST_CASE("A saved state of several tools goes on bit for bit", "[api][several_tools]") {
  const ModelHandle model = loadBlock(jaws_text);
  const SimulationHandle simulation = create(model), other = create(model);
  play(simulation);
  copyState(simulation, other);
  CHECK(readTool(other, 0).pinch == readTool(simulation, 0).pinch);
  std::uint64_t a = 0, b = 0;
  for (const auto& [handle, hash] : {std::pair{&simulation, &a}, std::pair{&other, &b}}) {
    REQUIRE(palpate_set_opening(handle->get(), 0, 0.018) == PALPATE_OK);
    REQUIRE(palpate_step(handle->get(), 20, nullptr, nullptr) == PALPATE_OK);
    REQUIRE(palpate_hash(handle->get(), hash) == PALPATE_OK);
  }
  CHECK(a == b);

  // A reset one begins anew with all of them.
  const std::uint64_t played = play(create(model));
  REQUIRE(palpate_reset(simulation.get()) == PALPATE_OK);
  CHECK(play(simulation) == played);
}

TEST_CASE("A scene with one tool is read by its number, too", "[api][several_tools]") {
  const ModelHandle model = loadBlock();
  const SimulationHandle simulation = create(model);
  const auto pose = poseAtDepth(describe(model), 0.002);
  REQUIRE(palpate_set_tool_target(simulation.get(), 0, pose.data(), 7) == PALPATE_OK);
  auto whole = sized<palpate_state>();
  REQUIRE(palpate_step(simulation.get(), 40, nullptr, &whole) == PALPATE_OK);
  const palpate_tool_state tool = readTool(simulation, 0);
  CHECK(whole.pose_sequence == 7);
  CHECK(tool.tick == 40);
  CHECK(tool.contact_count == whole.contact_count);
  CHECK(std::equal(tool.force, tool.force + 3, whole.force));
  CHECK(palpate_set_opening(simulation.get(), 0, 0.01) == PALPATE_BAD_ARGUMENT);
}

TEST_CASE("A script that closes jaws hands out their openings, and one of a tool without jaws none",
          "[api][several_tools][whole]") {
  const auto load = [](const char* scene) {
    palpate_model* model = nullptr;
    REQUIRE(palpate_load(scene, nullptr, &model, nullptr) == PALPATE_OK);
    return ModelHandle(model);
  };
  const ModelHandle model = load("strip_grasp");
  std::int64_t count = 0, jaws = 0;
  REQUIRE(palpate_script(model.get(), nullptr, nullptr, 0, &count, nullptr) == PALPATE_OK);
  std::vector<double> poses(7 * count), openings(count);
  REQUIRE(palpate_script(model.get(), nullptr, poses.data(), count, &count, nullptr) == PALPATE_OK);
  REQUIRE(palpate_script_openings(model.get(), nullptr, openings.data(), count, &jaws, nullptr) == PALPATE_OK);
  REQUIRE(jaws == count);
  const auto [least, most] = std::minmax_element(openings.begin(), openings.end());
  CHECK(*least < 0.5 * *most);
  const SimulationHandle simulation = create(model);
  double pinch = 0;  // N
  for (std::int64_t tick = 0; tick < count / 2; ++tick) {
    REQUIRE(palpate_set_opening(simulation.get(), 0, openings[tick]) == PALPATE_OK);
    REQUIRE(palpate_step(simulation.get(), 1, &poses[7 * tick], nullptr) == PALPATE_OK);
    pinch = std::max(pinch, readTool(simulation, 0).pinch);
  }
  CHECK(pinch > 0.05);
  CHECK(palpate_set_opening(simulation.get(), 0, 1e9) == PALPATE_BAD_ARGUMENT);

  const ModelHandle ball = load("layer_sphere");
  REQUIRE(palpate_script_openings(ball.get(), nullptr, openings.data(), 10, &jaws, nullptr) == PALPATE_OK);
  CHECK(jaws == 0);
  CHECK(palpate_script_openings(nullptr, nullptr, nullptr, 0, &jaws, nullptr) == PALPATE_BAD_ARGUMENT);
}
