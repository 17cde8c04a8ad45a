#pragma once

#include <array>
#include <functional>
#include <vector>

#include "base/types.h"
#include "contact/skin.h"
#include "discretization/surface/surface_tree.h"

namespace palpate {

/// A rigid shell around the organ as the skin meets it, constant: how far each place is from it, on a regular grid near
/// it. The skin touches it at some of its vertices, about half the nodes' spacing apart: the displacement between them
/// is no finer.
struct Skull {
  std::vector<int> vertex;        // (point_count) skin vertices that may touch it, ascending
  std::vector<float> area;        // (point_count) m^2 of the skin that each stands for
  std::vector<float> correction;  // (point_count) m, added to the grid's gap: exact at rest where the organ made it
  Vec3 origin = Vec3::Zero();     // m, of the grid's first node
  double cell = 1;                // m
  std::array<int, 3> count{};     // nodes along x, y, z
  std::vector<float> gap;         // (node_count) m, to the shell, positive on the organ's side; `away` where it is open
  double stiffness = 0;           // Pa/m, of the layer on it

  static constexpr float away = 1e3F;           // m, further than any gap that matters
  static constexpr double farthest_out = 3e-3;  // m outside, from which on a point is left alone

  bool empty() const { return vertex.empty(); }
  int pointCount() const { return static_cast<int>(vertex.size()); }
  /// The gap at x between the grid's nodes, trilinear, m; beyond the grid and beside openings more than any that
  /// matters. @param normal  its gradient, not zero, of any length. Real-time.
  double at(const Vec3& x, Vec3& normal) const;
};

struct SkullOptions {
  double clearance = 0;                     // m, from the surface outwards to the shell
  double spacing = 0;                       // m, of the nodes
  double young_modulus = 0;                 // Pa, the softest tissue's
  bool of_organ = true;                     // the surface is the organ's own: at rest the gap is the clearance
  std::function<bool(const Vec3&)> open{};  // whether there is no shell at a place (m); none: it is closed
};

/// The shell `clearance` outside a closed surface.
Skull buildSkull(const SurfaceTree& surface, const SkinModel& skin, const SkullOptions& options);

/// What the skull remembers from step to step, and scratch.
struct SkullState {
  AlignedVector<Float4> force;  // (point_count) on the tissue, N
  struct Row {
    Eigen::Vector4f normal;     // unit, inwards
    Eigen::Vector4f predicted;  // increment of the point before contact, m
    float gap = 0;              // m, at the end of the step if there were no contact
    float highest = 0;          // m, gap that contact brings it to at most in this step
    float stiffness = 0;        // N/m
    float mobility = 0;         // m/N
    float force = 0;            // N
    int point = 0;
  };
  std::vector<Row> row;  // (point_count)
};
SkullState makeSkullState(const Skull& skull);

/// What the skull did in one step.
struct SkullContact {
  Vec3 force = Vec3::Zero();   // N, on the tissue
  double max_penetration = 0;  // m
  int count = 0;               // points that carry force
};

/// Keeps the predicted displacement inside the skull: frictionless unilateral contact, solved as solveContact solves
/// the tool's (contact_solver.h), with forces f_v >= 0 along the shell's inward normal n_v:
///   du_i += alpha / m_i sum_v N_i(X_v) f_v n_v,   f_v = K max(d_v, 0),   K = stiffness a_v
/// d is the penetration at the end of the step. A point that is deeper outside than the layer comes back by no more
/// than 0.02 mm a step, so that it is not shot in; one that is 3 mm outside is left alone: it went out by an opening.
///
/// @param alpha, inverse_mass, u, du, as solveContact's
/// Real-time: no allocation, no lock, no throw; serial, so that it is the same for any number of threads. Costs about
/// 60 four-lane FMAs a point, and per point in contact 60 (1 + sweeps).
/// Test: simulation/skull_test.cpp
SkullContact solveSkull(const Skull& skull, const SkinModel& skin, double alpha, const float* inverse_mass,
                        const Float4* u, Float4* du, SkullState& state);

}  // namespace palpate
