#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "api/pressed_block.h"

using namespace palpate::test;

namespace {

ModelHandle lyingBlock(const std::string& gravity) {
  return loadBlock(
      "organ = { solid = \"box\", size = [0.05, 0.05, 0.03] }\ndiscretization = { spacing = 0.012 }\n"
      "dynamics = { gravity = [" +
      gravity +
      "] }\ntool = { shape = \"sphere\", radius = 0.01, position = [0, 0, 0.1] }\n"
      "[[material]]\nmodel = \"neo-hookean\"\nyoung = 6000\npoisson = 0.45\ndensity = 1000\n"
      "[[rigid]]\nname = \"table\"\nregion = { shape = \"half-space\", point = [0, 0, 0], normal = [0, 0, 1] }\n"
      "friction = 0.25\n");
}

}  // namespace

TEST_CASE("A table bears what lies on it, and says so", "[api][rigid]") {
  const ModelHandle model = lyingBlock("0, 0, -9.81");
  const SimulationHandle simulation = create(model);
  std::int32_t count = 0;
  REQUIRE(palpate_count(model.get(), PALPATE_RIGID, &count) == PALPATE_OK);
  REQUIRE(count == 1);
  CHECK(palpate_name(model.get(), PALPATE_RIGID, 0) == std::string("table"));
  double force[3] = {1, 1, 1};
  REQUIRE(palpate_rigid_forces(simulation.get(), force, 1) == PALPATE_OK);
  CHECK(force[2] == 0);
  REQUIRE(palpate_step(simulation.get(), 600, nullptr, nullptr) == PALPATE_OK);
  REQUIRE(palpate_rigid_forces(simulation.get(), force, 1) == PALPATE_OK);
  CHECK(force[2] == Approx(0.075 * 9.81).epsilon(0.01));
  CHECK(std::abs(force[0]) < 0.01 * force[2]);
  CHECK(palpate_rigid_forces(simulation.get(), force, 0) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_rigid_forces(simulation.get(), nullptr, 1) == PALPATE_BAD_ARGUMENT);
}

TEST_CASE("A saved state of a block that slides on a table goes on bit for bit", "[api][rigid]") {
  const ModelHandle model = lyingBlock("3, 0, -9.81");
  const SimulationHandle simulation = create(model), other = create(model);
  REQUIRE(palpate_step(simulation.get(), 60, nullptr, nullptr) == PALPATE_OK);
  REQUIRE(palpate_step(other.get(), 7, nullptr, nullptr) == PALPATE_OK);  // has points near the table of its own
  copyState(simulation, other);
  std::uint64_t a = 0, b = 0;
  for (const auto& [handle, hash] : {std::pair{&simulation, &a}, std::pair{&other, &b}}) {
    REQUIRE(palpate_step(handle->get(), 30, nullptr, nullptr) == PALPATE_OK);
    REQUIRE(palpate_hash(handle->get(), hash) == PALPATE_OK);
  }
  CHECK(a == b);
}
