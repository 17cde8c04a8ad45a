#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstring>
#include <thread>
#include <vector>

#include "api/palpate_device.h"
#include "api/pressed_block.h"
#include "support/realtime_guard.h"

using namespace palpate;
using namespace palpate::test;

namespace {

/// What a call has seen and done.
struct Seen {
  palpate_simulation* simulation = nullptr;
  std::vector<palpate_state> states;
  std::atomic<std::int64_t> calls{0};
  std::atomic<int> not_refused{0}, not_answered{0};
  std::uint64_t hash = 0;
  std::vector<char> saved;
};

void keep(void* user, const palpate_state* state) { static_cast<Seen*>(user)->states.push_back(*state); }

/// Tries what it must not, and what it may.
void meddle(void* user, const palpate_state* state) {
  Seen& seen = *static_cast<Seen*>(user);
  ++seen.calls;
  palpate_simulation* const simulation = seen.simulation;
  const double young = 2000, pose[7] = {0, 0, 0.05, 0, 0, 0, 1};
  const palpate_parameter softer{"young", &young, 1};
  palpate_simulation* const one[] = {simulation};
  char byte = 0;
  for (const std::int32_t code :
       {palpate_step(simulation, 1, pose, nullptr), palpate_start(simulation, PALPATE_ORDINARY_THREAD),
        palpate_stop(simulation), palpate_reset(simulation), palpate_restore(simulation, &byte, 1, nullptr),
        palpate_set_friction(simulation, 0.3), palpate_set_material(simulation, 0, &softer, 1, nullptr),
        palpate_pull(simulation, 0, pose), palpate_on_tick(simulation, nullptr, nullptr),
        palpate_couple(simulation, nullptr, nullptr), palpate_uncouple(simulation),
        palpate_step_many(nullptr, one, 1, 1, nullptr, nullptr, nullptr)})
    seen.not_refused += code != PALPATE_REFUSED;
  palpate_destroy(simulation);
  auto newest = sized<palpate_state>();
  double force[3];
  seen.not_answered += palpate_read(simulation, &newest) != PALPATE_OK || newest.tick != state->tick;
  seen.not_answered += palpate_hash(simulation, &seen.hash) != PALPATE_OK;
  seen.not_answered += palpate_reactions(simulation, force, nullptr, 1) != PALPATE_OK;
  if (state->tick == 20 && !seen.saved.empty())
    seen.not_answered += palpate_save(simulation, seen.saved.data(), seen.saved.size()) != PALPATE_OK;
}

}  // namespace

TEST_CASE("A call after each tick has its outcome, and changes nothing by being there", "[api][tick_call]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle told = create(model), alone = create(model);
  Seen seen;
  REQUIRE(palpate_on_tick(told.get(), keep, &seen) == PALPATE_OK);
  const auto pose = poseAtDepth(info, 0.002);
  auto last = sized<palpate_state>();
  REQUIRE(palpate_step(told.get(), 30, pose.data(), &last) == PALPATE_OK);
  REQUIRE(seen.states.size() == 30);
  for (std::size_t k = 0; k < 30; ++k) {
    auto state = sized<palpate_state>();
    REQUIRE(palpate_step(alone.get(), 1, k == 0 ? pose.data() : nullptr, &state) == PALPATE_OK);
    CHECK(seen.states[k].tick == state.tick);
    CHECK(std::memcmp(seen.states[k].force, state.force, sizeof state.force) == 0);
  }
  CHECK(seen.states.back().force[2] > 0);
  CHECK(hashOf(told) == hashOf(alone));
  REQUIRE(palpate_on_tick(told.get(), nullptr, nullptr) == PALPATE_OK);
  REQUIRE(palpate_step(told.get(), 5, nullptr, nullptr) == PALPATE_OK);
  CHECK(seen.states.size() == 30);
  CHECK(palpate_on_tick(nullptr, keep, &seen) == PALPATE_BAD_ARGUMENT);
}

TEST_CASE("A call that throws ends its step, and no more", "[api][tick_call]") {
  const ModelHandle model = loadBlock();
  const SimulationHandle simulation = create(model);
  REQUIRE(palpate_on_tick(
              simulation.get(), [](void*, const palpate_state*) { throw std::runtime_error("no more"); }, nullptr) ==
          PALPATE_OK);
  CHECK(palpate_step(simulation.get(), 3, nullptr, nullptr) == PALPATE_FAILED);
  CHECK(std::string(palpate_last_error()) == "no more");
  REQUIRE(palpate_on_tick(simulation.get(), nullptr, nullptr) == PALPATE_OK);
  auto state = sized<palpate_state>();
  CHECK(palpate_step(simulation.get(), 1, nullptr, &state) == PALPATE_OK);
  CHECK(state.tick == 2);
}

TEST_CASE("In such a call all may be asked and nothing changed, stepped or running", "[api][tick_call]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model), alone = create(model), other = create(model);
  Seen seen;
  seen.simulation = simulation.get();
  seen.saved.resize(palpate_save_size(simulation.get()));
  REQUIRE(palpate_on_tick(simulation.get(), meddle, &seen) == PALPATE_OK);
  press(simulation, info, 0, 40), press(alone, info, 0, 40);
  CHECK(seen.calls == 40);
  CHECK(seen.not_refused == 0);
  CHECK(seen.not_answered == 0);
  CHECK(seen.hash == hashOf(simulation));
  CHECK(hashOf(simulation) == hashOf(alone));
  REQUIRE(palpate_restore(other.get(), seen.saved.data(), seen.saved.size(), nullptr) == PALPATE_OK);
  press(other, info, 20, 40);
  CHECK(hashOf(other) == hashOf(alone));

  REQUIRE(palpate_start(simulation.get(), PALPATE_ORDINARY_THREAD) == PALPATE_OK);
  CHECK(palpate_on_tick(simulation.get(), nullptr, nullptr) == PALPATE_BUSY);
  for (int k = 0; k < 5000 && seen.calls < 60; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  REQUIRE(palpate_stop(simulation.get()) == PALPATE_OK);
  CHECK(seen.calls >= 60);
  CHECK(seen.not_refused == 0);
  CHECK(seen.not_answered == 0);
  CHECK(seen.hash == hashOf(simulation));
}

TEST_CASE("A tick with a call takes no lock and allocates nothing", "[api][tick_call]") {
  if (!guardAvailable()) return;
  const ModelHandle model = loadBlock();
  const SimulationHandle simulation = create(model);
  std::int64_t calls = 0;
  const auto count = [](void* user, const palpate_state*) { ++*static_cast<std::int64_t*>(user); };
  REQUIRE(palpate_on_tick(simulation.get(), count, &calls) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 2, nullptr, nullptr) == PALPATE_OK);
  startGuard();
  const std::int32_t code = palpate_step(simulation.get(), 5, nullptr, nullptr);
  const GuardCounts counts = stopGuard();
  CHECK(code == PALPATE_OK);
  CHECK(counts.total() == 0);
  CHECK(calls == 7);
}

TEST_CASE("A spring draws a vertex of the skin to a place until it is let go", "[api]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle handle = create(model);
  palpate_simulation* const simulation = handle.get();
  const double above[3] = {0, 0, 0.03};
  auto top = sized<palpate_skin_point>();
  REQUIRE(palpate_closest(simulation, above, &top) == PALPATE_OK);
  std::vector<std::int32_t> corners(3 * static_cast<std::size_t>(info.skin_triangle_count));
  REQUIRE(palpate_skin_triangles(model.get(), corners.data(), info.skin_triangle_count) == PALPATE_OK);
  const std::int32_t vertex = corners[3 * static_cast<std::size_t>(top.triangle)];
  std::vector<float> skin(3 * static_cast<std::size_t>(info.skin_vertex_count));
  const auto height = [&] {
    REQUIRE(palpate_skin_positions(simulation, skin.data(), info.skin_vertex_count) == PALPATE_OK);
    return skin[3 * static_cast<std::size_t>(vertex) + 2];
  };
  const float rest = height();
  const std::uint64_t before = hashOf(handle);
  const double place[3] = {skin[3 * static_cast<std::size_t>(vertex)], skin[3 * static_cast<std::size_t>(vertex) + 1],
                           0.033};
  const double endless[3] = {0, 0, HUGE_VAL};
  CHECK(palpate_pull(simulation, info.skin_vertex_count, place) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_pull(simulation, -2, place) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_pull(simulation, vertex, endless) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_pull(simulation, vertex, nullptr) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_pull(nullptr, vertex, place) == PALPATE_BAD_ARGUMENT);
  CHECK(hashOf(handle) == before);
  REQUIRE(palpate_pull(simulation, vertex, place) == PALPATE_OK);
  REQUIRE(palpate_step(simulation, 300, nullptr, nullptr) == PALPATE_OK);
  CHECK(height() > rest + 0.001F);
  double force[3];
  REQUIRE(palpate_reactions(simulation, force, nullptr, 1) == PALPATE_OK);
  CHECK(force[2] < -0.01);  // the base holds it down
  REQUIRE(palpate_pull(simulation, -1, nullptr) == PALPATE_OK);
  REQUIRE(palpate_step(simulation, 500, nullptr, nullptr) == PALPATE_OK);
  CHECK(height() == Approx(rest).margin(1e-5));
}
