#pragma once

#include <cstdint>

namespace palpate::app {

/// When to draw. A graphics card draws beside the physics: 60 frames a second. A software OpenGL takes the physics'
/// caches and
/// memory bandwidth, and a tick that finds them taken is slow: there the picture rests as long as a frame took, and
/// gives
/// way further, down to five frames a second, while ticks come late.
class FramePace {
 public:
  explicit FramePace(bool software) : software_(software) {}

  /// How long a frame's turn lasts, s, its drawing included.
  /// @param drawing   s that this frame took
  /// @param overruns  ticks that came late so far
  double turn(double drawing, std::int64_t overruns);

  static constexpr double shortest = 1.0 / 60, longest = 0.2;  // s

 private:
  bool software_;
  double patience_ = shortest;  // s, least turn after late ticks
  std::int64_t overruns_ = 0;
};

/// Whether a GL_RENDERER's name is one of Mesa's software renderers.
bool isSoftwareRenderer(const char* name);

}  // namespace palpate::app
