#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "app/render/camera.h"
#include "app/render/skin_surface.h"
#include "app/run/input.h"
#include "model/body.h"
#include "realtime/channels/command_queue.h"

namespace palpate::app {

/// How mouse and keys move the tool.
enum class HandMode { Glide, Free };

/// Turns what mouse and keys do into requests that the loop carries out evenly, tick by tick (ToolGoal): keys become
/// velocities, drags and notches ways that take as long as a picture does.
///
///   Glide  a click on the skin brings the tool there, upright on it; dragged, it glides over the skin at rest; wheel
///          and keys press it in along the skin's normal by depth()
///   Free   drags move it in the view's plane, wheel and keys along its own axis
///
/// Its tip stays near the organ, so that it can't be lost. Belongs to the main thread.
class ToolHand {
 public:
  explicit ToolHand(const Body& model);

  HandMode mode() const { return mode_; }
  void setMode(HandMode mode);

  /// Where the hand is going.
  const Pose& target() const { return target_; }
  /// Whether it goes along the skin, and how deep it presses there, m; negative: above it.
  bool onSkin() const { return place_.has_value(); }
  double depth() const { return depth_; }

  /// The loop has put the tool elsewhere: a script, an undo.
  void moveTo(const Pose& pose);
  /// Back to where it was at first. The requests lead it there around the organ.
  std::vector<Request> toStart();
  /// As toStart, without the way: after a reset.
  void reset();
  /// To the place of the skin at rest that is nearest to `touched`, m, as a click there.
  std::vector<Request> bring(const Vec3& touched);
  /// So deep into the skin at its place, m; negative: off it. Without a place: into the skin that is nearest to the
  /// tip, on which it then stands (Glide), or as it is turned now (Free).
  /// @param speed  m/s
  /// @param goal   where the loop's own goal stands (Snapshot::goal_pose)
  std::vector<Request> press(double depth, double speed, const Pose& goal);
  std::vector<Request> lift(double speed, const Pose& goal) { return press(-lift_height, speed, goal); }
  /// Back along its own axis, m, off any place; at `speed`, m/s.
  std::vector<Request> raise(double way, double speed);
  /// Jaws, m.
  Request open(double opening);
  bool hasJaws() const { return start_opening_ >= 0; }
  /// How far jaws can be opened, m.
  double widest() const { return 2 * std::max(start_opening_, tool_radius_); }
  /// Upright on the skin (Glide), or as at first (Free).
  std::vector<Request> upright();

  /// What `motion` asks for.
  /// @param touched  m, where the pointer is on the skin at rest, while it leads the tool there; else empty
  /// @param height   of the picture, framebuffer pixels
  /// @param speed    of held keys, m/s
  /// @param seconds  since the last frame
  /// @param goal     where the loop's own goal stands (Snapshot::goal_pose)
  std::vector<Request> apply(const Motion& motion, const std::optional<Vec3>& touched, const Camera& camera, int height,
                             double speed, double seconds, const Pose& goal);

 private:
  static constexpr double lift_height = 0.005;  // m, off the skin

  Pose poseOn(const SkinSurface::Place& place) const;
  Vec3 withinReach(const Vec3& position) const;
  std::optional<Request> steer(const Motion& motion, const Camera& camera, double speed, double seconds,
                               const Pose& goal);
  Request glideKeys(const Motion& motion, const Camera& camera, double speed, double seconds, const Pose& goal);
  void moveByMouse(const Motion& motion, const Camera& camera, int height, double seconds,
                   std::vector<Request>& requests);
  void glideTo(const Vec3& touched, double seconds, std::vector<Request>& requests);
  void wayAround(const Pose& to, const Vec3& up, std::vector<Request>& requests) const;

  SkinSurface skin_;
  HandMode mode_ = HandMode::Glide;
  Pose start_, target_;
  std::optional<SkinSurface::Place> place_;    // that it glides at
  Quat tilt_ = Quat::Identity();               // off the skin's normal, in the world
  double depth_ = 0;                           // m
  bool lifted_ = false;                        // a click brings it down again
  bool pressing_ = false;                      // keys press in or draw back
  int behind_ = 0;                             // frames in which the loop may have gone on by itself
  bool steering_ = false;                      // keys were held in the last frame
  Vec3 centre_;                                // m, of the room that the tip has
  double organ_radius_, reach_, tool_radius_;  // m
  double start_opening_, opening_;             // m, of jaws; < 0: none
};

}  // namespace palpate::app
