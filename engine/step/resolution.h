#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "model/model.h"
#include "model/report.h"
#include "model/state.h"
#include "step/expected_error.h"
#include "step/trust.h"

namespace palpate {

/// e while ticks go on: of a moment, some points a tick, so that it costs a hundredth of a tick (a twentieth while the
/// tissue's energy changes), and nothing at rest. What it says is of the moment before the last sweep of all points, at
/// most 0.2 s ago at 500 Hz in a motion; until there was one, 1 with an error_force of 0: a doubt of its tick
/// (TrustLimits) that counts for no run (RunTrust). That a touch is narrow is said of the tick itself. The force that
/// accelerates the mass that the scene's mass_scaling added is an error, too: the largest of late. So is the largest
/// jump of a tool's force where the skin slipped off it since it touched: friction that stores more than it takes to go
/// on lets go in jerks, and when it does next is known to nobody.
/// Belongs to who steps (Workspace), not to the state: after a restore it begins anew.
/// Test: simulation/resolution_test.cpp
class ResolutionWatch {
 public:
  explicit ResolutionWatch(const Model& model);

  /// Nothing is known any more.
  void restart();

  /// The body goes on with other nodes (place.h): what the watch before said holds until this one has seen all points.
  void goOnFrom(const ResolutionWatch& before);

  /// A tick is done. Fills expected_error, error_force and error_by of the report, and the first two of its loads and
  /// round rigid bodies.
  /// Real-time: no allocation, no lock, no throw.
  void advance(const Model& model, const State& state, StepReport& report);

 private:
  using Rows = std::array<float, 10>;  // F - 1, row by row, and J - 1
  void gather(const Model& model, std::size_t begin, std::size_t end);
  void compare(const Model& model, std::span<const Material> materials, std::size_t begin, std::size_t end);

  void forget();
  void watchTools(const Model& model, const State& state);
  void begin(const Model& model, const State& state, const StepReport& report, PressList presses);
  double localShare(int by) const;
  void tell(const Model& model, const State& state, const PressList& presses, StepReport& report) const;
  void addScaledInertia(const Model& model, StepReport& report);
  void addJerks(const Model& model, const State& state, const PressList& presses, StepReport& report);

  /// Of a tool's force, or of what holds the body; 1 and 0: nothing.
  struct Known {
    double error = 0, force = 0;  // a share, and what it was found for, N
  };

  /// Of a tool that touches, or did of late: what jerks may let go for a moment.
  struct Jerks {
    Vec3 force = Vec3::Zero();  // N, smoothed
    double jump = 0;            // N, the largest since it touched
    double off = 0;             // s, since it let go
  };

  AlignedVector<Float4> u_;    // (node_count) of the moment
  std::vector<Rows> at_;       // (point_count)
  std::vector<Rows> fit_;      // (group_count) at its node, or mean
  std::vector<int> material_;  // (node_count) of a point beside it, index into the scene's
  std::size_t next_ = 0;       // of the points, twice over: gathered, then compared
  PressErrors moment_;
  double energy_ = 0;                               // J, of the moment
  double before_ = -1;                              // J, when nothing touched last; < 0: not known
  std::array<Known, max_pressers + 1> known_ = {};  // of the last moment: of what presses, and of what holds the body
  Vec3 momentum_ = Vec3::Zero();                    // kg m/s, StepReport::scaled_momentum, smoothed
  double inertia_ = 0;                              // N, that its change takes: the largest, which falls within 0.1 s
  bool is_new_ = true;                              // no tick was seen with these masses
  std::array<Jerks, max_tools> jerks_ = {};
  double settling_ = 0;   // s, in which the tissue comes to rest at another place by itself
  ToolPostures tool_at_;  // a tick ago
  double quickest_ = 0;   // m/s, of the tools of late
};

/// What a run's last tick is worth, all at once: for its end, and runs that are over before a sweep is. Allocates.
/// @param report  of that tick  @param time  s
void addLast(const Model& model, const State& state, const StepReport& report, double time, RunTrust& trust);

/// Nodes' distance over the radius that touches (touchRadius), from which on the tissue is felt too stiff: the liver's
/// 0.77 is 1.5 % off at its press, a kidney of 1.4 was by 10 %.
inline constexpr double coarsest_nodes = 0.8;

/// The spacing of the cloud where a tool meets the organ, m.
double spacingAtTool(const Body& body, std::size_t tool = 0);

/// A sentence for whoever loads a scene in which a tool, or a round rigid body, is too small for its cloud, before a
/// press has shown it; "" where nodes are no further apart than 0.8 of its radius.
std::string resolutionWarning(const Model& body);

/// The same of a material that the cells see little of (Preparation::thin_layer); "" where there is none.
std::string layerWarning(const Body& body);

}  // namespace palpate
