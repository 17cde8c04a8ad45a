#pragma once

#include "app/render/camera.h"
#include "app/run/input.h"
#include "simulation/body.h"

namespace palpate::app {

/// The pose that the user wants the tool to have, moved by mouse and keys. The tool
/// turns never; its tip stays near the organ, so that it can't be lost.
class ToolHand {
 public:
  explicit ToolHand(const Body& model);

  const Pose& target() const { return target_; }
  void moveTo(const Pose& pose) { target_ = pose; }
  void toStart() { target_ = start_; }

  /// Moves the target as `actions` ask; true where that changed it.
  /// @param height   of the picture, framebuffer pixels
  /// @param speed    of held keys, m/s
  /// @param seconds  since the last frame
  bool apply(const Actions& actions, const Camera& camera, int height, double speed, double seconds);

 private:
  Pose start_, target_;
  Vec3 axis_;     // unit, the way the tool advances
  Vec3 centre_;   // m, of the room that the tip has
  double reach_;  // m
};

}  // namespace palpate::app
