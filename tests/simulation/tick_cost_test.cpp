#include "setup/tick_cost.h"

#include <catch2/catch.hpp>

using namespace palpate;
using Catch::Contains;

namespace {

/// A body of 20,000 points with so many steps in a tick of 2 ms.
Body body(int steps) {
  Body made;
  made.scene.place = {"stiff.toml"};
  made.scene.places["discretization.spacing"] = {"stiff.toml", 5, 3};
  made.scene.places["dynamics.time_step"] = {"stiff.toml", 21, 3};
  made.scene.dynamics.rate_hz = 500;
  made.scene.dynamics.threads = 2;
  made.scene.discretization.spacing = 0.01;
  made.point_X.resize(20'000);
  made.substeps_per_tick = steps;
  return made;
}

}  // namespace

TEST_CASE("A scene that its rate leaves no time for is told so, with its steps, their cost and what to do",
          "[tick_cost]") {
  CHECK(expectedLoad(body(1)) == Approx(20'000 * 55e-9 / 2 * 500));  // by hand
  CHECK(rateWarning(body(1)).empty());
  CHECK(rateWarning(body(3)).empty());  // 1.65 ms of 2 ms
  const std::string told = rateWarning(body(498));
  CHECK_THAT(told, Contains("stiff.toml:5:3: ") && Contains("498 steps of 20000 points, about 274 ms") &&
                       Contains("in 2 ms (55 ns a point and step, 2 threads)") && Contains("about 137 times slower"));
  CHECK_THAT(told, Contains("mass_scaling, or choose a spacing of about 0.0342 m"));  // (load 137)^(1/4)

  Body one = body(1);
  one.point_X.resize(200'000);
  CHECK_THAT(rateWarning(one), Contains("1 step of 200000 points") && Contains("lower dynamics.rate"));
  Body own = body(498);
  own.scene.dynamics.time_step = 4e-6;
  CHECK_THAT(rateWarning(own), Contains("stiff.toml:21:3: ") && Contains("leave time_step out"));
  Body helped = body(498);
  helped.scene.dynamics.mass_scaling = 0.1;
  CHECK_THAT(rateWarning(helped), Contains("more dynamics.mass_scaling"));

  // A cloud that follows the tool has a step that the scene did not give, and a spacing near the tool.
  Body place = body(498);
  place.scene.dynamics.time_step = 1e-3;
  place.scene.dynamics.threads = 1;
  place.scene.places = {{"dynamics.rate", {"stiff.toml", 9, 1}}};
  CHECK_THAT(rateWarning(place), Contains("dynamics.threads") && Contains("allow dynamics.mass_scaling") &&
                                     Contains("near the tool (follow = true, spacing)") && !Contains("time_step"));
}
