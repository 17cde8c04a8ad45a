#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "mechanics/materials/material.h"
#include "model/model.h"
#include "model/report.h"
#include "model/state.h"

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
// is the root of the squares of that and of c_3 (S + M)^2. Where what is held ends amid smooth skin, or is thin, stress
// has no bound, and fits see less of it: there V_q counts c_edge times.
//
// What is pressed, by a tool or by loads, strains by more than a linear function below it, and fits there say several
// times too much (default liver: 9.9 % for 1.5 %). There F_a, J_a are means around the nodes, F_q* and J_q* theirs, and
//
//   e W = sum_q V_q (c_0 mu |F_q - F*_q|^2 + c_2 mu mean_a |F_a - F*_q|^2 / 5 + c_1 K (J_q - J*_q)^2)
//
// with half the modulus of fibres under tension times (n . D n)^2 added to mu |D|^2: too much for faces that are moved
// (bent: 1 to 2 % for 0.3). Below the edge of a flat end stress has no bound, and means see less of it: e times c_flat.
// Of several tools, or rigid bodies that are round, each has the points that lie nearest to where it touches, and its
// share of W, as what their forces store by Hertz, 2/5 F d. Where something else strains the body, too (weight, loads,
// faces that are moved), most of W may have nothing to do with a tool: then only points near it count, within
// 3 (R + h), and of W what it stores more than before it touched, but at least by Hertz, at most 4 times that: loads,
// too, may have changed since.
// Wherever the cloud is too coarse counts: below a small tool, in a thin layer, at a bonded edge. Measured on scenes
// drawn by lot (`mtled verify matrix`, engine/mechanics/README.md); an estimate, no bound.

// What is narrower than the nodes are apart no point sees. There a disk of a fixed share of their distance h is felt in
// place of one of radius a, and from a force F by a tip of radius t, with E* = 2 mu / (1 - nu), by Hertz or by a cone's
//
//   a^2 / h^2 = max(1.25 F t / (E* h^3), 2 F tan(half angle) / (pi E* h^2)),   e >= 0.64 h / a - 1, at most 2
//
// where 2 says that or more. Of the force it is as much as the touch has of what is stored, by Hertz: a bar that bends
// by 20 mm gives by less than one where it is touched. Found on 33 touches by balls of 3 to 8 mm on nodes of 2 to 4.5
// mm, of which the sums above say 8 to 13 %: 99 to 147 % too stiff at a / h of 0.23 to 0.26 (144 to 173 said), 17 to 79
// at 0.37 to 0.49 (30 to 74), 11 or less at 0.55 and more but for one of 20 (the sums').

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
  double mixed = 0;             // of what mixes by an image, whose borders run through cells
  double missed = 0;            // of what is too soft,
  double missed_fibres = 0;     // and of that, but for presses, what fibres store

  /// @param at_nodes  the fits, or means, at the nodes of the point's cell
  void add(const Model& model, std::size_t point, const Material& material, const Strain& strain,
           const std::array<Strain, 4>& at_nodes);
  /// e W, J. @param strain_energy  W, J
  double off(double strain_energy) const;
};

/// A tool or round rigid body that presses; what all of a moment press is a list of these.
struct Press {
  int by = -1;        // of max_pressers; -1: none touches, and the force is that of what holds the body
  double force = 0;   // N; of jaws the pinch, where that is more
  int node = -1;      // where it touches; -1: not known
  bool flat = false;  // of a rigid body: by its end

  bool isTool() const { return by >= 0 && by < max_tools; }
  std::size_t tool() const { return static_cast<std::size_t>(by); }
  std::size_t rigid() const { return static_cast<std::size_t>(by - max_tools); }
};

/// e of each of the tools that press at a moment, or, where none does, of what holds the body.
class PressErrors {
 public:
  PressErrors() = default;
  /// @param presses   at most max_pressers; none, or one without a tool: of what holds the body
  /// @param material  (node_count) nodeMaterials
  /// @param strained  something else strains the body (strainedBeside)
  PressErrors(const Model& model, std::span<const Press> presses, std::span<const Material> materials,
              const std::vector<int>& material, bool strained);

  /// The groups' weights with which what points see becomes what nodes see.
  const std::vector<std::array<float, 4>>& weights(const PointGroups& groups) const {
    return share_[0].sums.pressed > 0 ? groups.share : groups.weight;
  }

  void add(const Model& model, std::size_t point, const Material& material, const Strain& strain,
           const std::array<Strain, 4>& at_nodes);

  std::span<const Press> presses() const { return {press_.data(), count_}; }
  /// @param k              of presses()
  /// @param strain_energy  W, J  @param before  W before the tools touched, J; < 0: not known
  double error(std::size_t k, double strain_energy, double before) const;
  /// How much of what it stores a press stores beside its touch, 0 .. 1: little where it bends the body.
  double localShare(std::size_t k, double strain_energy, double before) const;

 private:
  double storedBy(std::size_t k, double strain_energy, double before) const;  // J

  struct Share {
    ErrorSums sums;
    Vec3 at = Vec3::Zero();  // m, where it touches, in the body at rest
    double reach2 = 0;       // m^2, from there: of the points that count
    double stored = 0;       // J, by Hertz
  };
  std::size_t count_ = 1;
  bool strained_ = false;
  std::array<Press, max_pressers> press_;
  std::array<Share, max_pressers> share_;
};

/// Of a point of a cell that each node has (node_count): index into the scene's materials.
std::vector<int> nodeMaterials(const Model& model);

/// The node that moves a vertex of the skin most.
int heaviestNode(const Model& model, int vertex);

/// Weight, surface loads, faces or rigid bodies that are moved, or what is live of these.
bool strainedBeside(const Model& model, const LiveLoads& live = {});

/// The least e of a touch that is narrower than the nodes are apart, at its node, of this material.
double narrowError(const Model& model, const Material& material, const Press& press);

/// The largest e of what presses, for a displacement. For batch: allocates.
/// @param u              m (node_count)
/// @param strain_energy  W, J; below a millionth of Model::rest_energy e is 0
/// @param presses        nodes that are not known are found by the tips; none: of what holds the body
/// @param tips           of the tools, by their numbers; empty: not known, nor then the nodes
/// @param before         W before the tools touched, J; < 0: not known
double expectedError(const Model& model, std::span<const Material> materials, const AlignedVector<Double4>& u,
                     double strain_energy, std::span<const Press> presses = {}, std::span<const ToolPosture> tips = {},
                     double before = -1);

/// Those of the tools that press, by what they feel, and of the rigid bodies those that are round and no wider than
/// that nodes far apart would matter: what is flat or wide holds the body.
struct PressList {
  std::array<Press, max_pressers> press;
  std::size_t count = 0;

  PressList() = default;
  explicit PressList(const ToolLoads& loads);
  PressList(const Model& model, const ToolLoads& loads, const RigidLoads& rigid);
  operator std::span<const Press>() const { return {press.data(), count}; }

  /// Where a rigid body touches: the node that moves a vertex of the skin most.
  /// @param normal  out of the body there, in its own frame, of any length
  static void touch(const Model& model, int vertex, const Vec3& normal, Press& by);

  /// Where the rigid bodies touch, of a displacement u (m, node_count) at a time (s): where the skin is deepest in
  /// them. For batch.
  void findTouches(const Model& model, double time, const AlignedVector<Double4>& u);
};

}  // namespace palpate
