#include "realtime/channels/log_event.h"

#include <catch2/catch.hpp>

#include "step/trust.h"

using namespace palpate;
using Catch::Contains;

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
