// How a run goes on when the motion of its tool is over.

#include <catch2/catch.hpp>

#include "realtime/loop_run.h"
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

}  // namespace

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
