#include "app/panels/press_curves.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "app/panels/notice.h"

using namespace palpate;
using namespace palpate::app;

namespace {

/// Presses of these depths, mm, one second each, with half a second of air between them; 2 N per 10 mm.
void press(PressCurves& curves, std::initializer_list<double> depths) {
  int tick = 0;
  for (const double depth : depths)
    for (int k = 0; k < 750; ++k) {
      ForceSample sample;
      sample.time_s = 0.002 * ++tick;
      sample.depth_m = k < 500 ? 1e-3 * depth * std::sin(M_PI * k / 500) : -1e-3;
      sample.force_raw.z() = std::max(0.0, 200 * sample.depth_m);
      curves.add(sample);
    }
}

}  // namespace

TEST_CASE("Each press is a curve of its own with its peak - a brush is none", "[press_curves]") {
  PressCurves curves;
  press(curves, {3, 0.01, 5});
  REQUIRE(curves.all().size() == 2);
  CHECK_FALSE(curves.underWay());
  CHECK(curves.all()[0].peak_mm == Approx(3).epsilon(1e-3));
  CHECK(curves.all()[1].peak_N == Approx(1).epsilon(1e-3));
  CHECK(curves.all()[1].curve.size() > 100);
  CHECK(curves.all()[1].curve.size() < 500);  // nearer points are left out
  const std::string csv = curves.csv();
  CHECK(csv.starts_with("press,time_begin_s,depth_mm,force_N\n1,"));
  CHECK(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')) ==
        1 + curves.all()[0].curve.size() + curves.all()[1].curve.size());
  curves.clear();
  CHECK(curves.all().empty());
}

TEST_CASE("What a press loses is the area between its way in and its way out", "[press_curves]") {
  PressCurves elastic;
  press(elastic, {5});
  // 2 N per 10 mm to 5 mm: 1 N x 5 mm / 2.
  CHECK(elastic.all()[0].loaded_mJ == Approx(2.5).epsilon(0.01));
  CHECK(std::abs(elastic.all()[0].lost_mJ) < 0.01);
  PressCurves lossy;
  for (int k = 0; k <= 400; ++k) {  // in at 200 N/m, out at half of that
    ForceSample sample;
    sample.time_s = 0.002 * k;
    sample.depth_m = 5e-3 * (k <= 200 ? k : 400 - k) / 200;
    sample.force_raw.z() = (k <= 200 ? 200 : 100) * sample.depth_m;
    lossy.add(sample);
  }
  CHECK(lossy.all()[0].loaded_mJ == Approx(2.5).epsilon(0.02));
  CHECK(lossy.all()[0].lost_mJ == Approx(1.25).epsilon(0.02));
}

TEST_CASE("A session keeps its last presses only", "[press_curves]") {
  PressCurves curves;
  for (std::size_t k = 0; k < PressCurves::most_kept + 5; ++k) press(curves, {2});
  CHECK(curves.all().size() == PressCurves::most_kept);
  CHECK(curves.all().back().number == static_cast<int>(PressCurves::most_kept) + 5);
}

TEST_CASE("What is said to who holds the probe has no node numbers - the details have", "[notice]") {
  LogEvent event;
  event.index = 4711;
  event.value = 1.93e8;
  for (const auto kind : {LogEvent::Kind::FrozenBlowUp, LogEvent::Kind::RestoredBlowUp, LogEvent::Kind::ToolYields,
                          LogEvent::Kind::DeepContact}) {
    event.kind = kind;
    const auto notice = noticeOf(event);
    REQUIRE(notice);
    CHECK(notice->sentence.find_first_of("0123456789") == std::string::npos);
    CHECK(notice->sentence.size() < 120);
    CHECK(notice->details == logText(event));
    CHECK(notice->frozen == event.isFreeze());
  }
  event.kind = LogEvent::Kind::Paused;
  CHECK_FALSE(noticeOf(event));
}
