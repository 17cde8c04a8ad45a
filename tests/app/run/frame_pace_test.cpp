#include "app/run/frame_pace.h"

#include <catch2/catch.hpp>

using namespace palpate;
using namespace palpate::app;

TEST_CASE("A graphics card draws sixty frames a second, whatever comes late", "[frame_pace]") {
  FramePace pace(false);
  for (int k = 0; k < 10; ++k) CHECK(pace.turn(0.004, 5 * k) == FramePace::shortest);
}

TEST_CASE("A software renderer rests as long as it draws", "[frame_pace]") {
  FramePace pace(true);
  CHECK(pace.turn(0.002, 0) == FramePace::shortest);
  CHECK(pace.turn(0.03, 0) == Approx(0.06));
  CHECK(pace.turn(0.15, 0) == FramePace::longest);
}

TEST_CASE("Late ticks slow the picture to five frames a second, no further, and it recovers", "[frame_pace]") {
  FramePace pace(true);
  double turn = pace.turn(0.02, 0);
  std::int64_t overruns = 0;
  for (int k = 0; k < 8; ++k) {
    const double next = pace.turn(0.02, ++overruns);
    CHECK(next >= turn);
    turn = next;
  }
  CHECK(turn == FramePace::longest);
  double seconds = 0;
  for (turn = pace.turn(0.02, overruns); turn > 0.0401; turn = pace.turn(0.02, overruns)) seconds += turn;
  CHECK(turn == Approx(0.04));
  CHECK(seconds > 2);  // not at once, or the next frame makes ticks late again
  CHECK(seconds < 15);
}

TEST_CASE("Mesa's software renderers are known by name", "[frame_pace]") {
  CHECK(isSoftwareRenderer("llvmpipe (LLVM 15.0.6, 256 bits)"));
  CHECK(isSoftwareRenderer("softpipe"));
  CHECK_FALSE(isSoftwareRenderer("NVIDIA H200/PCIe/SSE2"));
  CHECK_FALSE(isSoftwareRenderer("Mesa Intel(R) UHD Graphics 620"));
  CHECK_FALSE(isSoftwareRenderer(nullptr));
}
