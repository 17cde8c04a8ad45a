// A cloud that follows the tool, through the library.

#include <catch2/catch.hpp>

#include "api/handles.h"
#include "api/pressed_block.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::test;

namespace {

const std::string bar_text = replaced(replaced(touched_block_text, "spacing = 0.012", "follow = true"),
                                      "size = [0.06, 0.06, 0.03]", "size = [0.12, 0.04, 0.03]");
constexpr int drag_ticks = 160;

/// Half a radius down within the first 40 ticks, then 35 mm along the bar.
std::array<double, 7> dragPose(const palpate_model_info& info, int tick) {
  const double down = std::min(1.0, tick / 40.0), along = std::max(0.0, (tick - 40.0) / (drag_ticks - 40));
  std::array<double, 7> pose{};
  std::copy_n(info.tool_start, 7, pose.begin());
  pose[0] += 0.035 * along;
  pose[2] -= (info.first_contact_travel + 0.005) * down;
  return pose;
}

/// What `palpate --fast` makes of the same poses.
std::uint64_t looped(const palpate_model_info& info) {
  const TempFolder folder;
  FollowingModel loaded = loadFollowing(readScene(folder.write("bar.toml", bar_text)));
  auto make = [places = loaded.places](const PlaceIndex& index) { return makePlace(*places, index); };
  FollowingTissue tissue(loaded.places, std::move(loaded.start), make, 2, false);
  SimulationLoopOptions options;
  options.follower = &tissue.follower;
  options.as_fast_as_possible = true;
  options.tick_limit = drag_ticks;
  std::vector<Pose> poses;
  for (int k = 1; k <= drag_ticks; ++k) {
    const auto p = dragPose(info, k);
    poses.push_back({Vec3(p[0], p[1], p[2]), Quat(p[6], p[3], p[4], p[5])});
  }
  options.track = trackFromPoses(poses);
  SimulationLoop loop(tissue.model(), tissue.physics, &tissue.physics.team(), options);
  loop.run();
  CHECK(loop.summary().follow->swaps >= 1);
  return tissue.physics.stateHash();
}

}  // namespace

TEST_CASE("A program's steps on a cloud that follows have the bits of palpate --fast", "[api][following][whole]") {
  const ModelHandle model = loadBlock(bar_text);
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  auto state = sized<palpate_state>();
  for (int k = 1; k <= drag_ticks; ++k)
    REQUIRE(palpate_step(simulation.get(), 1, dragPose(info, k).data(), &state) == PALPATE_OK);
  CHECK(state.contact_count > 0);
  CHECK(simulation->physics.place()->place.index != model->start->index);
  CHECK(hashOf(simulation) == looped(info));

  std::vector<float> skin(static_cast<std::size_t>(3 * info.skin_vertex_count));
  REQUIRE(palpate_skin_positions(simulation.get(), skin.data(), info.skin_vertex_count) == PALPATE_OK);
  auto below = sized<palpate_skin_point>();
  const double above[3] = {state.pose[0], state.pose[1], 0.1}, down[3] = {0, 0, -1};
  REQUIRE(palpate_ray(simulation.get(), above, down, &below) == PALPATE_OK);
  CHECK(below.point[2] == Approx(state.pose[2]).margin(1e-4));  // the tip is on the skin
}

TEST_CASE("What a cloud that follows can't answer is refused with what to do", "[api][following][whole]") {
  const ModelHandle model = loadBlock(bar_text);
  const SimulationHandle simulation = create(model);
  auto error = sized<palpate_error>();
  const double x[3] = {0, 0, 0.01};
  palpate_points* points = nullptr;
  palpate_equilibrium* equilibrium = nullptr;
  for (const std::int32_t code : {palpate_points_create(model.get(), x, 1, &points, &error),
                                  palpate_points_of(model.get(), PALPATE_NODES, &points, &error),
                                  palpate_settle(model.get(), nullptr, 0, 1, &equilibrium, &error)}) {
    CHECK(code == PALPATE_REFUSED);
    CHECK_THAT(error.text, Catch::Contains("follows the tool") && Catch::Contains("discretization.spacing"));
  }
  CHECK(palpate_save_size(simulation.get()) == 0);
  char byte = 0;
  CHECK(palpate_save(simulation.get(), &byte, 1) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_restore(simulation.get(), &byte, 1, &error) == PALPATE_REFUSED);
}
