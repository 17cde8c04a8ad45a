#include "app/run/tool_hand.h"

#include <algorithm>

namespace palpate::app {

namespace {

constexpr double metre_per_notch = 5e-4;  // of the wheel: fine enough to feel the force grow
constexpr double room_per_organ = 2;      // the tip's room over the sphere around organ and start pose

/// `v` without its part along the unit vector `axis`, of unit length; zero where nothing is left.
Vec3 across(const Vec3& v, const Vec3& axis) {
  const Vec3 rest = v - v.dot(axis) * axis;
  return rest.norm() > 1e-6 ? Vec3(rest.normalized()) : Vec3(Vec3::Zero());
}

}  // namespace

ToolHand::ToolHand(const Body& model)
    : start_(model.tool_start), target_(start_), axis_(start_.orientation * -Vec3::UnitZ()) {
  Vec3 low = start_.position, high = start_.position;
  for (const Vec3& X : model.skin.surface.vertices) {
    low = low.cwiseMin(X);
    high = high.cwiseMax(X);
  }
  centre_ = 0.5 * (low + high);
  reach_ = room_per_organ * 0.5 * (high - low).norm();
}

bool ToolHand::apply(const Actions& actions, const Camera& camera, int height, double speed, double seconds) {
  const double pixel = camera.pixelSize(target_.position, height);  // m
  Vec3 move = pixel * (actions.move_tool.x() * camera.right() - actions.move_tool.y() * camera.up());
  move += (pixel * actions.push_tool_px + metre_per_notch * actions.push_tool_notches) * axis_;
  // Seen along the axis, "away" is what points up in the picture.
  Vec3 away = across(camera.forward(), axis_);
  if (away.isZero()) away = across(camera.up(), axis_);
  move += speed * seconds *
          (actions.tool_keys.x() * across(camera.right(), axis_) + actions.tool_keys.y() * away -
           actions.tool_keys.z() * axis_);
  if (move.isZero(0)) return false;

  Vec3 from_centre = target_.position + move - centre_;
  const double distance = from_centre.norm();
  if (distance > reach_) from_centre *= reach_ / distance;
  target_.position = centre_ + from_centre;
  return true;
}

}  // namespace palpate::app
