#include "realtime/channels/log_event.h"

#include <catch2/catch.hpp>

#include "step/trust.h"

using namespace palpate;
using Catch::Contains;

TEST_CASE("Loads that are set live are told with their place", "[log]") {
  const auto text = [](LogEvent::Kind kind, int index, double value) {
    LogEvent event;
    event.kind = kind;
    event.index = index;
    event.value = value;
    event.position = {0, 1.5, -3};
    return briefText(event);
  };
  CHECK(text(LogEvent::Kind::GravitySet, -1, 1) == "gravity is now (0, 1.5, -3) m/s^2");
  CHECK(text(LogEvent::Kind::GravitySet, -1, 0) == "gravity is the scene's again");
  CHECK(text(LogEvent::Kind::ForceSet, 7, 1) == "a force acts on skin vertex 7");
  CHECK(text(LogEvent::Kind::ForceSet, -1, 0) == "no force acts on the skin any more");
  CHECK(text(LogEvent::Kind::Pinned, 5, 1) == "skin vertex 5 is pinned");
  CHECK(text(LogEvent::Kind::Pinned, 5, 0) == "skin vertex 5 is no longer pinned");
  CHECK(text(LogEvent::Kind::RegionMoved, 0, 1) == "region 0 is moved");
  CHECK(text(LogEvent::Kind::RegionMoved, -1, 0) == "no region is moved any more");
}

TEST_CASE("A doubted force is told to the hand without keys of scenes, and to the log with all that helps", "[log]") {
  for (int d = static_cast<int>(Doubt::None) + 1; d <= static_cast<int>(Doubt::Lost); ++d) {
    LogEvent event;
    event.kind = LogEvent::Kind::Doubted;
    event.index = d;
    const std::string brief = briefText(event);
    INFO(brief);
    CHECK_THAT(brief, Catch::StartsWith("the force is not to be trusted: ") && !Contains("_") && !Contains("spacing"));
    CHECK((brief.ends_with(": press less") || brief.ends_with(": press slower") || brief.ends_with(": reset")));
    CHECK_THAT(logText(event), Contains(doubtText(static_cast<Doubt>(d))));
  }
}
