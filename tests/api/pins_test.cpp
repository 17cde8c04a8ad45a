#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "api/pressed_block.h"
#include "support/realtime_guard.h"

using namespace palpate;
using namespace palpate::test;

namespace {

std::array<double, 3> placeOf(const std::vector<float>& skin, std::int32_t vertex) {
  const auto k = 3 * static_cast<std::size_t>(vertex);
  return {skin[k], skin[k + 1], skin[k + 2]};
}

}  // namespace

TEST_CASE("Pinned vertices are where they are held, and go back when they are let go", "[api][pins]") {
  const ModelHandle model = loadBlock(damped_text);
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  const std::vector<float> rest = skinOf(simulation, info);
  const std::int32_t a = upperVertex(rest), b = upperVertex(rest, 0.015, 0.015);
  REQUIRE(a != b);
  auto of_a = placeOf(rest, a), of_b = placeOf(rest, b);
  of_a[2] += 0.002, of_b[1] += 0.001;
  REQUIRE(palpate_pin(simulation.get(), a, of_a.data()) == PALPATE_OK);
  REQUIRE(palpate_pin(simulation.get(), b, of_b.data()) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 400, nullptr, nullptr) == PALPATE_OK);
  const std::vector<float> held = skinOf(simulation, info);
  for (std::size_t c = 0; c < 3; ++c) {
    CHECK(placeOf(held, a)[c] == Approx(of_a[c]).margin(2e-6));
    CHECK(placeOf(held, b)[c] == Approx(of_b[c]).margin(2e-6));
  }
  CHECK(baseForce(simulation) < -0.001);  // it is drawn up, and held down
  REQUIRE(palpate_pin(simulation.get(), a, nullptr) == PALPATE_OK);
  REQUIRE(palpate_pin(simulation.get(), -1, nullptr) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 800, nullptr, nullptr) == PALPATE_OK);
  CHECK(std::abs(baseForce(simulation)) < 1e-4);
  CHECK(placeOf(skinOf(simulation, info), a)[2] == Approx(rest[3 * static_cast<std::size_t>(a) + 2]).margin(1e-6));
}

TEST_CASE("What pins do to the tissue is what holds it at its base, and 0 where none is", "[api][pins]") {
  const ModelHandle model = loadBlock(damped_text);
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  const std::vector<float> rest = skinOf(simulation, info);
  const std::int32_t a = upperVertex(rest), b = upperVertex(rest, 0.015, 0.015);
  auto of_a = placeOf(rest, a), of_b = placeOf(rest, b);
  of_a[2] += 0.002, of_b[2] -= 0.001;
  REQUIRE(palpate_pin(simulation.get(), b, of_b.data()) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 400, nullptr, nullptr) == PALPATE_OK);
  const auto forceAt = [&](std::int32_t vertex) {
    Vec3 force;
    REQUIRE(palpate_pin_force(simulation.get(), vertex, force.data()) == PALPATE_OK);
    return force;
  };
  CHECK(forceAt(b).z() < -0.001);
  CHECK(forceAt(b).z() == Approx(-baseForce(simulation)).epsilon(0.01));
  CHECK(forceAt(a).isZero(0));
  REQUIRE(palpate_pin(simulation.get(), a, of_a.data()) == PALPATE_OK);
  CHECK(forceAt(a).isZero(0));  // not yet
  CHECK(forceAt(b).z() < -0.001);
  REQUIRE(palpate_step(simulation.get(), 400, nullptr, nullptr) == PALPATE_OK);
  CHECK(forceAt(a).z() > 0.001);
  CHECK(forceAt(a).z() + forceAt(b).z() == Approx(-baseForce(simulation)).epsilon(0.01));
  REQUIRE(palpate_pin(simulation.get(), -1, nullptr) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 1, nullptr, nullptr) == PALPATE_OK);
  CHECK(forceAt(a).isZero(0));
  double force[3];
  CHECK(palpate_pin_force(simulation.get(), info.skin_vertex_count, force) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_pin_force(simulation.get(), a, nullptr) == PALPATE_BAD_ARGUMENT);
}

TEST_CASE("A pin that is far away is come to no faster than the tool may go", "[api][pins]") {
  const ModelHandle model = loadBlock(damped_text);
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  const std::vector<float> rest = skinOf(simulation, info);
  const std::int32_t vertex = upperVertex(rest);
  auto place = placeOf(rest, vertex);
  place[2] += 0.004;
  REQUIRE(palpate_pin(simulation.get(), vertex, place.data()) == PALPATE_OK);
  const double way = 1.0 / info.rate_hz;  // m a tick at the 1 m/s of scenes that say nothing
  double before = rest[3 * static_cast<std::size_t>(vertex) + 2];
  auto state = sized<palpate_state>();
  for (int k = 0; k < 20; ++k) {
    REQUIRE(palpate_step(simulation.get(), 1, nullptr, &state) == PALPATE_OK);
    const double now = placeOf(skinOf(simulation, info), vertex)[2];
    CHECK(now - before < 1.02 * way);
    before = now;
  }
  CHECK(before == Approx(place[2]).margin(2e-5));
  CHECK(state.loss_count == 0);
}

TEST_CASE("A fixed region that is moved takes the whole body with it, without a force that lasts",
          "[api][pins][whole]") {
  const ModelHandle model = loadBlock(damped_text);
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model);
  const std::vector<float> rest = skinOf(simulation, info);
  const double shift[3] = {0.004, -0.002, 0.001}, none[3] = {0, 0, 0};
  REQUIRE(palpate_move_region(simulation.get(), 0, shift) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 1000, nullptr, nullptr) == PALPATE_OK);
  const std::vector<float> moved = skinOf(simulation, info);
  double worst = 0;
  for (std::size_t k = 0; k < rest.size(); ++k)
    worst = std::max(worst, std::abs(static_cast<double>(moved[k]) - rest[k] - shift[k % 3]));
  CHECK(worst < 2e-5);
  CHECK(std::abs(baseForce(simulation)) < 1e-3);
  REQUIRE(palpate_move_region(simulation.get(), 0, none) == PALPATE_OK);
  REQUIRE(palpate_step(simulation.get(), 1000, nullptr, nullptr) == PALPATE_OK);
  const std::vector<float> back = skinOf(simulation, info);
  worst = 0;
  for (std::size_t k = 0; k < rest.size(); ++k)
    worst = std::max(worst, std::abs(static_cast<double>(back[k]) - rest[k]));
  CHECK(worst < 2e-5);
}

TEST_CASE("Moving the base against a pin is moving the pin against the base", "[api][pins][whole]") {
  const ModelHandle model = loadBlock(damped_text);
  const palpate_model_info info = describe(model);
  const SimulationHandle base = create(model), skin = create(model);
  const std::vector<float> rest = skinOf(base, info);
  const std::int32_t vertex = upperVertex(rest);
  const double down[3] = {0, 0, -0.001};
  auto place = placeOf(rest, vertex);
  REQUIRE(palpate_pin(base.get(), vertex, place.data()) == PALPATE_OK);
  REQUIRE(palpate_move_region(base.get(), 0, down) == PALPATE_OK);
  place[2] += 0.001;
  REQUIRE(palpate_pin(skin.get(), vertex, place.data()) == PALPATE_OK);
  for (const SimulationHandle* one : {&base, &skin})
    REQUIRE(palpate_step(one->get(), 1500, nullptr, nullptr) == PALPATE_OK);
  REQUIRE(baseForce(skin) < -0.001);
  CHECK(baseForce(base) == Approx(baseForce(skin)).epsilon(0.01));
}

TEST_CASE("Pins and moved regions are part of the state: hashed, saved, kept in a reset, and taken back",
          "[api][pins]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle simulation = create(model), other = create(model), never = create(model);
  const std::uint64_t at_rest = hashOf(simulation);
  const double place[3] = {0.001, 0, 0.031}, shift[3] = {0, 0.001, 0}, none[3] = {0, 0, 0};
  REQUIRE(palpate_pin(simulation.get(), 7, place) == PALPATE_OK);
  const std::uint64_t pinned = hashOf(simulation);
  CHECK(pinned != at_rest);
  REQUIRE(palpate_move_region(simulation.get(), 0, shift) == PALPATE_OK);
  const std::uint64_t loaded = hashOf(simulation);
  CHECK(loaded != pinned);
  press(simulation, info, 0, 20);
  copyState(simulation, other);
  press(simulation, info, 20, 40), press(other, info, 20, 40);
  CHECK(hashOf(other) == hashOf(simulation));
  REQUIRE(palpate_reset(simulation.get()) == PALPATE_OK);
  CHECK(hashOf(simulation) == loaded);
  REQUIRE(palpate_pin(simulation.get(), -1, nullptr) == PALPATE_OK);
  REQUIRE(palpate_move_region(simulation.get(), 0, none) == PALPATE_OK);
  CHECK(hashOf(simulation) == at_rest);
  press(simulation, info, 0, 20), press(never, info, 0, 20);
  CHECK(hashOf(simulation) == hashOf(never));
}

TEST_CASE("A pin or region that can't be meant is refused and changes nothing", "[api][pins]") {
  const ModelHandle model = loadBlock();
  const palpate_model_info info = describe(model);
  const SimulationHandle handle = create(model);
  palpate_simulation* const simulation = handle.get();
  press(handle, info, 0, 20);
  const std::uint64_t before = hashOf(handle);
  const double place[3] = {0, 0, 0.03}, endless[3] = {0, HUGE_VAL, 0}, far[3] = {0, 0, 2e6};
  CHECK(palpate_pin(nullptr, 0, place) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_pin(simulation, -1, place) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_pin(simulation, -2, nullptr) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_pin(simulation, info.skin_vertex_count, place) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_pin(simulation, 0, endless) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_pin(simulation, 0, far) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_move_region(nullptr, 0, place) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_move_region(simulation, 0, nullptr) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_move_region(simulation, 1, place) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_move_region(simulation, -1, place) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_move_region(simulation, 0, endless) == PALPATE_BAD_ARGUMENT);
  CHECK(hashOf(handle) == before);
  for (std::int32_t v = 0; v < 64; ++v) REQUIRE(palpate_pin(simulation, (7 * v) % 64, place) == PALPATE_OK);
  const std::uint64_t full = hashOf(handle);
  CHECK(palpate_pin(simulation, 64, place) == PALPATE_REFUSED);
  CHECK(palpate_pin(simulation, 64, nullptr) == PALPATE_OK);  // it is none
  CHECK(hashOf(handle) == full);

  if (!guardAvailable()) return;
  const SimulationHandle calm = create(model);
  const double shift[3] = {0, 0, 1e-4};
  startGuard();
  std::int32_t code = palpate_pin(calm.get(), 5, place);
  code |= palpate_move_region(calm.get(), 0, shift);
  code |= palpate_step(calm.get(), 3, nullptr, nullptr);
  code |= palpate_pin(calm.get(), 5, nullptr);
  const GuardCounts counts = stopGuard();
  CHECK(code == PALPATE_OK);
  CHECK(counts.total() == 0);
}
