#include <catch2/catch.hpp>
#include <cmath>

#include "api/pressed_block.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::test;

namespace {

const std::string two_tissues = touched_block_text + R"(friction = 0
[[material]]
name = "lump"
model = "neo-hookean"
young = 9000
poisson = 0.45
region = { shape = "sphere", centre = [0.01, 0, 0.017], radius = 0.01 }
)";

struct EquilibriumDeleter {
  void operator()(palpate_equilibrium* equilibrium) const { palpate_equilibrium_destroy(equilibrium); }
};
using EquilibriumHandle = std::unique_ptr<palpate_equilibrium, EquilibriumDeleter>;

EquilibriumHandle settle(const ModelHandle& model, const double* pose) {
  palpate_equilibrium* equilibrium = nullptr;
  auto error = sized<palpate_error>();
  if (palpate_settle(model.get(), pose, 0, 1, &equilibrium, &error) != PALPATE_OK) throw std::runtime_error(error.text);
  return EquilibriumHandle(equilibrium);
}

palpate_quantity quantity(std::int32_t kind, double x, double y, double z) {
  auto q = sized<palpate_quantity>();
  q.kind = kind;
  q.direction[0] = x, q.direction[1] = y, q.direction[2] = z;
  return q;
}

double valueOf(const EquilibriumHandle& equilibrium, const palpate_quantity& q) {
  double value = 0;
  REQUIRE(palpate_equilibrium_value(equilibrium.get(), &q, &value, nullptr) == PALPATE_OK);
  return value;
}

}  // namespace

TEST_CASE("Sensitivities are central differences of equilibria, of forces and displacements",
          "[api][equilibrium][whole]") {
  const ModelHandle model = loadBlock(two_tissues);
  const auto pose = poseAtDepth(describe(model), 0.002);
  const EquilibriumHandle equilibrium = settle(model, pose.data());
  const double place[3] = {0.012, 0.002, 0.02};
  palpate_points* points = nullptr;
  REQUIRE(palpate_points_create(model.get(), place, 1, &points, nullptr) == PALPATE_OK);
  const std::array<palpate_material_number, 2> numbers{{{0, 0, "young"}, {1, 0, "young"}}};
  constexpr double young[2] = {3000, 9000};
  const double force = valueOf(equilibrium, quantity(PALPATE_TOOL_FORCE, 0, 0, 1));
  CHECK(force > 0.01);
  CHECK(valueOf(equilibrium, quantity(PALPATE_REGION_FORCE, 0, 0, 1)) == Approx(force).epsilon(1e-6));
  CHECK(valueOf(equilibrium, quantity(PALPATE_TOOL_FORCE, 0, 0, -10)) == Approx(-force).epsilon(1e-12));
  const palpate_quantity nowhere = quantity(PALPATE_TOOL_FORCE, 0, 0, 0);
  double error = 0;
  CHECK(palpate_equilibrium_value(equilibrium.get(), &nowhere, &error, nullptr) == PALPATE_BAD_ARGUMENT);
  REQUIRE(palpate_equilibrium_expected_error(equilibrium.get(), &error) == PALPATE_OK);
  CHECK((error > 0.001 && error < 0.5));
  for (const std::int32_t kind : {PALPATE_TOOL_FORCE, PALPATE_REGION_FORCE, PALPATE_DISPLACEMENT}) {
    palpate_quantity q = quantity(kind, 0.6, 0, 0.8);
    if (kind == PALPATE_DISPLACEMENT) q.points = points;
    double slopes[2];
    REQUIRE(palpate_sensitivity(equilibrium.get(), &q, numbers.data(), 2, slopes, nullptr) == PALPATE_OK);
    const double largest = std::max(std::abs(slopes[0]) * young[0], std::abs(slopes[1]) * young[1]);
    for (std::size_t k = 0; k < 2; ++k) {
      double values[2];
      constexpr double share = 1e-4;
      for (const int side : {0, 1}) {
        const double changed = young[k] * (1 + (side == 0 ? -share : share));
        REQUIRE(palpate_settle_with(equilibrium.get(), &numbers[k], changed, nullptr) == PALPATE_OK);
        values[side] = valueOf(equilibrium, q);
      }
      REQUIRE(palpate_settle_with(equilibrium.get(), &numbers[k], young[k], nullptr) == PALPATE_OK);
      CHECK(std::abs((values[1] - values[0]) / (2 * share) - slopes[k] * young[k]) < 1e-6 * largest);
    }
  }
  palpate_points_destroy(points);
}

TEST_CASE("An equilibrium that can't be is refused in a sentence and changes nothing", "[api][equilibrium]") {
  const ModelHandle model = loadBlock(two_tissues), rubbing = loadBlock(touched_block_text + "friction = 0.4\n");
  const auto pose = poseAtDepth(describe(model), 0.002);
  palpate_equilibrium* none = nullptr;
  auto error = sized<palpate_error>();
  CHECK(palpate_settle(nullptr, pose.data(), 0, 1, &none, &error) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_settle(model.get(), pose.data(), -1, 1, &none, &error) == PALPATE_BAD_ARGUMENT);
  CHECK_THAT(error.text, Catch::Contains("time is negative"));
  CHECK(palpate_settle(model.get(), pose.data(), 0, 65, &none, &error) == PALPATE_BAD_ARGUMENT);
  CHECK_THAT(error.text, Catch::Contains("threads is 65, not in 0 .. 64"));
  CHECK(palpate_settle(rubbing.get(), pose.data(), 0, 1, &none, &error) == PALPATE_BAD_INPUT);
  CHECK_THAT(error.text, Catch::Contains("without friction"));
  CHECK(none == nullptr);

  const EquilibriumHandle handle = settle(model, pose.data());
  palpate_equilibrium* const equilibrium = handle.get();
  const palpate_quantity q = quantity(PALPATE_TOOL_FORCE, 0, 0, 1);
  const double before = valueOf(handle, q);
  double value = 0;
  const auto refused = [&](const palpate_quantity& wrong, const char* text) {
    CHECK(palpate_equilibrium_value(equilibrium, &wrong, &value, &error) == PALPATE_BAD_ARGUMENT);
    CHECK_THAT(error.text, Catch::Contains(text));
  };
  refused(quantity(7, 0, 0, 1), "no quantity.kind 7");
  refused(quantity(PALPATE_TOOL_FORCE, 0, HUGE_VAL, 1), "not finite");
  refused(quantity(PALPATE_DISPLACEMENT, 0, 0, 1), "quantity.points is NULL");
  palpate_quantity region = quantity(PALPATE_REGION_FORCE, 0, 0, 1);
  region.index = 1;
  refused(region, "not in 0 .. 0");
  const palpate_material_number misspelt{0, 0, "yuong"}, third{2, 0, "young"}, second{0, 1, "young"},
      young{0, 0, "young"}, poisson{0, 0, "poisson"};
  CHECK(palpate_sensitivity(equilibrium, &q, &misspelt, 1, &value, &error) == PALPATE_BAD_INPUT);
  CHECK_THAT(error.text, Catch::Contains("yuong"));
  CHECK(palpate_sensitivity(equilibrium, &q, &third, 1, &value, &error) == PALPATE_BAD_INPUT);
  CHECK(palpate_sensitivity(equilibrium, &q, &second, 1, &value, &error) == PALPATE_BAD_INPUT);
  CHECK(palpate_sensitivity(equilibrium, &q, &young, 0, &value, &error) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_settle_with(equilibrium, &young, -5, &error) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_settle_with(equilibrium, &poisson, 0.6, &error) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_settle_with(equilibrium, &misspelt, 1, &error) == PALPATE_BAD_INPUT);
  CHECK(valueOf(handle, q) == before);
}
