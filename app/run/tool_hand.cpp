#include "app/run/tool_hand.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/turn.h"

namespace palpate::app {

namespace {

constexpr double metre_per_notch = 5e-4;    // of the wheel: fine enough to feel the force grow
constexpr double notch_seconds = 0.12;      // that a notch takes
constexpr double room_per_organ = 2;        // the tip's room over the sphere around organ and start pose
constexpr double least_way_seconds = 0.04;  // a drag's way between two pictures
constexpr double most_way_seconds = 1;
constexpr double glide_speed = 0.15;   // m/s, the fastest over the skin
constexpr double travel_speed = 0.25;  // m/s, through the air
constexpr double touch_speed = 0.06;   // m/s, down to the skin
constexpr double turn_speed = 0.6;     // rad/s, of keys
constexpr double turn_per_pixel = 0.006;
constexpr double tap_seconds = 0.08;  // that a tapped key counts
constexpr double arrived = 5e-4;      // m: nearer, and a way is over
constexpr double jump = 0.02;         // m: further on, the tool lifts off and comes down again

/// `v` without its part along the unit vector `axis`, of unit length; zero where nothing is left.
Vec3 across(const Vec3& v, const Vec3& axis) {
  const Vec3 rest = v - v.dot(axis) * axis;
  return rest.norm() > 1e-6 ? Vec3(rest.normalized()) : Vec3(Vec3::Zero());
}

/// Seen along the axis, "away" is what points up in the picture.
Vec3 awayAcross(const Camera& camera, const Vec3& axis) {
  const Vec3 away = across(camera.forward(), axis);
  return away.isZero() ? across(camera.up(), axis) : away;
}

Vec3 rotationVector(const Quat& q) {
  const Eigen::AngleAxisd turn(q.w() < 0 ? Quat(-q.w(), -q.x(), -q.y(), -q.z()) : q);
  return turn.angle() * turn.axis();
}

Vec3 limited(const Vec3& v, double most) { return v.norm() > most ? Vec3(v * (most / v.norm())) : v; }

/// How long a request of this frame may last: until after the next, however late it comes; then the tool stands.
/// A key that is up again was held about as long as a tap takes, however slowly pictures follow each other.
double holdSeconds(double frame, bool tapped) { return tapped ? tap_seconds : std::clamp(1.5 * frame, 0.1, 1.0); }

}  // namespace

ToolHand::ToolHand(const Body& model)
    : skin_(model.skin.surface),
      start_(model.tools.first().start.pose),
      target_(start_),
      organ_radius_(0),
      tool_radius_(model.scene.tools[0].shape.radius),
      start_opening_(model.scene.tools[0].opening),
      opening_(start_opening_) {
  Vec3 low = start_.position, high = start_.position;
  for (const Vec3& X : model.skin.surface.vertices) {
    low = low.cwiseMin(X);
    high = high.cwiseMax(X);
  }
  centre_ = 0.5 * (low + high);
  for (const Vec3& X : model.skin.surface.vertices) organ_radius_ = std::max(organ_radius_, (X - centre_).norm());
  reach_ = room_per_organ * 0.5 * (high - low).norm();
}

void ToolHand::setMode(HandMode mode) {
  mode_ = mode;
  place_.reset();
}

void ToolHand::reset() {
  target_ = start_;
  opening_ = start_opening_;
  place_.reset();
  tilt_ = Quat::Identity();
  depth_ = 0;
}

void ToolHand::moveTo(const Pose& pose) {
  target_ = pose;
  if (!place_) return;
  place_ = skin_.nearest(pose.position);
  depth_ = (place_->point - pose.position).dot(place_->normal);
}

std::vector<Request> ToolHand::toStart() {
  std::vector<Request> requests;
  wayAround(start_, start_.orientation * Vec3::UnitZ(), requests);
  reset();
  return requests;
}

std::vector<Request> ToolHand::bring(const Vec3& touched) {
  std::vector<Request> requests;
  place_.reset();
  glideTo(touched, 0, requests);
  return requests;
}

std::vector<Request> ToolHand::press(double depth, double speed, const Pose& goal) {
  std::vector<Request> requests;
  const auto go = [&](const Pose& to, double its_speed) {
    const double seconds = std::max(least_way_seconds, (to.position - target_.position).norm() / its_speed);
    const bool under_way = !requests.empty() || (goal.position - target_.position).norm() > arrived;
    requests.push_back(under_way ? Request::thenMoveTool(to, seconds) : Request::moveTool(to, seconds));
    target_ = to;
  };
  depth = std::min(depth, reach_);
  if (!place_ && mode_ == HandMode::Free) {
    const SkinSurface::Place below = skin_.nearest(target_.position);
    go({below.point - depth * below.normal, target_.orientation}, speed);
    return requests;
  }
  if (!place_) {
    place_ = skin_.nearest(target_.position);
    tilt_ = Quat::Identity();
    depth_ = 0;
    go(poseOn(*place_), touch_speed);
  }
  depth_ = depth;
  lifted_ = depth < 0;
  go(poseOn(*place_), speed);
  return requests;
}

std::vector<Request> ToolHand::raise(double way, double speed) {
  place_.reset();
  target_.position = withinReach(target_.position + way * (target_.orientation * Vec3::UnitZ()));
  return {Request::moveTool(target_, way / speed)};
}

Request ToolHand::open(double opening) {
  opening_ = std::clamp(opening, 0.0, widest());
  return Request::setOpening(0, opening_);
}

std::vector<Request> ToolHand::upright() {
  tilt_ = Quat::Identity();
  if (place_)
    target_ = poseOn(*place_);
  else
    target_.orientation = start_.orientation;
  return {Request::moveTool(target_, 0.5)};
}

Pose ToolHand::poseOn(const SkinSurface::Place& place) const {
  return {place.point - depth_ * place.normal, (tilt_ * uprightOn(place.normal)).normalized()};
}

Vec3 ToolHand::withinReach(const Vec3& position) const { return centre_ + limited(position - centre_, reach_); }

std::vector<Request> ToolHand::apply(const Motion& motion, const std::optional<Vec3>& touched, const Camera& camera,
                                     int height, double speed, double seconds, const Pose& goal) {
  std::vector<Request> requests;
  if (behind_ > 0) {
    --behind_;
    const double held = depth_;
    moveTo(goal);
    if (!pressing_) depth_ = held;
  }
  if (const std::optional<Request> keys = steer(motion, camera, speed, seconds, goal)) requests.push_back(*keys);
  if (touched && mode_ == HandMode::Glide) glideTo(*touched, seconds, requests);
  moveByMouse(motion, camera, height, seconds, requests);
  if (motion.jaws_keys != 0 && hasJaws()) requests.push_back(open(opening_ + motion.jaws_keys * speed * seconds));
  return requests;
}

/// Held keys: a velocity, which the loop keeps until the next frame says otherwise.
std::optional<Request> ToolHand::steer(const Motion& motion, const Camera& camera, double speed, double seconds,
                                       const Pose& goal) {
  const bool held = !motion.tool_keys.isZero(0) || !motion.turn_keys.isZero(0);
  if (!held) {
    if (!std::exchange(steering_, false)) return {};
    return Request::steer(Vec3::Zero(), Vec3::Zero(), 0);
  }
  steering_ = !motion.tapped;  // what was tapped ends by itself, however soon the next frame is
  pressing_ = motion.tool_keys.z() != 0;
  behind_ = 2;
  if (place_) return glideKeys(motion, camera, speed, seconds, goal);
  const Vec3 axis = goal.orientation * -Vec3::UnitZ();
  Vec3 velocity = speed * (motion.tool_keys.x() * across(camera.right(), axis) +
                           motion.tool_keys.y() * awayAcross(camera, axis) - motion.tool_keys.z() * axis);
  const Vec3 out = goal.position - centre_;
  if (out.norm() >= reach_ && velocity.dot(out) > 0) velocity -= velocity.dot(out) / out.squaredNorm() * out;
  const Vec3 turn = turn_speed * (motion.turn_keys.x() * camera.forward() - motion.turn_keys.y() * camera.right());
  return Request::steer(velocity, turn, holdSeconds(seconds, motion.tapped));
}

/// Along the skin, at the depth that was reached; what the surface's bend and the tilt ask for is made good evenly.
Request ToolHand::glideKeys(const Motion& motion, const Camera& camera, double speed, double seconds,
                            const Pose& goal) {
  const double soon = std::max(0.2, 2 * seconds);  // s, to make good what is off
  const SkinSurface::Place here = skin_.nearest(goal.position);
  const double depth = (here.point - goal.position).dot(here.normal);
  Vec3 velocity = speed * (motion.tool_keys.x() * across(camera.right(), here.normal) +
                           motion.tool_keys.y() * awayAcross(camera, here.normal));
  if (motion.tool_keys.z() != 0) {
    depth_ = depth;
    velocity += speed * motion.tool_keys.z() * here.normal;
  } else {
    velocity += limited((depth - depth_) / soon * here.normal, speed);
  }
  const Vec3 turn = turn_speed * (motion.turn_keys.x() * camera.forward() - motion.turn_keys.y() * camera.right());
  if (!turn.isZero(0)) {
    tilt_ = (goal.orientation * uprightOn(here.normal).conjugate()).normalized();
    return Request::steer(velocity, turn, holdSeconds(seconds, motion.tapped));
  }
  const Quat wanted = tilt_ * uprightOn(here.normal);
  const Vec3 back = rotationVector(wanted * goal.orientation.conjugate()) / soon;
  return Request::steer(velocity, limited(back, 2 * turn_speed), holdSeconds(seconds, motion.tapped));
}

void ToolHand::moveByMouse(const Motion& motion, const Camera& camera, int height, double seconds,
                           std::vector<Request>& requests) {
  const double pixel = camera.pixelSize(target_.position, height);  // m
  const Vec3 axis = target_.orientation * -Vec3::UnitZ();
  const double push = pixel * motion.push_tool_px + metre_per_notch * motion.push_tool_notches;
  const bool turns = !motion.turn_tool.isZero(0);
  if (turns) {
    const Quat turn = Quat(Eigen::AngleAxisd(turn_per_pixel * motion.turn_tool.x(), camera.forward())) *
                      Quat(Eigen::AngleAxisd(turn_per_pixel * motion.turn_tool.y(), camera.right()));
    target_.orientation = (turn * target_.orientation).normalized();
    if (place_) tilt_ = (turn * tilt_).normalized();
  }
  const Vec3 move = pixel * (motion.move_tool.x() * camera.right() - motion.move_tool.y() * camera.up());
  if (move.isZero(0) && push == 0 && !turns) return;
  if (place_ && !move.isZero(0)) {  // moved freely, it is no longer at its place
    place_.reset();
    tilt_ = Quat::Identity();
  }
  if (place_) {
    depth_ = std::min(depth_ + push, reach_);
    target_ = poseOn(*place_);
  } else {
    target_.position = withinReach(target_.position + move + push * axis);
  }
  const double least = motion.push_tool_notches != 0 ? notch_seconds : least_way_seconds;
  requests.push_back(Request::moveTool(target_, std::clamp(seconds, least, most_way_seconds)));
}

void ToolHand::glideTo(const Vec3& touched, double seconds, std::vector<Request>& requests) {
  const SkinSurface::Place place = skin_.nearest(touched);
  const bool far = !place_ || std::exchange(lifted_, false) || (place.point - place_->point).norm() > jump ||
                   place.normal.dot(place_->normal) < 0.7;
  if (!far && (place.point - place_->point).norm() < 1e-6) return;
  if (far) {
    tilt_ = Quat::Identity();
    depth_ = 0;
    wayAround(poseOn(place), place.normal, requests);
  } else {
    const double way = (place.point - place_->point).norm();
    requests.push_back(
        Request::moveTool(poseOn(place), std::clamp(std::max(seconds, way / glide_speed), least_way_seconds, 2.0)));
  }
  place_ = place;
  target_ = poseOn(place);
}

/// Off the skin, over it and down to `to`; round the organ where that is on its other side.
void ToolHand::wayAround(const Pose& to, const Vec3& up, std::vector<Request>& requests) const {
  const double lift = std::max(2 * tool_radius_, 0.25 * (to.position - target_.position).norm());
  const Vec3 from_up = target_.orientation * Vec3::UnitZ();
  Pose lifted = target_, above = to;
  lifted.position += lift * from_up;
  above.position += lift * up;
  const auto seconds = [](const Pose& a, const Pose& b, double speed) {
    return std::max(0.05, (a.position - b.position).norm() / speed);
  };
  requests.push_back(Request::moveTool(lifted, seconds(target_, lifted, travel_speed)));
  Pose last = lifted;
  if (from_up.dot(up) < 0.3) {
    Vec3 out = 0.5 * (lifted.position + above.position) - centre_;
    if (out.norm() < 1e-6) out = Vec3::UnitZ();
    Pose middle;
    middle.position = centre_ + (organ_radius_ + 2 * tool_radius_) * out.normalized();
    middle.orientation = lifted.orientation.slerp(0.5, above.orientation);
    requests.push_back(Request::thenMoveTool(middle, seconds(last, middle, travel_speed)));
    last = middle;
  }
  requests.push_back(Request::thenMoveTool(above, seconds(last, above, travel_speed)));
  requests.push_back(Request::thenMoveTool(to, seconds(above, to, touch_speed)));
}

}  // namespace palpate::app
