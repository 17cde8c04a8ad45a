#include "realtime/loop/cloud_follower.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>

#include "step/resolution.h"
#include "step/tool_bodies.h"
#include "step/tool_contact.h"
#include "step/trust.h"

namespace palpate {
namespace {

constexpr auto look_every = std::chrono::microseconds(200);  // while it waits

int threadsLeft(int physics_threads) {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()) - physics_threads);
}

}  // namespace

CloudFollower::CloudFollower(const Places& places, TissuePhysics& physics, PlaceWorker& worker)
    : places_(places),
      physics_(physics),
      worker_(worker),
      around_(wantedSpacing(places, physics.place()->place.index)) {
  velocity_.fill(Vec3::Zero());
  const std::vector<ToolSpec>& specs = places_.scene.tools;
  for (std::size_t t = 0; t < specs.size(); ++t) coarsest_[t] = coarsest_nodes * touchRadius(specs[t].shape);
}

CloudFollower::~CloudFollower() { drop(); }

void CloudFollower::drop() {
  if (pending_ != nullptr) worker_.giveBack(std::exchange(pending_, nullptr));
}

/// Whether some tool's ball is around it better there than here, and none worse.
bool CloudFollower::isNearer(const PlaceIndex& index, const ToolPostures& tools) const {
  const PlaceIndex& present = physics_.place()->place.index;
  bool nearer = false;
  for (std::size_t t = 0; t < present.size(); ++t) {
    if (index[t] == present[t]) continue;
    const auto distance = [&](const PlaceIndex& i) {
      return (places_.centres[static_cast<std::size_t>(i[t])] - tools[t].pose.position).squaredNorm();
    };
    if (!(distance(index) < distance(present))) return false;
    nearer = true;
  }
  return nearer;
}

/// Has the change to a place pending, if it can be had.
bool CloudFollower::get(const PlaceIndex& next, bool waits, const std::atomic<bool>& stop) {
  const PlaceIndex present = physics_.place()->place.index;
  const auto fits = [&] {
    return pending_ != nullptr && pending_->from->place.index == present && pending_->to->place.index == next;
  };
  for (;;) {
    if (fits()) return true;
    if (PlaceChange* const made = worker_.take()) {
      drop();
      pending_ = made;
      if (fits()) return true;
    }
    if (!waits || worker_.failed(next) || stop.load(std::memory_order_relaxed)) return false;
    worker_.want({present, next, no_place});
    const auto begin = std::chrono::steady_clock::now();
    std::this_thread::sleep_for(look_every);
    waited_ns_ += std::chrono::nanoseconds(std::chrono::steady_clock::now() - begin).count();
  }
}

bool CloudFollower::swap(double most_rise) {
  const auto begin = std::chrono::steady_clock::now();
  const std::optional<PlaceIndex> let_go = physics_.goTo(*pending_, most_rise);
  const std::chrono::duration<double, std::micro> taken = std::chrono::steady_clock::now() - begin;
  if (!let_go) return false;
  longest_swap_us_ = std::max(longest_swap_us_, taken.count());
  let_go_ = *let_go;
  ++swap_count_;
  drop();
  return true;
}

bool CloudFollower::follow(bool waits, const std::atomic<bool>& stop) {
  const Place& here = physics_.place()->place;
  const PlaceIndex present = here.index;
  const ToolPostures at = posturesOf(physics_.state());
  ToolPostures tools = posturesAtRest(here.model, physics_.state());
  const auto count = static_cast<std::size_t>(places_.scene.tools.size());
  const double rate = places_.scene.dynamics.rate_hz, share = std::min(1.0, 1 / (velocity_seconds * rate));
  const double make_seconds = worker_.madeCount() > 0 ? worker_.madeSeconds() / worker_.madeCount() : 0;
  const double fastest = 2 * largestToolSpeed(places_.scene);
  ToolPostures soon, then;
  for (std::size_t t = 0; t < count; ++t) {
    Vec3& x = tools[t].pose.position;
    // One that the skin has not followed out of a press is over what it pressed.
    if (x == at[t].pose.position && places_.organ.inside(x)) x = places_.centres[static_cast<std::size_t>(present[t])];
    const Vec3 moved = has_moved_ ? Vec3(x - position_[t]) : Vec3(Vec3::Zero());
    if (!has_moved_) velocity_[t].setZero();
    if (rate * moved.norm() < fastest) velocity_[t] += share * (rate * moved - velocity_[t]);  // else it began to touch
    position_[t] = x;
    soon[t] = then[t] = tools[t];
    const double speed = velocity_[t].norm();
    if (!(speed > 0)) continue;
    const double far = std::min(speed * ahead_seconds, std::max(places_.sizes.stride, speed * make_seconds));
    soon[t].pose.position += far / speed * velocity_[t];
    then[t].pose.position += 2 * far / speed * velocity_[t];
  }
  has_moved_ = true;

  const PlaceIndex next = nextPlace(places_, present, tools);
  const PlaceIndex wanted = next != present ? next : nextPlace(places_, present, soon);
  late_ = false;
  bool swapped = false;
  if (next == present) {
    refused_ = false;
  } else {
    const bool there = get(next, waits, stop);
    // One that was asked for earlier is better than none.
    const bool usable = there || (!waits && pending_ != nullptr && pending_->from->place.index == present &&
                                  isNearer(pending_->to->place.index, tools));
    const std::int64_t every = physics_.state().local_mass.active ? squeezed_swap_ticks : swap_ticks;
    if (usable && physics_.state().tick % every == 0) {
      swapped = swap(most_energy_rise);
      refused_ = !swapped;
    }
    late_ = !there || refused_;
    late_ticks_ += late_;
  }
  const PlaceIndex& now = physics_.place()->place.index;
  const PlaceIndex to = swapped ? nextPlace(places_, now, late_ ? tools : soon) : wanted;
  PlaceIndex after = nextPlace(places_, to, then);
  if (to != now && !worker_.failed(to)) {
    const bool there = pending_ != nullptr && pending_->from->place.index == now && pending_->to->place.index == to;
    if (!there) worker_.want({now, to, after});
  } else {
    worker_.want({now, no_place, after != now ? after : no_place});
  }
  return swapped;
}

bool CloudFollower::goTo(const PlaceIndex& index, const std::atomic<bool>& stop) {
  let_go_ = no_place;
  late_ = false;
  if (index == physics_.place()->place.index) return true;
  if (!get(index, true, stop)) return false;
  swap(std::numeric_limits<double>::infinity());
  return true;
}

double CloudFollower::expectedError() {
  const Place& here = physics_.place()->place;
  const ToolPostures tools = posturesAtRest(here.model, physics_.state());
  const std::size_t count = places_.scene.tools.size(), own = places_.scene.discretization.refine.size();
  if (around_.refinements.size() != own + count) return 0;  // for some tool the whole body is fine enough
  for (std::size_t t = 0; t < count; ++t)
    around_.refinements[own + t].centre = places_.centres[static_cast<std::size_t>(here.index[t])];
  double coarse = 1;
  for (std::size_t t = 0; t < count; ++t) coarse = std::max(coarse, around_.at(tools[t].pose.position) / coarsest_[t]);
  return coarse > 1 ? std::min(1.0, TrustLimits::expected_error * coarse * coarse) : 0;
}

void CloudFollower::expect(const PlaceIndex& index) {
  const PlaceIndex& now = physics_.place()->place.index;
  if (index != no_place && index != now) worker_.want({now, index, no_place});
}

FollowingTissue::FollowingTissue(std::shared_ptr<PlaceSource> shared, int threads, bool timed)
    : FollowingTissue(
          shared, threads, timed, [shared](const PlaceIndex& index) { return shared->at(index); }, shared->keeps()) {}

FollowingTissue::FollowingTissue(std::shared_ptr<PlaceSource> shared, int threads, bool timed, PlaceWorker::Make make,
                                 bool kept)
    : source(std::move(shared)),
      start(std::make_shared<ReadyPlace>(source->start(), std::make_shared<SpinTeam>(threads))),
      physics(places(), start),
      worker(places(), std::move(make), start, timed ? threadsLeft(threads) : 0, kept),
      follower(places(), physics, worker) {}

void FollowingTissue::keepToClock() { worker.giveWay(threadsLeft(physics.team().size())); }

}  // namespace palpate
