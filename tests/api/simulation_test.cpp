#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>
#include <vector>

#include "api/pressed_block.h"
#include "support/realtime_guard.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::test;

namespace {

Eigen::Vector3d vec(const double* v) { return Eigen::Vector3d(v[0], v[1], v[2]); }

/// All that is told but the age, which is wall time.
bool sameOutcome(palpate_state a, palpate_state b) {
  a.age_s = b.age_s = 0;
  a.fresh = b.fresh = 0;
  return std::memcmp(&a, &b, sizeof a) == 0;
}

/// What a simulation that was restored has not looked at yet.
palpate_state withoutExpectation(palpate_state state) {
  state.expected_error = 0;
  if (state.doubt == PALPATE_DOUBT_RESOLUTION) state.doubt = PALPATE_DOUBT_NONE;
  return state;
}

}  // namespace

TEST_CASE("Simulations of one model on two threads have the bits of one alone", "[api]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle alone = create(model), first = create(model), second = create(model);
  const palpate_state expected = press(alone, info, 0, 60);
  CHECK(expected.tick == 60);
  CHECK(expected.force[2] > 0);
  palpate_state a{}, b{};
  std::thread other([&] { a = press(first, info, 0, 60); });
  b = press(second, info, 0, 60);
  other.join();
  CHECK(sameOutcome(a, expected));
  CHECK(sameOutcome(b, expected));
  CHECK(hashOf(first) == hashOf(alone));
  CHECK(hashOf(second) == hashOf(alone));

  // A reset one, and one whose model's handle is gone.
  REQUIRE(palpate_reset(first.get()) == PALPATE_OK);
  CHECK(sameOutcome(press(first, info, 0, 60), expected));
  CHECK(hashOf(first) == hashOf(alone));
}

TEST_CASE("Many ticks in one call have the bits of one at a time, and a model may go before its simulations", "[api]") {
  ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle together = create(model), apart = create(model);
  model.reset();
  const auto pose = poseAtDepth(info, 0.002);
  auto a = sized<palpate_state>(), b = sized<palpate_state>();
  REQUIRE(palpate_step(together.get(), 40, pose.data(), &a) == PALPATE_OK);
  REQUIRE(palpate_step(apart.get(), 1, pose.data(), nullptr) == PALPATE_OK);
  for (int k = 1; k < 40; ++k) REQUIRE(palpate_step(apart.get(), 1, nullptr, &b) == PALPATE_OK);
  CHECK(sameOutcome(a, b));
  CHECK(hashOf(together) == hashOf(apart));
  CHECK(a.pose_sequence == 1);
}

TEST_CASE("Force, torque, normal, contacts and work agree with each other", "[api]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  double work = 0;
  palpate_state before = press(simulation, info, 0, 1);
  for (int k = 1; k < 100; ++k) {
    const palpate_state now = press(simulation, info, k, k + 1);
    work -= 0.5 * (vec(before.force) + vec(now.force)).dot(vec(now.pose) - vec(before.pose));
    before = now;
  }
  const palpate_state& state = before;
  const Eigen::Vector3d force = vec(state.force), normal = vec(state.normal);
  CHECK(normal.norm() == Approx(1));
  CHECK(normal.dot(force.normalized()) > 0.99);       // no friction
  CHECK(state.work_J == Approx(work).epsilon(1e-3));  // of steps, which are finer
  CHECK(state.work_J > 0);
  CHECK(state.stiffness > 0);
  CHECK(state.advance_m == Approx(-0.001 + 0.05 * 99 / info.rate_hz));

  std::vector<float> positions(3 * static_cast<std::size_t>(info.skin_vertex_count));
  REQUIRE(palpate_skin_positions(simulation.get(), positions.data(), info.skin_vertex_count) == PALPATE_OK);
  std::vector<std::int32_t> vertex(1000);
  std::vector<float> forces(3000);
  std::int32_t count = 0;
  REQUIRE(palpate_contacts(simulation.get(), vertex.data(), forces.data(), 1000, &count) == PALPATE_OK);
  REQUIRE(count > 0);
  REQUIRE(count <= 1000);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), torque = Eigen::Vector3d::Zero();
  for (std::size_t c = 0; c < static_cast<std::size_t>(count); ++c) {
    const Eigen::Vector3d f = Eigen::Map<Eigen::Vector3f>(&forces[3 * c]).cast<double>();
    const Eigen::Vector3d x =
        Eigen::Map<Eigen::Vector3f>(&positions[3 * static_cast<std::size_t>(vertex[c])]).cast<double>();
    sum -= f;
    torque -= (x - vec(state.pose)).cross(f);
  }
  CHECK((sum - force).norm() < 1e-5 * force.norm());
  CHECK((torque - vec(state.torque)).norm() < 1e-4 * info.tool_radius * force.norm());
  std::int32_t first = -1;
  REQUIRE(palpate_contacts(simulation.get(), &first, forces.data(), 1, &count) == PALPATE_OK);
  CHECK(first == vertex[0]);
}

TEST_CASE("A saved state goes on bit for bit, in its own simulation and in another", "[api]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model), other = create(model);
  const double young = 2000, poisson = 0.4;
  const palpate_parameter softer[] = {{"young", &young, 1}, {"poisson", &poisson, 1}};
  REQUIRE(palpate_set_material(simulation.get(), 0, softer, 2, nullptr) == PALPATE_OK);
  REQUIRE(palpate_set_friction(simulation.get(), 0.3) == PALPATE_OK);
  press(simulation, info, 0, 60);
  const std::uint64_t saved_hash = hashOf(simulation);
  std::vector<char> bytes(palpate_save_size(simulation.get()));
  REQUIRE(palpate_save(simulation.get(), bytes.data(), bytes.size()) == PALPATE_OK);
  const palpate_state expected = press(simulation, info, 60, 100);
  const std::uint64_t hash = hashOf(simulation);

  press(other, info, 0, 7);
  for (const SimulationHandle* one : {&simulation, &other}) {
    REQUIRE(palpate_restore(one->get(), bytes.data(), bytes.size(), nullptr) == PALPATE_OK);
    CHECK(hashOf(*one) == saved_hash);
    CHECK(sameOutcome(withoutExpectation(press(*one, info, 60, 100)), withoutExpectation(expected)));
    CHECK(hashOf(*one) == hash);
  }
  palpate_parameter parameter{};
  std::string names;
  for (int k = 0; k < 4; ++k) {
    REQUIRE(palpate_material_parameter(other.get(), 0, k, &parameter) == PALPATE_OK);
    if (parameter.name == nullptr) break;
    names.append(parameter.name).append("=").append(std::to_string(parameter.values[0])).append(" ");
  }
  CHECK(names == "young=2000.000000 poisson=0.400000 density=1000.000000 ");
  CHECK(palpate_material_parameter(other.get(), 1, 0, &parameter) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_material_parameter(other.get(), 0, -1, &parameter) == PALPATE_BAD_ARGUMENT);
  // What was set live came along: setting the same again changes nothing, setting another does.
  REQUIRE(palpate_set_friction(other.get(), 0.3) == PALPATE_OK);
  CHECK(hashOf(other) == hash);
  REQUIRE(palpate_set_friction(other.get(), 0) == PALPATE_OK);
  CHECK(hashOf(other) != hash);

  auto error = sized<palpate_error>();
  const auto refused = [&](const SimulationHandle& into, std::vector<char> changed, const char* text) {
    const std::uint64_t before = hashOf(into);
    CHECK(palpate_restore(into.get(), changed.data(), changed.size(), &error) == PALPATE_BAD_INPUT);
    CHECK_THAT(error.text, Catch::Contains(text));
    CHECK(hashOf(into) == before);
  };
  std::vector<char> damaged = bytes;
  damaged[damaged.size() / 2] ^= 1;
  refused(simulation, damaged, "damaged");
  damaged = bytes;
  damaged.pop_back();
  refused(simulation, damaged, "damaged");
  refused(simulation, {'n', 'o'}, "no bytes of palpate_save");
  const ModelHandle another = loadBlock(replaced(touched_block_text, "young = 3000", "young = 3001"));
  refused(create(another), bytes, "another model");
}

TEST_CASE("A simulation on its own thread answers the hand's newest pose, and goes on where it stopped", "[api]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  REQUIRE(palpate_start(simulation.get(), PALPATE_ORDINARY_THREAD) == PALPATE_OK);
  CHECK(palpate_start(simulation.get(), 0) == PALPATE_BUSY);
  auto state = sized<palpate_state>();
  CHECK(palpate_step(simulation.get(), 1, nullptr, &state) == PALPATE_BUSY);
  std::uint64_t hash = 0;
  CHECK(palpate_hash(simulation.get(), &hash) == PALPATE_BUSY);

  constexpr std::uint64_t last = 200;
  std::atomic<bool> done{false};
  std::atomic<int> wrong{0};
  std::thread reader([&] {
    std::int64_t tick = 0;
    while (!done) {
      auto seen = sized<palpate_state>();
      wrong += palpate_read(simulation.get(), &seen) != PALPATE_OK || seen.tick < tick || seen.pose_sequence > last;
      tick = seen.tick;
    }
  });
  std::vector<float> positions(3 * static_cast<std::size_t>(info.skin_vertex_count));
  for (std::uint64_t k = 1; k <= last; ++k) {
    const auto pose = poseAtDepth(info, 0.003 * static_cast<double>(k) / last);
    REQUIRE(palpate_set_target(simulation.get(), pose.data(), k) == PALPATE_OK);
    REQUIRE(palpate_skin_positions(simulation.get(), positions.data(), info.skin_vertex_count) == PALPATE_OK);
    if (k == last / 2) REQUIRE(palpate_set_friction(simulation.get(), 0.2) == PALPATE_OK);
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  while (state.pose_sequence < last || state.contact_count == 0)
    REQUIRE(palpate_read(simulation.get(), &state) == PALPATE_OK);
  done = true;
  reader.join();
  CHECK(wrong == 0);
  REQUIRE(palpate_stop(simulation.get()) == PALPATE_OK);
  REQUIRE(palpate_read(simulation.get(), &state) == PALPATE_OK);
  auto later = sized<palpate_state>();
  REQUIRE(palpate_step(simulation.get(), 3, nullptr, &later) == PALPATE_OK);
  CHECK(later.tick == state.tick + 3);
  CHECK(later.pose_sequence == last);
  REQUIRE(palpate_start(simulation.get(), PALPATE_ORDINARY_THREAD) == PALPATE_OK);
  while (state.tick < later.tick + 3) REQUIRE(palpate_read(simulation.get(), &state) == PALPATE_OK);
  CHECK(state.force[2] > 0);
}

TEST_CASE("Hand, readers and the steps themselves take no lock and allocate nothing", "[api]") {
  if (!guardAvailable()) return;
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  press(simulation, info, 0, 30);
  auto state = sized<palpate_state>();
  std::vector<float> positions(3 * static_cast<std::size_t>(info.skin_vertex_count)), forces(300);
  std::vector<std::int32_t> vertex(100);
  std::int32_t count = 0, code = 0;
  const auto pose = poseAtDepth(info, 0.002);
  startGuard();
  code |= palpate_set_target(simulation.get(), pose.data(), 7);
  code |= palpate_step(simulation.get(), 5, nullptr, &state);
  code |= palpate_read(simulation.get(), &state);
  code |= palpate_skin_positions(simulation.get(), positions.data(), info.skin_vertex_count);
  code |= palpate_contacts(simulation.get(), vertex.data(), forces.data(), 100, &count);
  code |= palpate_set_friction(simulation.get(), 0.1);
  const GuardCounts counts = stopGuard();
  CHECK(code == PALPATE_OK);
  CHECK(counts.total() == 0);
  CHECK(state.pose_sequence == 7);
  CHECK(count > 0);
}

TEST_CASE("What can't be used is told with its place, and leaves the caller's program alone", "[api]") {
  auto error = sized<palpate_error>();
  palpate_model* none = nullptr;
  const TempFolder folder;
  const std::string bad = folder.write("bad.toml", replaced(touched_block_text, "young = 3000", "young = -1"));
  CHECK(palpate_load(bad.c_str(), nullptr, &none, &error) == PALPATE_BAD_INPUT);
  CHECK(error.code == PALPATE_BAD_INPUT);
  CHECK_THAT(error.text, Catch::Contains("bad.toml:9:9: ") && Catch::Contains("young"));
  CHECK(none == nullptr);
  CHECK(palpate_load(folder.path("absent.toml").c_str(), nullptr, &none, &error) == PALPATE_BAD_INPUT);
  CHECK_THAT(error.text, Catch::Contains("absent.toml"));
  CHECK(palpate_load(nullptr, nullptr, &none, &error) == PALPATE_BAD_ARGUMENT);

  const std::string good = folder.write("block.toml", touched_block_text);
  auto options = sized<palpate_options>();
  options.progress = [](void*, const char*, double) { return 1; };
  CHECK(palpate_load(good.c_str(), &options, &none, &error) == PALPATE_REFUSED);
  options = {};
  CHECK(palpate_load(good.c_str(), &options, &none, &error) == PALPATE_BAD_ARGUMENT);
  CHECK_THAT(error.text, Catch::Contains("size"));
  options = sized<palpate_options>();
  options.rate_hz = 5;
  CHECK(palpate_load(good.c_str(), &options, &none, &error) == PALPATE_BAD_ARGUMENT);
  options = sized<palpate_options>();
  options.cache_folder = good.c_str();
  CHECK(palpate_load(good.c_str(), &options, &none, &error) == PALPATE_BAD_ARGUMENT);
  CHECK_THAT(error.text, Catch::Contains("block.toml\" can't be made"));

  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  std::int64_t count = 0;
  CHECK(palpate_script(model.get(), "no_such_script", nullptr, 0, &count, &error) == PALPATE_BAD_INPUT);
  CHECK_THAT(error.text, Catch::Contains("no_such_script"));
  const std::uint64_t rest = hashOf(simulation);
  auto pose = poseAtDepth(info, 0);
  pose[1] = std::nan("");
  CHECK(palpate_step(simulation.get(), 1, pose.data(), nullptr) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_target(simulation.get(), pose.data(), 1) == PALPATE_BAD_ARGUMENT);
  pose = {0, 0, 0, 0, 0, 0, 0};  // no turn at all
  CHECK(palpate_step(simulation.get(), 1, pose.data(), nullptr) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_step(nullptr, 1, nullptr, nullptr) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_friction(simulation.get(), -1) == PALPATE_BAD_ARGUMENT);
  palpate_state unsized{};
  CHECK(palpate_read(simulation.get(), &unsized) == PALPATE_BAD_ARGUMENT);

  const auto refused = [&](const char* name, double value, std::int32_t code, const char* text) {
    const palpate_parameter parameter{name, &value, 1};
    CHECK(palpate_set_material(simulation.get(), 0, &parameter, 1, &error) == code);
    CHECK_THAT(error.text, Catch::Contains(text));
  };
  refused("young", 1e9, PALPATE_REFUSED, "times too stiff");
  refused("density", 4200, PALPATE_REFUSED, "density can't be changed live");
  refused("young", -5, PALPATE_BAD_ARGUMENT, "\"young\" must be > 0");
  refused("yuong", 5000, PALPATE_BAD_ARGUMENT, "young, poisson, density, relaxation");
  refused("barrier_strength", 1, PALPATE_BAD_ARGUMENT, "has no \"barrier_strength\"");  // no scene has it either
  refused("relaxation", 0.3, PALPATE_BAD_ARGUMENT, "the scene gives the material no \"relaxation\"");
  CHECK(palpate_set_material(simulation.get(), 1, nullptr, 0, &error) == PALPATE_BAD_ARGUMENT);
  CHECK_THAT(error.text, Catch::Contains("parameters is NULL"));  // what is wrong by name
  const double young = 5000;
  const palpate_parameter parameter{"young", &young, 1};
  CHECK(palpate_set_material(simulation.get(), 1, &parameter, 1, &error) == PALPATE_BAD_ARGUMENT);
  CHECK_THAT(error.text, Catch::Contains("no material"));
  const double nothing = 1e-300;
  const palpate_parameter softest{"young", &nothing, 1};
  CHECK(palpate_set_material(simulation.get(), 0, &softest, 1, &error) == PALPATE_BAD_ARGUMENT);
  CHECK_THAT(error.text, Catch::Contains("is that of no matter"));
  CHECK(palpate_script(model.get(), nullptr, nullptr, -1, &count, &error) == PALPATE_BAD_ARGUMENT);
  CHECK_THAT(error.text, Catch::Contains("capacity is negative"));
  CHECK(hashOf(simulation) == rest);
}

TEST_CASE("A call that is refused changes nothing, now or in the ticks that follow", "[api]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle asked = create(model), left_alone = create(model);
  press(asked, info, 0, 40), press(left_alone, info, 0, 40);
  palpate_simulation* const simulation = asked.get();
  const std::uint64_t before = hashOf(asked);
  const auto away = poseAtDepth(info, -0.005);
  std::vector<char> bytes(palpate_save_size(simulation));
  REQUIRE(palpate_save(simulation, bytes.data(), bytes.size()) == PALPATE_OK);
  bytes.back() = static_cast<char>(bytes.back() + 1);
  const double one[] = {1000, 2000};
  const palpate_parameter half[] = {{"young", one, 1}, {"poisson", one, 1}};  // the first of them can be meant
  palpate_state unsized{};
  palpate_tool_state unsized_tool{};
  std::vector<float> skin(static_cast<std::size_t>(3 * info.skin_vertex_count));
  std::int32_t count = 0;
  const auto refused = [](std::int32_t code, const char* why) {
    CHECK(code == PALPATE_BAD_ARGUMENT);
    CHECK_THAT(palpate_last_error(), Catch::Contains(why));
  };
  refused(palpate_step(simulation, 3, away.data(), &unsized), "a struct's size is 0; set it to sizeof");
  refused(palpate_step(simulation, 0, away.data(), &unsized), "a struct's size is 0");
  unsized.size = 1 << 20;
  refused(palpate_step(simulation, 3, nullptr, &unsized), "a struct's size is 1048576");
  refused(palpate_step(simulation, -1, away.data(), nullptr), "n is negative");
  refused(palpate_start(simulation, 1U << 9), "flags are 512");
  refused(palpate_set_target(simulation, nullptr, 9), "pose is NULL");
  refused(palpate_set_tool_target(simulation, 1, away.data(), 9), "tool is 1, not in 0 .. 0");
  refused(palpate_set_opening(simulation, 0, 0.01), "tool 0 has no jaws");
  refused(palpate_set_friction(simulation, 3), "the coefficient is 3, not in 0 .. 2");
  refused(palpate_set_material(simulation, 0, half, 2, nullptr), "poisson");
  CHECK(palpate_restore(simulation, bytes.data(), bytes.size(), nullptr) == PALPATE_BAD_INPUT);
  CHECK_THAT(palpate_last_error(), Catch::Contains("the saved state is damaged"));
  CHECK(palpate_restore(simulation, bytes.data(), bytes.size() - 1, nullptr) == PALPATE_BAD_INPUT);
  CHECK_THAT(palpate_last_error(), Catch::Contains(std::to_string(bytes.size() - 1)));
  const double twisted[7] = {0, 0, 0, 0, 0, 0, 3};
  refused(palpate_set_target(simulation, twisted, 9), "w 3, which is no unit one");
  refused(palpate_save(simulation, bytes.data(), bytes.size() - 1), "size is ");
  refused(palpate_read_tool(simulation, 0, &unsized_tool), "a struct's size is 0");
  refused(palpate_skin_positions(simulation, skin.data(), info.skin_vertex_count - 1), "vertex_count is ");
  refused(palpate_contacts(simulation, nullptr, nullptr, 5, &count), "vertex is NULL");
  CHECK(hashOf(asked) == before);
  const palpate_state after = press(asked, info, 40, 60), expected = press(left_alone, info, 40, 60);
  CHECK(sameOutcome(after, expected));
  CHECK(hashOf(asked) == hashOf(left_alone));

  REQUIRE(palpate_start(simulation, PALPATE_ORDINARY_THREAD) == PALPATE_OK);
  CHECK(palpate_step(simulation, 1, away.data(), nullptr) == PALPATE_BUSY);
  REQUIRE(palpate_stop(simulation) == PALPATE_OK);
  auto stopped = sized<palpate_state>();
  REQUIRE(palpate_read(simulation, &stopped) == PALPATE_OK);
  CHECK(stopped.depth_m > 0.004);  // nor did it take the pose
}

TEST_CASE("What can't be meant is refused, not done in part", "[api]") {
  const ModelHandle model = loadBlock();
  const SimulationHandle simulation = create(model);
  auto pose = poseAtDepth(describe(model), 0);
  pose[0] = 1e300;  // it would go nowhere
  CHECK(palpate_step(simulation.get(), 1, pose.data(), nullptr) == PALPATE_BAD_ARGUMENT);
  pose[0] = -1e5;
  CHECK(palpate_step(simulation.get(), 1, pose.data(), nullptr) == PALPATE_OK);
  CHECK(palpate_set_friction(simulation.get(), 1e300) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_set_friction(simulation.get(), 2) == PALPATE_OK);
}

TEST_CASE("A process that was forked off steps its copies and makes its own, but starts no threads that it has not",
          "[api]") {
#ifdef __SANITIZE_THREAD__
  return;  // it allows no threads after a fork
#endif
  const ModelHandle model = loadBlock(touched_block_text + "[dynamics]\nthreads = 2\n");
  const SimulationHandle simulation = create(model);
  REQUIRE(palpate_step(simulation.get(), 3, nullptr, nullptr) == PALPATE_OK);
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);  // a thread that waits for one that is not there
    const bool refused = palpate_start(simulation.get(), PALPATE_ORDINARY_THREAD) == PALPATE_REFUSED;
    const bool steps = palpate_step(simulation.get(), 3, nullptr, nullptr) == PALPATE_OK;
    palpate_simulation* own = nullptr;
    const bool makes = palpate_create(model.get(), &own, nullptr) == PALPATE_OK &&
                       palpate_start(own, PALPATE_ORDINARY_THREAD) == PALPATE_OK && palpate_stop(own) == PALPATE_OK;
    palpate_destroy(own);
    _exit(refused && steps && makes ? 0 : 1);
  }
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(status == 0);
}

TEST_CASE("A caller with an older, shorter struct gets what it knows and nothing behind it", "[api]") {
  const ModelHandle model = loadBlock();
  const SimulationHandle simulation = create(model);
  palpate_state state{};
  std::memset(&state, 0x5a, sizeof state);
  state.size = offsetof(palpate_state, force);
  const palpate_state untouched = state;
  REQUIRE(palpate_step(simulation.get(), 2, nullptr, &state) == PALPATE_OK);
  CHECK(state.tick == 2);
  CHECK(std::memcmp(state.force, untouched.force, sizeof state - offsetof(palpate_state, force)) == 0);
}

TEST_CASE("A stop before the first start is none - what was sent before a restore is of another future", "[api]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model), fresh = create(model);
  REQUIRE(palpate_stop(simulation.get()) == PALPATE_OK);
  const auto pose = poseAtDepth(info, 0.002);
  REQUIRE(palpate_set_target(simulation.get(), pose.data(), 7) == PALPATE_OK);
  REQUIRE(palpate_reset(simulation.get()) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 20, nullptr, nullptr) == PALPATE_OK);
  REQUIRE(palpate_step(fresh.get(), 20, nullptr, nullptr) == PALPATE_OK);
  CHECK(hashOf(simulation) == hashOf(fresh));
  REQUIRE(palpate_start(simulation.get(), PALPATE_ORDINARY_THREAD) == PALPATE_OK);
  auto state = sized<palpate_state>();
  for (int k = 0; k < 5000 && state.tick <= 20; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    REQUIRE(palpate_read(simulation.get(), &state) == PALPATE_OK);
  }
  CHECK(state.tick > 20);
  REQUIRE(palpate_stop(simulation.get()) == PALPATE_OK);
}
