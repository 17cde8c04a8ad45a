#include "realtime/loop/force_filter.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

using palpate::ForceFilter;
using palpate::Vec3;

TEST_CASE("The low-pass answers a step as the continuous one does", "[force_filter]") {
  const double cutoff = 30, rate = 500;
  ForceFilter filter(cutoff, 0, rate);
  const Vec3 step(1, -2, 0.5);
  for (int k = 1; k <= 200; ++k) {
    const Vec3 wanted = (1 - std::exp(-2 * std::numbers::pi * cutoff * k / rate)) * step;
    // 1e-13: some hundred roundings of numbers of size 1.
    REQUIRE((filter.update(step) - wanted).norm() < 1e-13);
  }
}

TEST_CASE("The low-pass passes slow waves and halves the power at its cut-off", "[force_filter]") {
  const double cutoff = 30, rate = 20000;  // rate far above: as in continuous time
  for (const double frequency : {3.0, 30.0, 300.0}) {
    ForceFilter filter(cutoff, 0, rate);
    double peak = 0;
    const int ticks = static_cast<int>(rate);
    for (int k = 0; k < ticks; ++k) {
      const double out = filter.update(Vec3(std::sin(2 * std::numbers::pi * frequency * k / rate), 0, 0)).x();
      if (k > ticks / 2) peak = std::max(peak, std::abs(out));
    }
    CHECK(peak == Approx(1 / std::sqrt(1 + std::pow(frequency / cutoff, 2))).epsilon(0.01));
  }
}

TEST_CASE("The rate limit turns a step into a ramp", "[force_filter]") {
  ForceFilter filter(0, 200, 500);  // 0.4 N per tick
  const Vec3 step = 10 * Vec3(0.6, 0, -0.8);
  for (int k = 1; k <= 25; ++k) {
    REQUIRE((filter.update(step) - 0.4 * k * Vec3(0.6, 0, -0.8)).norm() < 1e-12);
  }
  CHECK((filter.update(step) - step).norm() < 1e-12);
}

TEST_CASE("No input changes the filtered force by more than the limit per tick", "[force_filter]") {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 50);
  ForceFilter filter(100, 200, 500);
  Vec3 before = filter.value();
  double largest = 0;
  for (int k = 0; k < 5000; ++k) {
    const Vec3 after = k % 700 < 600 ? filter.update(Vec3(noise(random), noise(random), noise(random))) : filter.fade();
    largest = std::max(largest, (after - before).norm());
    before = after;
  }
  CHECK(largest <= 0.4 * (1 + 1e-12));
  CHECK(largest > 0.39);  // the limit was at work
}

TEST_CASE("A fade goes monotonically and smoothly to exactly zero", "[force_filter]") {
  const double rate = 500;
  ForceFilter filter(30, 0, rate);
  const Vec3 force(0, 3, 4);
  for (int k = 0; k < 500; ++k) filter.update(force);
  double before = filter.value().norm();
  const double start = before;
  const int ticks = static_cast<int>(ForceFilter::fade_seconds * rate);
  for (int k = 0; k < ticks; ++k) {
    const double after = filter.fade().norm();
    REQUIRE(after < before);
    REQUIRE(before - after <= 1.5 * start / ticks * (1 + 1e-9));  // steepest slope of the ramp
    before = after;
  }
  CHECK(filter.value() == Vec3::Zero());
  CHECK(filter.fade() == Vec3::Zero());
  // And on from there without a jump.
  CHECK(filter.update(force).norm() < 0.32 * start);
}

TEST_CASE("The fade of a large force takes as long as the rate limit asks", "[force_filter]") {
  ForceFilter filter(0, 200, 500);
  for (int k = 0; k < 1000; ++k) filter.update(Vec3(100, 0, 0));
  REQUIRE(filter.value().x() == Approx(100));
  double before = 100, largest = 0;
  int ticks = 0;
  while (filter.value() != Vec3::Zero()) {
    filter.fade();
    largest = std::max(largest, before - filter.value().x());
    before = filter.value().x();
    ++ticks;
  }
  CHECK(largest <= 0.4 * (1 + 1e-9));
  CHECK(ticks == 375);  // 1.5 * 100 N / (200 N/s) = 0.75 s
}
