#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mechanics/materials/material.h"
#include "simulation/model.h"
#include "simulation/report.h"
#include "simulation/state.h"
#include "simulation/trust.h"

namespace palpate {

// How far off forces are because the cloud is no finer.
//
// What moves as it is told stores the energy W, and a force is its slope; so a force is off by about the share of W
// that a finer cloud would not store, or would store besides. That share follows from how much the deformation changes
// from point to point (Zienkiewicz and Zhu 1987, with means in place of fits, which did not do better), from how much
// it changes within what a point stands for, which one point does not see, and from volume that points can't hold:
//
//   e W = sum_q V_q (c_0 mu |F_q - F*_q|^2 + c_1 mu mean_a |F_a - F*_q|^2 / 5 + c_2 K (J_q - J*_q)^2)
//
// F_a the mean F around node a of point q's cell, of points of q's material alone: what jumps at a border is right.
// F*_q and J*_q are the means over the cell's nodes. Fibres under tension add half their modulus times (n . D n)^2 to
// mu |D|^2.
// Wherever the cloud is too coarse counts: below a small tool, in a thin layer, at a bonded edge. Measured on scenes
// drawn by lot (`mtled verify matrix`, engine/mechanics/README.md); an estimate, no bound.

/// e for a displacement. For batch: allocates.
/// @param u  m (node_count)  @param strain_energy  W, J; below a millionth of Model::rest_energy e is 0
/// @param tool_force  N. Where surface loads strain the body, too, a tool's force is not the slope of their energy: the
///                    whole error is then taken for the tool's, over what its force stores by Hertz (at most 1)
double expectedError(const Model& model, std::span<const Material> materials, const AlignedVector<Double4>& u,
                     double strain_energy, double tool_force = 0);

/// e while ticks go on: of a moment, some points a tick, so that it costs a hundredth of a tick, and nothing at rest.
/// What it says is of the moment before the last sweep of all points, at most 0.8 s ago at 500 Hz; 0 until there was
/// one. Of a tool on tissue under surface loads it is that of the tool's force: what the loads alone had, when nothing
/// touched last, is taken off.
/// Belongs to who steps (Workspace), not to the state: after a restore it begins anew.
/// Test: simulation/resolution_test.cpp
class ResolutionWatch {
 public:
  explicit ResolutionWatch(const Model& model);

  /// Nothing is known any more.
  void restart();

  /// The body goes on with other nodes (place.h): what the watch before said holds until this one has seen all points.
  void goOnFrom(const ResolutionWatch& before);

  /// A tick is done. Fills expected_error and error_force of the report.
  /// Real-time: no allocation, no lock, no throw.
  void advance(const Model& model, std::span<const Material> materials, const AlignedVector<Float4>& u,
               StepReport& report);

 private:
  using Strain = std::array<float, 10>;  // F - 1, row by row, and J - 1
  void gather(const Model& model, std::size_t begin, std::size_t end);
  void compare(const Model& model, std::span<const Material> materials, std::size_t begin, std::size_t end);

  AlignedVector<Float4> u_;             // (node_count) of the moment
  std::vector<Strain> at_;              // (point_count)
  std::vector<Strain> mean_;            // (group_count)
  std::size_t next_ = 0;                // of the points, twice over: gathered, then compared
  double sum_ = 0, energy_ = 0;         // J
  double force_ = 0;                    // N, of the moment
  double touch_ = 0;                    // N, of the moment: of tools on tissue under surface loads
  double load_error_ = 0;               // of surface loads alone
  double error_ = 0, error_force_ = 0;  // of the last
};

/// What a run's last tick is worth, all at once: for its end, and runs that are over before a sweep is. Allocates.
/// @param report  of that tick  @param time  s
void addLast(const Model& model, const State& state, const StepReport& report, double time, RunTrust& trust);

/// The spacing of the cloud where the first tool meets the organ, m.
double spacingAtTool(const Body& body);

/// A sentence for whoever loads a scene whose tool is too small for its cloud, before a press has shown it; "" where
/// nodes are no further apart than 0.8 of the tool's radius.
std::string resolutionWarning(const Body& body);

}  // namespace palpate
