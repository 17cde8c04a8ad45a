#include "app/run/certified_watch.h"

#include <catch2/catch.hpp>

using namespace palpate;
using namespace palpate::app;

TEST_CASE("A certificate holds from a touch on its way until the tool leaves it, and then not before the next",
          "[session]") {
  constexpr double radius = 0.006, skin = 0.03;
  Certificate certificate;
  certificate.row = {{0.004, 0.1, 0.1, 0.05, 0.01}};
  certificate.way = {{Vec3(0, 0, skin + 0.001), Quat::Identity()}, {Vec3(0, 0, skin - 0.004), Quat::Identity()}};
  CertifiedWatch watch(certificate, radius);
  std::int64_t tick = 0;
  const auto holds = [&](double x, double advance) {
    ForceSample sample;
    sample.tick = ++tick;
    sample.advance_m = advance;
    sample.tool_pose.position = {x, 0, skin - advance};
    sample.contact_count = advance > 0 ? 3 : 0;
    watch.add(sample);
    return watch.holds(tick);
  };
  CHECK_FALSE(holds(0, -0.001));
  CHECK(holds(0, 0.001));
  CHECK(holds(0.001, 0.003));
  CHECK_FALSE(holds(0.002, 0.003));  // dragged
  CHECK_FALSE(holds(0, 0.003));      // and back: the tissue was dragged along
  CHECK_FALSE(holds(0, -0.001));
  CHECK(holds(0, 0.001));
  CHECK_FALSE(holds(0.05, -0.001));  // through air
  CHECK_FALSE(holds(0.05, 0.002));
  // Pictures of earlier ticks.
  CHECK(watch.holds(3));
  CHECK_FALSE(watch.holds(4));
  CHECK(watch.holds(7));
}
