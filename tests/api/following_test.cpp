// A cloud that follows the tool, through the library.

#include <catch2/catch.hpp>

#include "api/handles.h"
#include "api/pressed_block.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "realtime/loop_run.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::test;

namespace {

const std::string bar_text = replaced(replaced(touched_block_text, "spacing = 0.012", ""), "size = [0.06, 0.06, 0.03]",
                                      "size = [0.12, 0.04, 0.03]");
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
  FollowingTissue tissue(loadFollowing(readScene(folder.write("bar.toml", bar_text))), 2, false);
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
  CHECK(simulation->physics.place()->place.index != model->places->start()->index);
  CHECK(hashOf(simulation) == looped(info));

  std::vector<float> skin(static_cast<std::size_t>(3 * info.skin_vertex_count));
  REQUIRE(palpate_skin_positions(simulation.get(), skin.data(), info.skin_vertex_count) == PALPATE_OK);
  auto below = sized<palpate_skin_point>();
  const double above[3] = {state.pose[0], state.pose[1], 0.1}, down[3] = {0, 0, -1};
  REQUIRE(palpate_ray(simulation.get(), above, down, &below) == PALPATE_OK);
  CHECK(below.point[2] == Approx(state.pose[2]).margin(2e-4));  // the tip is on the skin
}

TEST_CASE("Fields, equilibria and saved states of a cloud that follows are those of where the tool is",
          "[api][following][whole]") {
  const ModelHandle model = loadBlock(bar_text);
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model), other = create(model);
  auto state = sized<palpate_state>();
  auto error = sized<palpate_error>();
  const auto dragTo = [&](const SimulationHandle& of, int from, int to) {
    for (int k = from; k <= to; ++k) REQUIRE(palpate_step(of.get(), 1, dragPose(info, k).data(), &state) == PALPATE_OK);
  };
  // The displacement of the skin at its own vertices, before and after the nodes are others.
  const auto count = info.skin_vertex_count;
  std::vector<double> X(static_cast<std::size_t>(3 * count)), u(X.size());
  std::vector<float> at_rest(X.size()), skin(X.size());
  REQUIRE(palpate_skin_positions(simulation.get(), at_rest.data(), count) == PALPATE_OK);
  X.assign(at_rest.begin(), at_rest.end());
  palpate_points* points = nullptr;
  REQUIRE(palpate_points_create(model.get(), X.data(), count, &points, &error) == PALPATE_OK);
  int last = 0;
  for (const int k : {60, drag_ticks}) {
    dragTo(simulation, last + 1, k);
    last = k;
    REQUIRE(palpate_skin_positions(simulation.get(), skin.data(), count) == PALPATE_OK);
    REQUIRE(palpate_displacements(simulation.get(), points, u.data(), count) == PALPATE_OK);
    double furthest = 0, worst = 0;
    for (std::size_t c = 0; c < u.size(); ++c) {
      furthest = std::max(furthest, std::abs(u[c]));
      worst = std::max(worst, std::abs(X[c] + u[c] - static_cast<double>(skin[c])));
    }
    CHECK(furthest > 0.003);
    CHECK(worst < 1e-6);
  }
  REQUIRE(simulation->physics.place()->place.index != model->places->start()->index);

  // Saved at one place, gone on with from another.
  std::vector<char> saved(palpate_save_size(simulation.get()));
  CHECK(palpate_save_size(other.get()) == saved.size());
  REQUIRE(palpate_save(simulation.get(), saved.data(), saved.size()) == PALPATE_OK);
  REQUIRE(palpate_restore(other.get(), saved.data(), saved.size(), &error) == PALPATE_OK);
  CHECK(hashOf(other) == hashOf(simulation));
  dragTo(simulation, 100, 120);
  dragTo(other, 100, 120);
  CHECK(hashOf(other) == hashOf(simulation));
  saved[saved.size() - 1] ^= 1;
  CHECK(palpate_restore(other.get(), saved.data(), saved.size(), &error) == PALPATE_BAD_INPUT);

  // At rest where it was dragged to: by the same nodes.
  for (int k = 0; k < 600; ++k)
    REQUIRE(palpate_step(simulation.get(), 1, dragPose(info, drag_ticks).data(), &state) == PALPATE_OK);
  palpate_equilibrium* settled = nullptr;
  REQUIRE(palpate_settle(model.get(), dragPose(info, drag_ticks).data(), 0, 1, &settled, &error) == PALPATE_OK);
  auto force = sized<palpate_quantity>();
  force.kind = PALPATE_TOOL_FORCE;
  force.direction[2] = 1;
  double value = 0;
  REQUIRE(palpate_equilibrium_value(settled, &force, &value, &error) == PALPATE_OK);
  CHECK(value == Approx(state.force[2]).epsilon(2e-3));
  palpate_equilibrium_destroy(settled);
  palpate_points_destroy(points);
}

TEST_CASE("A saved state has the same size at all places, also of tissue that relaxes", "[api][following][whole]") {
  const ModelHandle model = loadBlock(replaced(bar_text, "[[material]]", "[[material]]\nrelaxation = [[0.3, 0.1]]"));
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model), other = create(model);
  for (int k = 1; k <= drag_ticks; ++k)
    REQUIRE(palpate_step(simulation.get(), 1, dragPose(info, k).data(), nullptr) == PALPATE_OK);
  REQUIRE(simulation->physics.place()->place.index != model->places->start()->index);
  CHECK(palpate_save_size(other.get()) == palpate_save_size(simulation.get()));
  copyState(simulation, other);
  CHECK(hashOf(other) == hashOf(simulation));
}
