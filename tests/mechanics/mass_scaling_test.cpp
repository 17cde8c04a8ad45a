#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>

#include "mechanics/mass_scaling.h"
#include "support/test_body.h"

using namespace palpate;
using test::TestBody;

namespace {

ScaledMass scaled(const TestBody& body, const NodePatches& patches, double factor) {
  const auto limit = criticalTimeStep(body.shape, body.volume, body.point_material, body.materials, body.mass, patches);
  return scaleMass(body.shape, body.volume, body.point_material, body.materials, body.mass, patches, limit,
                   factor * limit.dt);
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

}  // namespace

TEST_CASE("Mass is added just as far as the wanted step needs it", "[mass_scaling]") {
  const TestBody body(5, 0.1, 1);
  for (const bool patched : {false, true}) {
    const NodePatches patches = patched ? body.patches() : NodePatches();
    const auto own = criticalTimeStep(body.shape, body.volume, body.point_material, body.materials, body.mass, patches);
    double added_before = 0;
    for (const double factor : {1.02, 1.2, 2.0}) {
      INFO("patches " << patched << ", step x " << factor);
      const ScaledMass s = scaled(body, patches, factor);
      const auto again =
          criticalTimeStep(body.shape, body.volume, body.point_material, body.materials, s.mass, patches);
      CHECK(again.dt == s.limit.dt);
      CHECK(again.dt >= factor * own.dt);
      CHECK(again.dt <= 1.006 * factor * own.dt);
      CHECK(s.added == Approx(sum(s.mass) / sum(body.mass) - 1).epsilon(1e-9));
      CHECK(s.added > added_before);
      CHECK(s.added < factor * factor - 1);  // less than all masses alike would take
      for (std::size_t i = 0; i < s.mass.size(); ++i) CHECK(s.mass[i] >= body.mass[i]);
      added_before = s.added;
    }
  }
}

TEST_CASE("One light node costs its own mass, not the body's", "[mass_scaling]") {
  TestBody body(5, 0.1, 1);
  const double own_mass = sum(body.mass);
  const auto even = criticalTimeStep(body.shape, body.volume, body.point_material, body.materials, body.mass);
  const auto inner = std::max_element(body.mass.begin(), body.mass.end()) - body.mass.begin();
  body.mass[inner] *= 1e-3;
  const auto limit = criticalTimeStep(body.shape, body.volume, body.point_material, body.materials, body.mass);
  REQUIRE(limit.dt < 0.5 * even.dt);
  const ScaledMass s =
      scaleMass(body.shape, body.volume, body.point_material, body.materials, body.mass, {}, limit, 0.95 * even.dt);
  CHECK(s.limit.dt >= 0.95 * even.dt);
  CHECK(s.mass[inner] > 10 * body.mass[inner]);
  CHECK(s.added < 0.05);
  CHECK(sum(s.mass) < 1.05 * own_mass);
}

TEST_CASE("A step that is stable anyway costs nothing", "[mass_scaling]") {
  const TestBody body(4, 0.1, 1);
  const ScaledMass s = scaled(body, {}, 1.0);
  CHECK(s.added == 0);
  CHECK(s.mass == body.mass);
}
