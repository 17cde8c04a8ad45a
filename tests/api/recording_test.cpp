#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <thread>

#include "api/handles.h"
#include "api/pressed_block.h"
#include "realtime/recording/recording_file.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::test;

namespace {

/// What `palpate --replay` makes of a recording.
std::uint64_t replayed(const ModelHandle& handle, const std::string& file) {
  const Model& model = *handle->model;
  Recording recording = readRecording(file);
  checkRecordingFits(recording, model, file);
  SimulationLoopOptions options;
  options.as_fast_as_possible = true;
  options.track = std::move(recording.changes);
  options.track_ticks = options.tick_limit = recording.ticks;
  TissuePhysics physics(model, 1);
  SimulationLoop loop(model, physics, &physics.team(), options);
  loop.run();
  return physics.stateHash();
}

std::int32_t start(const SimulationHandle& simulation) { return palpate_record_start(simulation.get(), nullptr); }

/// All that can be asked of a simulation, while it is pressed.
void askAll(const SimulationHandle& handle, const palpate_model_info& info) {
  palpate_simulation* const simulation = handle.get();
  const double down[3] = {0.1, 0, -3}, push[3] = {0, 0.01, 0}, place[3] = {0.012, 0.02, 0.031}, shift[3] = {0, 3e-4, 0};
  const double young = 2500;
  const palpate_parameter softer{"young", &young, 1};
  press(handle, info, 0, 25);
  REQUIRE(palpate_set_gravity(simulation, down) == PALPATE_OK);
  REQUIRE(palpate_set_force(simulation, 7, push) == PALPATE_OK);
  press(handle, info, 25, 30);
  REQUIRE(palpate_pin(simulation, 5, place) == PALPATE_OK);
  REQUIRE(palpate_move_region(simulation, 0, shift) == PALPATE_OK);
  REQUIRE(palpate_set_friction(simulation, 0.2) == PALPATE_OK);
  press(handle, info, 30, 45);
  REQUIRE(palpate_set_material(simulation, 0, &softer, 1, nullptr) == PALPATE_OK);
  REQUIRE(palpate_pull(simulation, 9, place) == PALPATE_OK);
  press(handle, info, 45, 55);
  REQUIRE(palpate_pin(simulation, -1, nullptr) == PALPATE_OK);
  REQUIRE(palpate_pull(simulation, -1, nullptr) == PALPATE_OK);
  press(handle, info, 55, 60);
  REQUIRE(palpate_set_force(simulation, 7, nullptr) == PALPATE_BAD_ARGUMENT);
  REQUIRE(palpate_set_force(simulation, -1, nullptr) == PALPATE_OK);  // after the last tick
}

}  // namespace

TEST_CASE("What a program does is recorded and replayed bit for bit", "[api][recording]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model), unrecorded = create(model);
  const TempFolder folder;
  const std::string file = folder.path("run.rec");
  REQUIRE(start(simulation) == PALPATE_OK);
  askAll(simulation, info), askAll(unrecorded, info);
  CHECK(hashOf(simulation) == hashOf(unrecorded));  // to be recorded changes nothing
  REQUIRE(palpate_record_stop(simulation.get(), file.c_str(), nullptr) == PALPATE_OK);
  CHECK(readRecording(file).ticks == 60);
  CHECK(replayed(model, file) == hashOf(simulation));
}

TEST_CASE("A recording holds what was set before it began", "[api][recording]") {
  const ModelHandle model = loadBlock(touched_block_text + "[dynamics]\ngravity = [0, 0, -9.81]\n");
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  askAll(simulation, info);
  const double place[3] = {0.012, 0.02, 0.031};
  REQUIRE(palpate_pin(simulation.get(), 5, place) == PALPATE_OK);
  REQUIRE(palpate_reset(simulation.get()) == PALPATE_OK);
  REQUIRE(start(simulation) == PALPATE_OK);
  press(simulation, info, 0, 40);
  const TempFolder folder;
  REQUIRE(palpate_record_stop(simulation.get(), folder.path("run.rec").c_str(), nullptr) == PALPATE_OK);
  CHECK(replayed(model, folder.path("run.rec")) == hashOf(simulation));
}

TEST_CASE("What happens while a simulation runs by itself is recorded, too", "[api][recording]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  REQUIRE(start(simulation) == PALPATE_OK);
  REQUIRE(palpate_start(simulation.get(), PALPATE_ORDINARY_THREAD) == PALPATE_OK);
  const TempFolder folder;
  const std::string file = folder.path("run.rec");
  CHECK(palpate_record_stop(simulation.get(), file.c_str(), nullptr) == PALPATE_BUSY);
  auto state = sized<palpate_state>();
  const double push[3] = {0, 0.01, 0};
  for (std::uint64_t k = 0; k < 60; ++k) {
    const auto pose = poseAtDepth(info, -0.001 + 5e-5 * static_cast<double>(k));
    REQUIRE(palpate_set_target(simulation.get(), pose.data(), k) == PALPATE_OK);
    if (k == 20) REQUIRE(palpate_set_force(simulation.get(), 7, push) == PALPATE_OK);
    if (k == 40) REQUIRE(palpate_reset(simulation.get()) == PALPATE_OK);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  REQUIRE(palpate_stop(simulation.get()) == PALPATE_OK);
  press(simulation, info, 20, 50);
  REQUIRE(palpate_read(simulation.get(), &state) == PALPATE_OK);
  REQUIRE(palpate_record_stop(simulation.get(), file.c_str(), nullptr) == PALPATE_OK);
  CHECK(readRecording(file).ticks == state.tick);
  CHECK(replayed(model, file) == hashOf(simulation));
}

TEST_CASE("A recording that can't be is refused in a sentence, and nothing is lost or moved", "[api][recording]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle handle = create(model);
  palpate_simulation* const simulation = handle.get();
  auto error = sized<palpate_error>();
  const TempFolder folder;
  const std::string file = folder.path("run.rec");
  CHECK(palpate_record_start(nullptr, &error) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_record_stop(simulation, file.c_str(), &error) == PALPATE_REFUSED);
  CHECK_THAT(error.text, Catch::Contains("palpate_record_start first"));
  press(handle, info, 0, 20);
  const std::uint64_t before = hashOf(handle);
  CHECK(palpate_record_start(simulation, &error) == PALPATE_REFUSED);
  CHECK_THAT(error.text, Catch::Contains("palpate_reset first"));
  CHECK(hashOf(handle) == before);
  std::vector<char> bytes(palpate_save_size(simulation));
  REQUIRE(palpate_save(simulation, bytes.data(), bytes.size()) == PALPATE_OK);

  REQUIRE(palpate_reset(simulation) == PALPATE_OK);
  REQUIRE(palpate_record_start(simulation, &error) == PALPATE_OK);
  CHECK(palpate_record_start(simulation, &error) == PALPATE_REFUSED);
  press(handle, info, 0, 20);
  CHECK(palpate_restore(simulation, bytes.data(), bytes.size(), &error) == PALPATE_REFUSED);
  CHECK_THAT(error.text, Catch::Contains("palpate_record_stop first"));
  CHECK(palpate_reset(simulation) == PALPATE_REFUSED);
  CHECK(palpate_record_stop(simulation, folder.path("no/such/folder/run.rec").c_str(), &error) == PALPATE_FAILED);
  CHECK_THAT(error.text, Catch::Contains("can't write") && Catch::Contains("name another file"));
  // A full disk: what was recorded earlier stays.
  folder.write("run.rec", "earlier");
  std::filesystem::create_symlink("/dev/full", file + ".part");
  CHECK(palpate_record_stop(simulation, file.c_str(), &error) == PALPATE_FAILED);
  CHECK_THAT(error.text, Catch::Contains("No space left on device"));
  CHECK(readAll(file) == "earlier");
  CHECK(hashOf(handle) == before);
  press(handle, info, 20, 30);
  REQUIRE(palpate_record_stop(simulation, file.c_str(), &error) == PALPATE_OK);
  CHECK(replayed(model, file) == hashOf(handle));

  REQUIRE(palpate_reset(simulation) == PALPATE_OK);
  REQUIRE(palpate_record_start(simulation, &error) == PALPATE_OK);
  REQUIRE(palpate_record_stop(simulation, nullptr, &error) == PALPATE_OK);
  REQUIRE(palpate_record_start(simulation, &error) == PALPATE_OK);  // and destroyed so
}
