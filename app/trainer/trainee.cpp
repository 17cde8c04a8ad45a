#include "app/trainer/trainee.h"

#include <algorithm>
#include <cmath>

#include "base/turn.h"

namespace palpate::app {

namespace {

constexpr double travel_seconds = 0.16, press_seconds = 0.20, back_seconds = 0.08;
constexpr double hover = 0.006;        // m, over the skin between two places
constexpr double rise_begin = 0.6;     // of the depth
constexpr double held_margin = 0.015;  // m, from what is held
constexpr double facing = 0.45;        // cosine between skin and tool, where it presses
constexpr double around_steps = 4.5;   // of the places that a place is compared with
constexpr double marked_ratio = 1.25;  // of the slope to the median around, from which a place is marked
constexpr double alone_steps = 3;      // within which only the stiffest is marked

double smooth(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

/// What is held is stiff without a lump.
bool isNearHeld(const Scene& scene, const Vec3& x) {
  return std::any_of(scene.boundaries.begin(), scene.boundaries.end(),
                     [&](const BoundarySpec& held) { return held.region.contains(x, held_margin); });
}

/// Places a step apart, thinned from the skin's vertices in their order, row by row across the tool's way.
std::vector<SkinSurface::Place> gridOn(const Model& model, double step) {
  const SkinSurface skin(model.skin.surface);
  const Vec3 towards = -model.scene.tools[0].direction;
  std::vector<SkinSurface::Place> places;
  for (const Vec3& X : model.skin.surface.vertices) {
    const SkinSurface::Place place = skin.nearest(X);
    if (place.normal.dot(towards) < facing || isNearHeld(model.scene, place.point)) continue;
    const bool free = std::all_of(places.begin(), places.end(), [&](const SkinSurface::Place& other) {
      return (other.point - place.point).norm() >= step;
    });
    if (free) places.push_back(place);
  }
  const auto row = [&](const SkinSurface::Place& place) { return std::floor(place.point.y() / step); };
  std::sort(places.begin(), places.end(), [&](const SkinSurface::Place& a, const SkinSurface::Place& b) {
    if (row(a) != row(b)) return row(a) < row(b);
    const bool back = std::fmod(std::abs(row(a)), 2) > 0.5;
    return back ? a.point.x() > b.point.x() : a.point.x() < b.point.x();
  });
  return places;
}

}  // namespace

Trainee::Trainee(const Model& model, double depth, double step)
    : depth_(depth),
      step_(step),
      rate_hz_(model.scene.dynamics.rate_hz),
      places_(gridOn(model, step)),
      slopes_(places_.size(), 0.0),
      ticks_per_place_(std::llround((travel_seconds + press_seconds + back_seconds) * rate_hz_)),
      start_(model.tools.first().start.pose) {}

void Trainee::restart() {
  tick_ = 0;
  first_ = 0;
  std::fill(slopes_.begin(), slopes_.end(), 0.0);
}

Pose Trainee::next(const State&, const StepReport& last) {
  const std::int64_t k = tick_++;
  const auto n = static_cast<std::size_t>(k / ticks_per_place_);
  if (n >= places_.size()) return start_;
  const double time = static_cast<double>(k % ticks_per_place_) / rate_hz_;
  const SkinSurface::Place& place = places_[n];
  const auto over = [](const SkinSurface::Place& p) { return Vec3(p.point + hover * p.normal); };

  Pose pose;
  pose.orientation = uprightOn(place.normal);
  if (time < travel_seconds) {
    const double s = smooth(time / travel_seconds);
    const Vec3 from = n > 0 ? over(places_[n - 1]) : start_.position;
    const Quat turned = n > 0 ? uprightOn(places_[n - 1].normal) : start_.orientation;
    pose.position =
        from + s * (over(place) - from) + 4 * s * (1 - s) * 0.3 * (over(place) - from).norm() * place.normal;
    pose.orientation = turned.slerp(s, pose.orientation);
    first_ = 0;
    return pose;
  }
  const double pressing = (time - travel_seconds) / press_seconds;
  if (pressing <= 1) {
    const double d = smooth(pressing) * (depth_ + hover) - hover;
    pose.position = place.point - d * place.normal;
    const double force = last.tool_force.norm();
    if (d <= rise_begin * depth_) first_ = force;
    slopes_[n] = (force - first_) / ((1 - rise_begin) * depth_);
    return pose;
  }
  const double back = smooth((pressing - 1) * press_seconds / back_seconds);
  pose.position = place.point - ((1 - back) * (depth_ + hover) - hover) * place.normal;
  return pose;
}

std::vector<Vec3> Trainee::marks() const {
  std::vector<Vec3> marked;
  for (std::size_t a = 0; a < places_.size(); ++a) {
    std::vector<double> around;
    bool highest = true;
    for (std::size_t b = 0; b < places_.size(); ++b) {
      const double distance = (places_[a].point - places_[b].point).norm();
      if (distance < around_steps * step_) around.push_back(slopes_[b]);
      if (b != a && distance < alone_steps * step_ && slopes_[b] > slopes_[a]) highest = false;
    }
    std::nth_element(around.begin(), around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2), around.end());
    if (highest && slopes_[a] > marked_ratio * around[around.size() / 2]) marked.push_back(places_[a].point);
  }
  return marked;
}

}  // namespace palpate::app
