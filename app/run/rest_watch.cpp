#include "app/run/rest_watch.h"

#include <algorithm>
#include <limits>

#include "setup/free_axes.h"

namespace palpate::app {
namespace {

// A node that far from rest, relative to the organ's size, would be a tenth of the promised drift.
constexpr double kRestShare = 0.1 * RestWatch::drift_limit;

using Displacements = AlignedVector<Float4>;

/// Largest |a - b - shift| of a node, m.
double farthest(const Displacements& a, const Displacements& b, const Vec3& shift = Vec3::Zero()) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, (toVec3(a[i]) - toVec3(b[i]) - shift).norm());
  return largest;
}

double farthest(const Displacements& a) {
  double largest = 0;
  for (const Float4& of_node : a) largest = std::max(largest, toVec3(of_node).norm());
  return largest;
}

Vec3 meanOf(const Displacements& u) {
  Vec3 sum = Vec3::Zero();
  for (const Float4& of_node : u) sum += toVec3(of_node);
  return sum / static_cast<double>(std::max<std::size_t>(u.size(), 1));
}

}  // namespace

RestWatch::RestWatch(const Body& model, double hold_s, int most_nodes)
    : hold_s_(hold_s),
      tick_seconds_(1 / model.scene.dynamics.rate_hz),
      dt_(model.dt),
      free_(freeAxes(model)),
      rests_unmoved_(model.scene.dynamics.gravity.isZero(0) && model.scene.loads.empty() && free_.isZero(0) &&
                     motionEnd(model.scene) <= 0),
      has_past_(free_ == Vec3::Ones() || model.scene.organs.size() > 1 ||
                std::any_of(model.scene.rigid.begin(), model.scene.rigid.end(),
                            [](const RigidSpec& rigid) { return rigid.friction > 0; })) {
  for (Displacements* kept : {&first_, &anchor_})
    kept->reserve(std::max(model.X.size(), static_cast<std::size_t>(most_nodes)));
  Vec3 low = model.X.empty() ? Vec3(Vec3::Zero()) : model.X[0], high = low;
  for (const Vec3& X : model.X) {
    low = low.cwiseMin(X);
    high = high.cwiseMax(X);
  }
  organ_size_ = (high - low).norm();
  rest_speed_ = kRestShare * organ_size_ * 0.5 * std::max(model.scene.dynamics.damping, 1.0);
}

double RestWatch::restRadius() const { return std::min(rest_speed_ * rest_hold_s, kRestShare * organ_size_); }

bool RestWatch::update(const State& state, const StepReport& last) {
  speed_ = static_cast<double>(last.max_increment) / dt_;
  const bool was_held = held_;
  held_ =
      std::any_of(last.loads.begin(), last.loads.end(), [](const ToolLoad& load) { return load.contact_count > 0; });
  if (was_held && !held_) still_time_ = near_time_ = 0;
  rest_time_ += tick_seconds_;
  still_time_ = speed_ <= rest_speed_ ? still_time_ + tick_seconds_ : 0;
  if (near_time_ == 0 || state.place != anchor_place_ || !(farthest(state.u, anchor_) <= restRadius() + rounding_)) {
    anchor_.assign(state.u.begin(), state.u.end());  // there is room
    anchor_place_ = state.place;
    rounding_ = 2 * std::numeric_limits<float>::epsilon() * slidOf(state).norm();
    near_time_ = 0;
  }
  near_time_ += tick_seconds_;
  return rested() || rest_time_ >= longest_rest_s;
}

Vec3 RestWatch::slidOf(const State& state) const { return free_.cwiseProduct(meanOf(state.u)); }

double RestWatch::driftOf(const State& state) {
  if (held_ || has_past_) return 0;
  const bool elsewhere = has_first_ && state.place != first_place_;
  if (!has_first_ || (elsewhere && !rests_unmoved_)) {
    first_.assign(state.u.begin(), state.u.end());
    first_place_ = state.place;
  } else if (elsewhere) {
    return farthest(state.u);
  }
  has_first_ = true;
  return farthest(state.u, first_, free_.cwiseProduct(meanOf(state.u) - meanOf(first_)));
}

}  // namespace palpate::app
