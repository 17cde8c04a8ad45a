#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mtled/bench/bench_body.h"
#include "mtled/bench/feature_report.h"
#include "simulation/state.h"
#include "simulation/workspace.h"

namespace palpate::tools {

/// Shows something that grows: this thread's time on its core, or its instructions.
using Meter = std::function<double()>;

/// A loop of ticks on one thread that does or does not use a feature.
class FeatureLoop {
 public:
  virtual ~FeatureLoop() = default;
  /// Takes the memory for a run of so many ticks.
  virtual void prepare(int /*ticks*/) {}
  /// One tick that is not counted, since it finds the caches full of another loop's data, then `ticks`.
  /// @param ticks  as prepared
  /// @return by how much the meter grew in these
  virtual double run(int ticks, const Meter& meter) = 0;
  virtual const State& state() const = 0;
};

/// Two loops that differ in what `name` says.
struct FeaturePair {
  FeatureRow row;  // what they are; numbers still to be measured
  std::shared_ptr<FeatureLoop> with, without;
};

/// The features that a scene may use, on a neo-Hookean box without node patches under a ball (bench_body.h): each on
/// beside off, and
/// all off beside loops that were written, and a kernel that was compiled, without them.
class FeatureBench {
 public:
  /// @param watch  told what is being set up
  FeatureBench(const BenchSize& size, const std::function<void(const std::string&, double)>& watch);
  ~FeatureBench();

  const Model& plain() const { return *models_.front(); }
  const Model& adaptive() const { return *models_.back(); }
  std::vector<FeaturePair>& pairs() { return pairs_; }

 private:
  std::vector<std::unique_ptr<Model>> models_;          // plain, with node patches, with adaptive points
  std::vector<std::unique_ptr<Workspace>> workspaces_;  // of each
  std::vector<FeaturePair> pairs_;
};

/// Runs all pairs in short rounds by turns, now the one first, now the other, and fills in their rows: processor
/// time, its median
/// over the rounds, and the median of the rounds' ratios, since what slows one slows its partner, too. Those with a
/// limit have five times as many.
/// @param seconds  for each pair
void timePairs(std::vector<FeaturePair>& pairs, double seconds, const std::function<void(double)>& watch);

}  // namespace palpate::tools
