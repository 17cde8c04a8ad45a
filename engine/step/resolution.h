#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mechanics/materials/material.h"
#include "model/model.h"
#include "model/report.h"
#include "model/state.h"
#include "step/trust.h"

namespace palpate {

// How far off forces are because the cloud is no finer.
//
// What moves as it is told stores the energy W, and a force is its slope; so a force is off by about the share of W
// that a finer cloud would not store, or would store besides. Where deformation changes from point to point by more
// than a linear function does (Zienkiewicz and Zhu 1987: L_q, from fits around the nodes of a point's cell), the body
// is too stiff, and so it is where volume changes within what one point stands for, and has to be held. What changes
// of the shape within that, one point does not see: the body is too soft. The two make up for each other:
//
//   e = |S - M|,  S W = sum_q V_q (c_0 E(F_q - L_q) + c_1 K var_q J),
//                 M W = sum_q V_q (c_2 E_s(var_q F) + c_4 E_f(var_q F)),  E = E_s + E_f
//
// E(D) what a deviation stores at a volume that stays, E_f its fibres, which turning strains by its square, so that it
// takes of a force more than its share of W; var_q the mean square of what is not seen (PointGroups::unseen),
// from the fits at the nodes of q's cell; several points in a cell see it, but have to hold volume all the same. Fits
// are of points of one material alone: what jumps at a border is right. The less is left the larger the two are, so e
// is the root of the squares of that and of c_3 (S + M)^2.
//
// What is pressed, by a tool or by loads, strains by more than a linear function below it, and fits there say several
// times too much (default liver: 9.9 % for 1.5 %). There F_a, J_a are means around the nodes, F_q* and J_q* theirs, and
//
//   e W = sum_q V_q (c_0 mu |F_q - F*_q|^2 + c_2 mu mean_a |F_a - F*_q|^2 / 5 + c_1 K (J_q - J*_q)^2)
//
// with half the modulus of fibres under tension times (n . D n)^2 added to mu |D|^2: too much for faces that are moved
// (bent: 1 to 2 % for 0.3). Below the edge of a flat end stress has no bound, and means see less of it: e times c_flat.
// Wherever the cloud is too coarse counts: below a small tool, in a thin layer, at a bonded edge. Measured on scenes
// drawn by lot (`mtled verify matrix`, engine/mechanics/README.md); an estimate, no bound.

// What is narrower than the nodes are apart no point sees. There a disk of a fixed share of their distance h is felt in
// place of one of radius a, and from a force F by a tip of radius t, with E* = 2 mu / (1 - nu), by Hertz or by a cone's
//
//   a^2 / h^2 = max(1.25 F t / (E* h^3), 2 F tan(half angle) / (pi E* h^2)),   e >= 0.64 h / a - 1, at most 2
//
// where 2 says that or more. Found on 33 touches by balls of 3 to 8 mm on nodes of 2 to 4.5 mm, of which the sums above
// say 8 to 13 %: 99 to 147 % too stiff at a / h of 0.23 to 0.26 (144 to 173 said), 17 to 79 at 0.37 to 0.49 (30 to 74),
// 11 or less at 0.55 and more but for one of 20 (the sums').

/// What a point sees: F - 1 and J - 1.
struct Strain {
  Mat3 H = Mat3::Zero();
  double dilatation = 0;

  void add(double weight, const Strain& other) {
    H += weight * other.H;
    dilatation += weight * other.dilatation;
  }
};

/// The parts of e W, J, without their constants.
struct ErrorSums {
  double pressed = 0;           // 0: a face is moved; else 1, or more below a flat end
  double uneven = 0, held = 0;  // of what is too stiff
  double missed = 0;            // of what is too soft,
  double missed_fibres = 0;     // and of that, but for presses, what fibres store

  /// @param at_nodes  the fits, or means, at the nodes of the point's cell
  void add(const Model& model, std::size_t point, const Material& material, const Strain& strain,
           const std::array<Strain, 4>& at_nodes);
  /// e W, J. @param strain_energy  W, J
  double off(double strain_energy) const;
};

/// e for a displacement. For batch: allocates.
/// @param u  m (node_count)  @param strain_energy  W, J; below a millionth of Model::rest_energy e is 0
/// @param tool_force  N; 0: none touches. Where surface loads strain the body, too, a tool's force is not the slope of
///                    their energy: the whole error is then taken for the tool's, over what its force stores by Hertz
///                    (at most 1)
/// @param tool  the first tool's pose, for narrow touches; null: they are not looked for
double expectedError(const Model& model, std::span<const Material> materials, const AlignedVector<Double4>& u,
                     double strain_energy, double tool_force = 0, const Pose* tool = nullptr);

/// e while ticks go on: of a moment, some points a tick, so that it costs a hundredth of a tick (a twentieth while the
/// tissue's energy changes), and nothing at rest. What it says is of the moment before the last sweep of all points, at
/// most 0.2 s ago at 500 Hz in a motion; until there was one, 1 with an error_force of 0: a doubt of its tick
/// (TrustLimits) that counts for no run (RunTrust). Of a tool on tissue under surface loads it is that of the tool's
/// force: what the loads alone had, when nothing touched last, is taken off. The force that accelerates the mass that
/// the scene's mass_scaling added is an error, too: the largest of late.
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
  void advance(const Model& model, const State& state, StepReport& report);

 private:
  using Rows = std::array<float, 10>;  // F - 1, row by row, and J - 1
  void gather(const Model& model, std::size_t begin, std::size_t end);
  void compare(const Model& model, std::span<const Material> materials, std::size_t begin, std::size_t end);

  void addScaledInertia(const Model& model, StepReport& report);

  AlignedVector<Float4> u_;    // (node_count) of the moment
  std::vector<Rows> at_;       // (point_count)
  std::vector<Rows> fit_;      // (group_count) at its node, or mean
  std::vector<int> material_;  // (node_count) of a point beside it, index into the scene's
  std::size_t next_ = 0;       // of the points, twice over: gathered, then compared
  ErrorSums sums_;
  double energy_ = 0;                   // J
  double force_ = 0;                    // N, of the moment
  double touch_ = 0;                    // N, of the moment: of tools on tissue under surface loads
  double narrow_ = 0;                   // of the moment, of a touch that is narrower than the nodes are apart
  double load_error_ = 0;               // of surface loads alone
  double error_ = 0, error_force_ = 0;  // of the last
  Vec3 momentum_ = Vec3::Zero();        // kg m/s, StepReport::scaled_momentum, smoothed
  double inertia_share_ = 0;            // what its change takes of the force: the largest, which falls within 0.1 s
  bool is_new_ = true;                  // no tick was seen with these masses
};

/// What a run's last tick is worth, all at once: for its end, and runs that are over before a sweep is. Allocates.
/// @param report  of that tick  @param time  s
void addLast(const Model& model, const State& state, const StepReport& report, double time, RunTrust& trust);

/// Nodes' distance over the radius that touches (touchRadius), from which on the tissue is felt too stiff: the liver's
/// 0.77 is 1.5 % off at its press, a kidney of 1.4 was by 10 %.
inline constexpr double coarsest_nodes = 0.8;

/// The spacing of the cloud where the first tool meets the organ, m.
double spacingAtTool(const Body& body);

/// A sentence for whoever loads a scene whose tool is too small for its cloud, before a press has shown it; "" where
/// nodes are no further apart than 0.8 of the tool's radius.
std::string resolutionWarning(const Body& body);

/// The same of a material that the cells see little of (Preparation::thin_layer); "" where there is none.
std::string layerWarning(const Body& body);

}  // namespace palpate
