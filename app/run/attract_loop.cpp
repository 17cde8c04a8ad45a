#include "app/run/attract_loop.h"

#include <algorithm>
#include <cmath>

namespace palpate::app {

namespace {

constexpr int shown_places = 4;
constexpr double least_facing = 0.7;   // cosine between the skin's normal and the way back to the tool
constexpr double shown_depth = 0.7;    // of the tool's radius
constexpr double shown_speed = 0.008;  // m/s: slow enough to be watched

/// What happens at a place, s after it is its turn.
enum class Deed { Go, Press, Lift };
struct Step {
  double at;
  Deed deed;
};
constexpr Step steps[] = {{0, Deed::Go}, {2.5, Deed::Press}, {5.5, Deed::Lift}};
constexpr int step_count = static_cast<int>(std::size(steps));
constexpr double place_seconds = 7, home_seconds = 4;  // home: until it is where it began

}  // namespace

std::vector<Vec3> facingPlaces(const Body& model, int count) {
  const std::vector<Vec3>& X = model.skin.surface.vertices;
  const Pose& start = model.tools.first().start.pose;
  const Vec3 back = start.orientation * Vec3::UnitZ();
  std::vector<Vec3> normals(X.size(), Vec3::Zero());
  for (const auto& [a, b, c] : model.skin.surface.triangles) {
    const Vec3 area = (X[b] - X[a]).cross(X[c] - X[a]);
    for (const int v : {a, b, c}) normals[v] += area;
  }
  std::vector<Vec3> facing;
  for (std::size_t v = 0; v < X.size(); ++v)
    if (normals[v].normalized().dot(back) > least_facing) facing.push_back(X[v]);
  std::vector<Vec3> places;
  while (static_cast<int>(places.size()) < std::min(count, static_cast<int>(facing.size()))) {
    const auto distance = [&](const Vec3& x) {  // to the places so far; of the first one to the tool
      double least = places.empty() ? -(x - start.position).norm() : 1e30;
      for (const Vec3& place : places) least = std::min(least, (x - place).norm());
      return least;
    };
    places.push_back(*std::max_element(facing.begin(), facing.end(),
                                       [&](const Vec3& a, const Vec3& b) { return distance(a) < distance(b); }));
  }
  // Not at the very edge: each half way to the first.
  for (std::size_t k = 1; k < places.size(); ++k) places[k] = 0.5 * (places[k] + places[0]);
  return places;
}

AttractLoop::AttractLoop(const Body& model)
    : places_(facingPlaces(model, shown_places)), depth_(shown_depth * model.scene.tools[0].shape.radius) {}

std::vector<Request> AttractLoop::next(double seconds, ToolHand& hand, const Pose& goal) {
  const double period = show_seconds + rest_seconds;
  const int round = static_cast<int>(seconds / period);
  if (round != round_) {
    round_ = round;
    next_step_ = 0;
  }
  const double now = seconds - round * period;
  rests_ = places_.empty() || now >= shown_places * place_seconds + home_seconds;
  if (places_.empty()) return {};
  const int place = next_step_ / step_count;
  if (place > shown_places) return {};
  const Step& step = steps[next_step_ % step_count];
  if (now < place * place_seconds + step.at) return {};
  if (place == shown_places) {  // all were shown
    next_step_ = (shown_places + 1) * step_count;
    return hand.toStart();
  }
  ++next_step_;
  switch (step.deed) {
    case Deed::Go:
      return hand.bring(places_[static_cast<std::size_t>(place) % places_.size()]);
    case Deed::Press:
      return hand.press(depth_, shown_speed, goal);
    case Deed::Lift:
      return hand.press(-0.5 * depth_, 2 * shown_speed, goal);
  }
  return {};
}

}  // namespace palpate::app
