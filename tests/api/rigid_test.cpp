#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "api/pressed_block.h"

using namespace palpate::test;

TEST_CASE("A saved state of a block that slides on a table goes on bit for bit", "[api][rigid]") {
  const std::string text =
      "organ = { solid = \"box\", size = [0.05, 0.05, 0.03] }\ndiscretization = { spacing = 0.012 }\n"
      "dynamics = { gravity = [3, 0, -9.81] }\ntool = { shape = \"sphere\", radius = 0.01, position = [0, 0, 0.1] }\n"
      "[[material]]\nmodel = \"neo-hookean\"\nyoung = 6000\npoisson = 0.45\ndensity = 1000\n"
      "[[rigid]]\nregion = { shape = \"half-space\", point = [0, 0, 0], normal = [0, 0, 1] }\nfriction = 0.25\n";
  const ModelHandle model = loadBlock(text);
  const SimulationHandle simulation = create(model), other = create(model);
  REQUIRE(palpate_step(simulation.get(), 60, nullptr, nullptr) == PALPATE_OK);
  REQUIRE(palpate_step(other.get(), 7, nullptr, nullptr) == PALPATE_OK);  // has points near the table of its own
  std::vector<char> bytes(palpate_save_size(simulation.get()));
  REQUIRE(palpate_save(simulation.get(), bytes.data(), bytes.size()) == PALPATE_OK);
  REQUIRE(palpate_restore(other.get(), bytes.data(), bytes.size(), nullptr) == PALPATE_OK);
  std::uint64_t a = 0, b = 0;
  for (const auto& [handle, hash] : {std::pair{&simulation, &a}, std::pair{&other, &b}}) {
    REQUIRE(palpate_step(handle->get(), 30, nullptr, nullptr) == PALPATE_OK);
    REQUIRE(palpate_hash(handle->get(), hash) == PALPATE_OK);
  }
  CHECK(a == b);
}
