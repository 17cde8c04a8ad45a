#pragma once

#include <vector>

#include "contact/tool_profile.h"
#include "model/model.h"

namespace palpate {

/// What holds the organ is rigid: a bone, a table. A tool that presses deep comes to stand before it, a quarter of the
/// spacing from where the tissue is held, under the hand; a hand that draws sideways slides it along. Without it a hand
/// far beneath the organ drew the tool through between the held nodes, and the tissue with it.
///
/// Held is the skin whose nearest node has no free component, imposed by boundaries that do not move, and such nodes
/// inside. The skin stops tools that are on its inner side; from outside they meet it as any skin, by contact, and what
/// they have passed that way holds them no more.
/// Immutable; the stop is real-time: no allocation, no lock, no throw. Test: realtime/loop/rigid_support_test.cpp
class RigidSupport {
 public:
  static constexpr double clearance = 0.25;  // of the spacing there, that the tool keeps

  /// @param tool  that it stops; for jaws both fingers
  explicit RigidSupport(const Model& model, int tool = 0);

  bool empty() const { return held_.empty(); }

  /// What the tool can do of `move` (m) in a tick: all, to the bit, or without what would bring it nearer to what is
  /// held than the clearance. Away from there it is free, also where it begins nearer.
  /// @param from  where it is
  Vec3 stop(const ToolPosture& from, const Vec3& move) const;

 private:
  struct Held {
    Vec3 position = Vec3::Zero();  // m
    Vec3 outward = Vec3::Zero();   // unit normal of the skin; 0: inside
    double clearance = 0;          // m
  };
  struct Body {
    ToolBody body;
    ToolProfile profile;
    double size = 0;  // m, of a ball around the middle of its axis
  };
  struct Approach {
    double depth = 0;          // m, by which it would be too near; 0: nowhere
    Vec3 into = Vec3::Zero();  // unit, the way on which it would be
  };

  Approach worst(const ToolPosture& from, const Vec3& move) const;

  std::vector<Held> held_;
  Box3 box_;  // of them, grown by the largest clearance
  std::vector<Body> bodies_;
};

}  // namespace palpate
