// How a run ends before its time: within a tick, or because the motion of its tool is over.

#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>
#include <thread>

#include "realtime/loop_run.h"
#include "realtime/recording/recording.h"
#include "simulation/model_hash.h"
#include "simulation/step.h"
#include "support/small_scene.h"

using namespace palpate;
using namespace palpate::test;

namespace {

/// Goes through given poses and counts how often it began.
class ListedMotion final : public ToolMotion {
 public:
  explicit ListedMotion(std::vector<Pose> poses) : poses_(std::move(poses)) {}
  int restarts = 0;

  Pose next(const State&, const StepReport&) override { return poses_[std::min(at_++, poses_.size() - 1)]; }
  void restart() override {
    at_ = 0;
    ++restarts;
  }

 private:
  std::vector<Pose> poses_;
  std::size_t at_ = 0;
};

/// The real physics; says when its first tick begins, and whether one was cut short.
class WatchedPhysics final : public Physics {
 public:
  explicit WatchedPhysics(const Model& model) : physics_(model, 1) {}
  std::atomic<bool> entered{false};
  bool cut_short = false;

  StepReport tick(const Command& command) override {
    entered = true;
    const StepReport report = physics_.tick(command);
    cut_short = cut_short || report.cut_short;
    return report;
  }
  const State& state() const override { return physics_.state(); }
  std::uint64_t stateHash() const override { return physics_.stateHash(); }
  void reset() override { physics_.reset(); }
  void restore(const State& past) override { physics_.restore(past); }
  void setFriction(double coefficient) override { physics_.setFriction(coefficient); }
  double setMaterial(int index, const Material& material) override { return physics_.setMaterial(index, material); }

 private:
  TissuePhysics physics_;
};

}  // namespace

TEST_CASE("A tick that quitting broke off never was: not counted, not recorded, no force", "[simulation_loop]") {
  const Model model = smallModel();
  FakePhysics physics(model);
  physics.on_tick = [&](State&, StepReport& report) {
    report.cut_short = physics.calls == 31;
    if (report.cut_short) report.flags = kBlowUp, report.tool_force = Vec3(0, 0, 1e9);
  };
  SimulationLoopOptions options = limited(300);
  options.record = true;
  options.track = trackFromPoses(wander(300, 4));
  SimulationLoop loop(model, physics, nullptr, options);
  FakeClock clock;
  loop.run(clock);
  CHECK(physics.calls == 31);
  CHECK(loop.summary().ticks == 30);
  CHECK(loop.summary().flags == 0);
  CHECK(loop.summary().peak_force < 1e9);
  CHECK(loop.statistics().ticks == 30);
  CHECK(drain(loop.forces()).size() == 30);
  CHECK(loop.snapshots().latest().status.ticks == 30);
  const std::vector<TimedRequest> recorded = drain(loop.recorded());
  REQUIRE(recorded.size() == 30);
  CHECK(recorded.back().tick == 29);
}

TEST_CASE("A tick of many steps ends where it is asked to, and leaves the state of before", "[tissue_physics]") {
  Model model = blockModel();
  model.substeps_per_tick = 100'000'000;  // an hour of computing
  WatchedPhysics physics(model);
  const std::uint64_t before = physics.stateHash();
  SimulationLoopOptions options;
  options.as_fast_as_possible = true;
  SimulationLoop loop(model, physics, nullptr, options);
  loop.commands().push(Request::moveTool(toolAt(model, 0.01)));
  CHECK_FALSE(physics.cut_short);
  loop.start();
  while (!physics.entered) std::this_thread::yield();  // the first tick has begun
  loop.quit();
  loop.join();
  CHECK(physics.cut_short);
  CHECK(loop.summary().ticks == 0);
  CHECK(loop.summary().state_hash == before);
  CHECK(physics.state().step == 0);
  CHECK(physics.state().tool_pose.position == model.tool_start.position);
}

TEST_CASE("What a long tick leaves does not depend on whether it could have been cut short", "[tissue_physics]") {
  Model model = blockModel();
  const int fewer = model.substeps_per_tick;
  model.substeps_per_tick = 100;
  model.dt *= fewer / 100.0;
  TissuePhysics physics(model, 1);
  State state = initialState(model);
  Workspace workspace(model, 1);
  const std::atomic<bool> never{false};
  for (int k = 1; k <= 5; ++k) {
    Command command;
    command.tool_target = toolAt(model, model.first_contact_travel + 1e-4 * k);
    tick(model, state, command, workspace);
    command.stop = &never;
    CHECK_FALSE(physics.tick(command).cut_short);
  }
  CHECK(physics.stateHash() == stateHash(model, state));

  // Stopped at once, and taken up again.
  const std::atomic<bool> at_once{true};
  Command command;
  command.tool_target = toolAt(model, model.first_contact_travel + 1e-3);
  command.stop = &at_once;
  CHECK(physics.tick(command).cut_short);
  CHECK(physics.stateHash() == stateHash(model, state));
  command.stop = nullptr;
  physics.tick(command);
  tick(model, state, command, workspace);
  CHECK(physics.stateHash() == stateHash(model, state));
}

TEST_CASE("A motion that ends is a track: the same state, then the viewer has the tool, a reset begins it again",
          "[simulation_loop]") {
  const Model model = smallModel();
  const std::vector<Pose> poses = wander(120, 6);
  std::vector<std::uint64_t> hashes;
  for (const bool as_track : {true, false}) {
    FakePhysics physics(model);
    ListedMotion motion(poses);
    SimulationLoopOptions options = limited(400);
    if (as_track) {
      options.track = trackFromPoses(poses);
    } else {
      options.motion = &motion;
      options.track_ticks = 120;
    }
    SimulationLoop loop(model, physics, nullptr, options);
    FakeClock clock;
    std::vector<std::uint64_t> on_the_way;
    const Vec3 wanted(0.02, 0.01, 0.1);
    clock.before_sleep = [&](int sleep) {
      if (sleep == 50) loop.commands().push(Request::moveTool(poseAt(Vec3(1, 1, 1))));  // the script has it
      if (sleep == 119 || sleep == 130 || sleep == 299 || sleep == 399) on_the_way.push_back(physics.stateHash());
      if (sleep == 140) loop.commands().push(Request::moveTool(poseAt(wanted)));
      if (sleep == 200) loop.commands().push(Request::simple(Request::Kind::Reset));
    };
    loop.run(clock);
    CHECK(has(drain(loop.log()), LogEvent::Kind::TrackEnded));
    CHECK(motion.restarts == (as_track ? 0 : 1));
    hashes.insert(hashes.end(), on_the_way.begin(), on_the_way.end());
    hashes.push_back(loop.summary().state_hash);
  }
  REQUIRE(hashes.size() == 10);
  for (std::size_t k = 0; k < 5; ++k) CHECK(hashes[k] == hashes[k + 5]);
}
