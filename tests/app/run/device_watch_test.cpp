#include "app/run/device_watch.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

using namespace palpate;
using namespace palpate::app;

namespace {

struct Told {
  DeviceWatch watch{"udp on 127.0.0.1:7711",
                    [this](bool warning, const std::string& text) { lines.push_back((warning ? "! " : "") + text); }};
  DeviceStatus status;
  double now = 0;
  std::vector<std::string> lines;

  /// So many seconds, in steps of a picture, with poses at a rate.
  void go(double seconds, double rate) {
    const double end = now + seconds;
    for (; now < end; now += 0.02) {
      status.poses = static_cast<std::int64_t>(poses_ += 0.02 * rate);
      watch.update(status, now);
    }
  }
  bool says(const std::string& text) const {
    for (const std::string& line : lines)
      if (line.find(text) != std::string::npos) return true;
    return false;
  }

 private:
  double poses_ = 0;
};

}  // namespace

TEST_CASE("A device that sends nothing is told of, and one that stops, once each", "[device_watch]") {
  Told told;
  told.go(1.9, 0);
  CHECK(told.lines.empty());
  told.go(3, 0);
  REQUIRE(told.lines.size() == 1);
  CHECK(told.says("! no pose has come in 2 s"));
  CHECK(told.says("127.0.0.1:7711"));
  told.go(3, 1000);
  REQUIRE(told.lines.size() == 2);
  CHECK(told.says("its handle has the tool"));
  told.go(3, 0);
  told.go(1, 1000);
  REQUIRE(told.lines.size() == 4);
  CHECK(told.says("! no pose for half a second"));
  CHECK(told.lines.back() == "poses come again");
}

TEST_CASE("A service that is back is given time", "[device_watch]") {
  Told told;
  told.go(3, 1000);
  const std::size_t before = told.lines.size();
  told.status.connected = false;
  told.go(5, 0);
  told.status.connected = true;
  told.go(0.1, 0);
  told.go(3, 1000);
  REQUIRE(told.lines.size() == before + 2);
  CHECK(told.lines[before].find("! udp on 127.0.0.1:7711 is gone") == 0);
  CHECK(told.lines.back() == "udp on 127.0.0.1:7711 is back");
  CHECK(told.watch.losses() == 1);
}

TEST_CASE("Poses that come too seldom are told of, and messages that are none", "[device_watch]") {
  for (const double rate : {30.0, 100.0, 1000.0}) {
    Told told;
    told.go(5, rate);
    CAPTURE(rate);
    CHECK(told.says("! poses come") == (rate < 50));
    CHECK(told.says("softer than with 1000") == (rate == 100));
    told.status.refused = 3;
    told.go(5, rate);
    CHECK(told.says("! a message came that is no new pose"));
  }
}

TEST_CASE("A hand that feels too little for a second is told how to have all again", "[device_watch]") {
  Told told;
  told.go(1, 1000);
  const std::size_t before = told.lines.size();
  told.status.lacking = 0.6;
  told.go(0.9, 1000);
  told.status.lacking = 0;  // for a moment only
  told.go(1, 1000);
  CHECK(told.lines.size() == before);
  told.status.lacking = 0.6;
  told.go(20, 1000);
  CHECK(told.lines.size() == before + 1);
  CHECK(told.says("! the hand feels 60 % less than it should"));
  CHECK(told.says("lift off for a second"));
  told.status.lacking = 0;
  told.go(6, 1000);
  told.status.lacking = 0.5;
  told.go(2, 1000);
  CHECK(told.lines.size() == before + 2);
}
