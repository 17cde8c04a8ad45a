#include <catch2/catch.hpp>
#include <cstring>
#include <vector>

#include "api/pressed_block.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::test;

namespace {

struct TeamDeleter {
  void operator()(palpate_team* team) const { palpate_team_destroy(team); }
};
using TeamHandle = std::unique_ptr<palpate_team, TeamDeleter>;

TeamHandle teamOf(int threads) {
  palpate_team* team = nullptr;
  REQUIRE(palpate_team_create(threads, &team, nullptr) == PALPATE_OK);
  return TeamHandle(team);
}

/// Blocks of two models, pressed at places of their own.
struct Blocks {
  static constexpr int count = 5;

  explicit Blocks(const std::vector<ModelHandle>& models) {
    for (int k = 0; k < count; ++k) {
      const ModelHandle& model = models[static_cast<std::size_t>(k) % models.size()];
      simulations.push_back(create(model));
      handles.push_back(simulations.back().get());
      infos.push_back(describe(model));
    }
  }

  /// (count, 7), for a tick of the press.
  std::vector<double> poses(int tick) const {
    std::vector<double> all;
    for (int k = 0; k < count; ++k) {
      auto pose = poseAtDepth(infos[static_cast<std::size_t>(k)], -0.001 + 1e-4 * tick);
      pose[1] += 0.003 * k;
      all.insert(all.end(), pose.begin(), pose.end());
    }
    return all;
  }

  std::vector<std::uint64_t> hashes() const {
    std::vector<std::uint64_t> all;
    for (const SimulationHandle& simulation : simulations) all.push_back(hashOf(simulation));
    return all;
  }

  std::vector<SimulationHandle> simulations;
  std::vector<palpate_simulation*> handles;
  std::vector<palpate_model_info> infos;
};

std::vector<ModelHandle> twoModels() {
  std::vector<ModelHandle> models;
  models.push_back(loadBlock());
  models.push_back(loadBlock(replaced(touched_block_text, "spacing = 0.012", "spacing = 0.014")));
  return models;
}

std::vector<palpate_state> sizedStates() { return std::vector<palpate_state>(Blocks::count, sized<palpate_state>()); }

}  // namespace

TEST_CASE("Many simulations on a team have the bits of one after the other", "[api][step_many][whole]") {
  const std::vector<ModelHandle> models = twoModels();
  const Blocks alone(models), threaded(models), in_turn(models);
  const TeamHandle team = teamOf(3), all_cores = teamOf(0);
  auto states = sizedStates(), others = sizedStates();
  for (int tick = 0; tick < 40; tick += 2) {
    const std::vector<double> poses = threaded.poses(tick);
    REQUIRE(palpate_step_many((tick % 4 == 0 ? team : all_cores).get(), threaded.handles.data(), Blocks::count, 2,
                              poses.data(), states.data(), nullptr) == PALPATE_OK);
    REQUIRE(palpate_step_many(nullptr, in_turn.handles.data(), Blocks::count, 2, poses.data(), others.data(),
                              nullptr) == PALPATE_OK);
    for (std::size_t k = 0; k < Blocks::count; ++k) {
      auto state = sized<palpate_state>();
      REQUIRE(palpate_step(alone.handles[k], 2, &poses[7 * k], &state) == PALPATE_OK);
      CHECK(std::memcmp(state.force, states[k].force, sizeof state.force) == 0);
      CHECK(std::memcmp(state.force, others[k].force, sizeof state.force) == 0);
      CHECK(states[k].tick == tick + 2);
    }
  }
  CHECK(states[0].force[2] > 0);
  CHECK(threaded.hashes() == alone.hashes());
  CHECK(in_turn.hashes() == alone.hashes());

  REQUIRE(palpate_step_many(team.get(), threaded.handles.data(), Blocks::count, 3, nullptr, nullptr, nullptr) ==
          PALPATE_OK);
  for (palpate_simulation* one : alone.handles) REQUIRE(palpate_step(one, 3, nullptr, nullptr) == PALPATE_OK);
  CHECK(threaded.hashes() == alone.hashes());
  CHECK(palpate_step_many(team.get(), nullptr, 0, 3, nullptr, nullptr, nullptr) == PALPATE_OK);
}

TEST_CASE("One bad argument, and none of many simulations moves", "[api][step_many]") {
  const std::vector<ModelHandle> models = twoModels();
  const Blocks blocks(models);
  const TeamHandle team = teamOf(2);
  const std::vector<std::uint64_t> before = blocks.hashes();
  const std::vector<double> poses = blocks.poses(30);
  auto error = sized<palpate_error>();
  auto states = sizedStates();
  const auto refused = [&](std::vector<palpate_simulation*> handles, std::vector<double> at, std::int32_t code,
                           const char* text, std::int64_t n = 3) {
    CHECK(palpate_step_many(team.get(), handles.data(), Blocks::count, n, at.data(), states.data(), &error) == code);
    CHECK_THAT(error.text, Catch::Contains(text));
    CHECK(blocks.hashes() == before);
  };
  auto bad_poses = poses;
  bad_poses[7 * 3 + 1] = std::nan("");
  refused(blocks.handles, bad_poses, PALPATE_BAD_ARGUMENT, "simulation 3: its pose is none");
  auto twice = blocks.handles;
  twice[4] = twice[1];
  refused(twice, poses, PALPATE_BAD_ARGUMENT, "simulation 4: it is that of 1, too");
  twice[2] = nullptr;
  refused(twice, poses, PALPATE_BAD_ARGUMENT, "simulation 2: it is NULL");
  refused(blocks.handles, poses, PALPATE_BAD_ARGUMENT, "n negative", -1);
  states[2].size = 8;
  refused(blocks.handles, poses, PALPATE_BAD_ARGUMENT, "simulation 2: its state has another size");
  states[0].size = 0;
  refused(blocks.handles, poses, PALPATE_BAD_ARGUMENT, "simulation 0: a state whose size");
  CHECK(palpate_step_many(team.get(), nullptr, 2, 1, nullptr, nullptr, &error) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_step_many(team.get(), blocks.handles.data(), -1, 1, nullptr, nullptr, &error) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_step_many(team.get(), blocks.handles.data(), 70000, 1, nullptr, nullptr, &error) ==
        PALPATE_BAD_ARGUMENT);
  palpate_team* none = nullptr;
  CHECK(palpate_team_create(-1, &none, &error) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_team_create(65, &none, &error) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_team_create(1, nullptr, &error) == PALPATE_BAD_ARGUMENT);
  palpate_team_destroy(nullptr);
  CHECK(blocks.hashes() == before);

  // One that runs by itself.
  states = sizedStates();
  palpate_simulation* const running = blocks.handles[1];
  REQUIRE(palpate_start(running, PALPATE_ORDINARY_THREAD) == PALPATE_OK);
  CHECK(palpate_step_many(team.get(), blocks.handles.data(), Blocks::count, 1, nullptr, states.data(), &error) ==
        PALPATE_BUSY);
  CHECK_THAT(error.text, Catch::Contains("simulation 1: it runs"));
  REQUIRE(palpate_stop(running) == PALPATE_OK);
  CHECK(hashOf(blocks.simulations[0]) == before[0]);
  CHECK(hashOf(blocks.simulations[4]) == before[4]);
}
