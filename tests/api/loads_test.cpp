#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "api/handles.h"
#include "api/pressed_block.h"
#include "io/output_file.h"
#include "realtime/recording/recording_file.h"
#include "support/realtime_guard.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::test;

namespace {

constexpr double earth[3] = {0, 0, -9.81};

}  // namespace

TEST_CASE("Gravity that is set live is a scene's own, and the base bears the tissue's weight", "[api][loads]") {
  const ModelHandle model = loadBlock(damped_text);
  const ModelHandle heavy = loadBlock(damped_text + "gravity = [0, 0, -9.81]\n");
  const palpate_model_info info = describe(model);
  const SimulationHandle live = create(model), own = create(heavy), freed = create(heavy), light = create(model);
  REQUIRE(palpate_set_gravity(live.get(), earth) == PALPATE_OK);
  const double none[3] = {0, 0, 0};
  REQUIRE(palpate_set_gravity(freed.get(), none) == PALPATE_OK);
  for (const SimulationHandle* one : {&live, &own, &freed})
    REQUIRE(palpate_step(one->get(), 400, nullptr, nullptr) == PALPATE_OK);
  const double weight = 0.06 * 0.06 * 0.03 * 1000 * 9.81;
  CHECK(baseForce(live) == Approx(weight).epsilon(0.02));
  const std::vector<float> a = skinOf(live, info), b = skinOf(own, info), c = skinOf(freed, info),
                           rest = skinOf(light, info);
  double sag = 0, difference = 0, left = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    sag = std::max(sag, std::abs(static_cast<double>(b[k]) - rest[k]));
    difference = std::max(difference, std::abs(static_cast<double>(a[k]) - b[k]));
    left = std::max(left, std::abs(static_cast<double>(c[k]) - rest[k]));
  }
  CHECK(sag > 1e-4);
  CHECK(difference < 1e-3 * sag);
  CHECK(left < 1e-3 * sag);
}

TEST_CASE("A force at the skin is borne by the base, and gone when it is set to 0", "[api][loads]") {
  const ModelHandle model = loadBlock(damped_text);
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  const std::vector<float> rest = skinOf(simulation, info);
  const std::int32_t vertex = upperVertex(rest);
  const std::size_t z = 3 * static_cast<std::size_t>(vertex) + 2;
  const double down[3] = {0, 0, -0.05}, none[3] = {0, 0, 0};
  REQUIRE(palpate_set_force(simulation.get(), vertex, down) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 400, nullptr, nullptr) == PALPATE_OK);
  CHECK(baseForce(simulation) == Approx(0.05).epsilon(0.02));
  CHECK(skinOf(simulation, info)[z] < rest[z] - 1e-4F);
  REQUIRE(palpate_set_force(simulation.get(), vertex, none) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 600, nullptr, nullptr) == PALPATE_OK);
  CHECK(std::abs(baseForce(simulation)) < 1e-4);
  CHECK(skinOf(simulation, info)[z] == Approx(rest[z]).margin(1e-6));
}

TEST_CASE("Loads are part of the state: hashed, saved, kept in a reset, and taken back", "[api][loads]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model), other = create(model), never = create(model);
  const std::uint64_t at_rest = hashOf(simulation);
  const double push[3] = {0.01, 0, 0}, none[3] = {0, 0, 0};
  REQUIRE(palpate_set_force(simulation.get(), 7, push) == PALPATE_OK);
  REQUIRE(palpate_set_force(simulation.get(), 3, push) == PALPATE_OK);
  REQUIRE(palpate_set_gravity(simulation.get(), earth) == PALPATE_OK);
  const std::uint64_t loaded = hashOf(simulation);
  CHECK(loaded != at_rest);
  press(simulation, info, 0, 20);
  copyState(simulation, other);
  press(simulation, info, 20, 40), press(other, info, 20, 40);
  CHECK(hashOf(other) == hashOf(simulation));
  // The other one knows which forces there are.
  for (const SimulationHandle* one : {&simulation, &other}) {
    REQUIRE(palpate_set_force(one->get(), 7, none) == PALPATE_OK);
    press(*one, info, 40, 45);
  }
  CHECK(hashOf(other) == hashOf(simulation));

  REQUIRE(palpate_set_force(simulation.get(), 7, push) == PALPATE_OK);
  REQUIRE(palpate_reset(simulation.get()) == PALPATE_OK);
  CHECK(hashOf(simulation) == loaded);
  const double force_on_all[3] = {0, 0, 0.1};
  REQUIRE(palpate_set_force(simulation.get(), -1, force_on_all) == PALPATE_BAD_ARGUMENT);  // it would end the others
  REQUIRE(palpate_set_force(simulation.get(), -1, nullptr) == PALPATE_OK);
  REQUIRE(palpate_set_gravity(simulation.get(), none) == PALPATE_OK);
  CHECK(hashOf(simulation) == at_rest);
  press(simulation, info, 0, 20), press(never, info, 0, 20);
  CHECK(hashOf(simulation) == hashOf(never));
}

TEST_CASE("A load that can't be meant is refused and changes nothing", "[api][loads]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle handle = create(model);
  palpate_simulation* const simulation = handle.get();
  press(handle, info, 0, 20);
  const std::uint64_t before = hashOf(handle);
  const double push[3] = {0, 0, 1e-4}, endless[3] = {0, HUGE_VAL, 0}, much[3] = {0, 0, 1001};
  CHECK(palpate_set_gravity(simulation, nullptr) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_gravity(simulation, endless) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_gravity(simulation, much) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_gravity(nullptr, push) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_force(simulation, 0, nullptr) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_force(simulation, 0, endless) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_force(simulation, -2, push) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_force(simulation, info.skin_vertex_count, push) == PALPATE_BAD_ARGUMENT);
  CHECK(hashOf(handle) == before);
  for (std::int32_t v = 0; v < 64; ++v) REQUIRE(palpate_set_force(simulation, (7 * v) % 64, push) == PALPATE_OK);
  const std::uint64_t full = hashOf(handle);
  CHECK(palpate_set_force(simulation, 64, push) == PALPATE_REFUSED);
  CHECK(hashOf(handle) == full);
  REQUIRE(palpate_set_force(simulation, 5, push) == PALPATE_OK);  // one that is there
  CHECK(hashOf(handle) == full);

  if (!guardAvailable()) return;
  startGuard();
  std::int32_t code = palpate_step(simulation, 3, nullptr, nullptr);
  code |= palpate_set_force(simulation, 5, push);
  code |= palpate_set_gravity(simulation, earth);
  const GuardCounts counts = stopGuard();
  CHECK(code == PALPATE_OK);
  CHECK(counts.total() == 0);
}

TEST_CASE("Loads are recorded, written and replayed bit for bit", "[api][loads]") {
  const ModelHandle handle = loadBlock();
  const Model& model = *handle->model;
  Recording recording;
  recording.scene = "block";
  recording.rate_hz = model.scene.dynamics.rate_hz;
  recording.ticks = 60;
  TissuePhysics played(model, 1);
  {
    SimulationLoopOptions options;
    options.record = true;
    SimulationLoop loop(model, played, &played.team(), options);
    const auto ask = [&](const Request& request, int ticks) {
      REQUIRE(loop.commands().push(request));
      loop.advanceHere(0);
      loop.advanceHere(ticks);
    };
    ask(Request::setForce(7, Vec3(0, 0.005, 0)), 10);
    ask(Request::setForce(7, Vec3(0, 0.01, 0)), 10);
    ask(Request::setGravity(Vec3(0, 0, -9.81)), 20);
    ask(Request::setForce(-1, Vec3::Zero()), 20);
    for (TimedRequest change; loop.recorded().pop(change);) recording.changes.push_back(change);
  }
  CHECK(recording.changes.size() == 4);
  const TempFolder folder;
  writeWholeFile(folder.path("run.rec"), toText(recording));
  SimulationLoopOptions options;
  options.as_fast_as_possible = true;
  options.track = readRecording(folder.path("run.rec")).changes;
  options.track_ticks = options.tick_limit = 60;
  TissuePhysics replayed(model, 1);
  SimulationLoop loop(model, replayed, &replayed.team(), options);
  loop.run();
  CHECK(replayed.stateHash() == played.stateHash());
  std::vector<LogEvent::Kind> told;
  for (LogEvent event; loop.log().pop(event);) told.push_back(event.kind);
  using Kind = LogEvent::Kind;
  CHECK(told == std::vector{Kind::ForceSet, Kind::GravitySet, Kind::ForceSet, Kind::TrackEnded});  // once each
  CHECK(replayed.state().live.loads.gravity.z() == -9.81);
  CHECK(replayed.state().live.loads.forces.count == 0);
}
