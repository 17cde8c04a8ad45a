#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "discretization/nodes/spacing_field.h"
#include "realtime/loop/place_worker.h"
#include "realtime/loop/state_history.h"
#include "setup/place_source.h"

namespace palpate {

/// Has the loop's physics at the place for the tissue that the tools press (posturesAtRest, nextPlace), between two
/// ticks; tissue that coarse nodes would tear (TissuePhysics::goTo) stays where it is, late. A place and the way to
/// it come from a worker, which is asked ahead in the direction that the tools go; where they are not ready the loop
/// stays where it is, or, where it need not keep to the clock, waits: then the run depends on its input alone. A
/// recording has the tick and the place of each swap, and its replay waits for them.
/// Loop thread only. Real-time where it does not wait: no allocation, no lock, no throw.
/// Test: realtime/loop/cloud_follower_test.cpp
class CloudFollower {
 public:
  /// The worker is asked for where the tools are in so long, but no further than the next place; or, where it takes
  /// longer to make one than they take to the next, for where they are by then.
  static constexpr double ahead_seconds = 0.6;
  static constexpr double velocity_seconds = 0.05;  // over which the tools' velocity is smoothed
  /// TissuePhysics::goTo. Ordinary changes bring up to 1 %, those that tore the tissue under a rough hand 5 to 5,000 %.
  static constexpr double most_energy_rise = 0.05;
  /// Changes are tried at multiples of so many ticks, as a state alone can tell; of more where tissue is squeezed, and
  /// they may be refused: a try costs two evaluations of the forces.
  static constexpr std::int64_t swap_ticks = 8, squeezed_swap_ticks = 32;

  /// All must outlive this.
  CloudFollower(const Places& places, TissuePhysics& physics, PlaceWorker& worker);
  ~CloudFollower();
  CloudFollower(const CloudFollower&) = delete;
  CloudFollower& operator=(const CloudFollower&) = delete;

  /// Before a tick: goes on where the rule says.
  /// @param waits  for what is not ready, until `stop`
  /// @return whether the place is another now
  bool follow(bool waits, const std::atomic<bool>& stop);

  /// Goes to a place that a recording says, and waits for it until `stop`. False: stopped, or it can't be made.
  bool goTo(const PlaceIndex& index, const std::atomic<bool>& stop);

  /// Where a recording will go next, so that it is ready then; no_place: nowhere.
  void expect(const PlaceIndex& index);

  /// The tools did not go, but were put where they are.
  void restart() { has_moved_ = refused_ = false; }

  /// The least to expect of the forces' error, as a share, where the place has nodes too far apart for a tool: with the
  /// square of their distance; the estimate of the tissue's own (ResolutionWatch) is then one of a cloud that may be
  /// blind to it. Of a ball of 2 mm that places came late to forces were off by 39 %, with 5 % expected.
  double expectedError();

  const std::shared_ptr<ReadyPlace>& place() const { return physics_.place(); }
  /// Places of no kept state are let go.
  void holdOnly(const StateHistory& history) {
    physics_.holdOnly([&](const PlaceIndex& place) { return history.has(place); });
  }
  /// The place that the last swap let go, to whose states nothing goes back; no_place: none.
  const PlaceIndex& letGo() const { return let_go_; }
  /// The last tick was one on a place that was not ready, or refused.
  bool isLate() const { return late_; }
  std::int64_t swapCount() const { return swap_count_; }
  std::int64_t lateTicks() const { return late_ticks_; }
  double longestSwap() const { return longest_swap_us_; }  // us
  std::int64_t waited() const { return waited_ns_; }       // ns, for places, in all

 private:
  bool get(const PlaceIndex& next, bool waits, const std::atomic<bool>& stop);
  bool isNearer(const PlaceIndex& index, const ToolPostures& tools) const;
  bool swap(double most_rise);
  void drop();

  const Places& places_;
  TissuePhysics& physics_;
  PlaceWorker& worker_;
  PlaceChange* pending_ = nullptr;          // taken from the worker
  SpacingField around_;                     // that a place wants, with balls around some centres
  std::array<double, max_tools> coarsest_;  // m, nodes' distance that a tool can do with
  bool has_moved_ = false;
  std::array<Vec3, max_tools> position_, velocity_;  // m, m/s
  PlaceIndex let_go_ = no_place;
  bool late_ = false;
  bool refused_ = false;  // the last change that was tried
  std::int64_t swap_count_ = 0, late_ticks_ = 0, waited_ns_ = 0;
  double longest_swap_us_ = 0;
};

/// A body whose cloud follows the tool, ready to run: physics, worker and follower of one loop.
struct FollowingTissue {
  /// @param threads  physics threads
  /// @param timed    the loop will keep to the clock, and the worker must leave cores to it
  FollowingTissue(std::shared_ptr<PlaceSource> shared, int threads, bool timed);
  /// @param make  gets places instead of the source
  /// @param kept  what `make` made once it reads from then on
  FollowingTissue(std::shared_ptr<PlaceSource> shared, int threads, bool timed, PlaceWorker::Make make, bool kept);

  /// (any thread) From now on the loop keeps to the clock.
  void keepToClock();

  const Places& places() const { return source->places(); }
  const Model& model() const { return start->place.model; }

  const std::shared_ptr<PlaceSource> source;
  const std::shared_ptr<ReadyPlace> start;
  TissuePhysics physics;
  PlaceWorker worker;
  CloudFollower follower;
};

}  // namespace palpate
