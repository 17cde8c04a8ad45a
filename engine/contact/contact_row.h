#pragma once

#include <algorithm>
#include <limits>

#include "base/types.h"
#include "contact/coulomb_friction.h"
#include "contact/skin.h"

namespace palpate {

/// m, within which a point has a row though it does not touch: forces on its neighbours may push it there within the
/// step. If missed, the next step has it.
constexpr float near_gap = 1e-4F;

/// m a step, by which what is too deep in a rigid body or other skin comes back at most.
constexpr float fastest_return = 2e-5F;

/// As the rows compute: the fourth component is 0.
inline Eigen::Vector4f lanesOf(const Float4& a) { return {a.x, a.y, a.z, 0}; }
inline Eigen::Vector4f lanesOf(const Vec3& a) { return lanesOf(toFloat4(a)); }

/// A row of the contact solver: a point of the skin before what it may touch, a tool, a rigid body or a face of the
/// skin. What touches is an elastic layer with Coulomb friction:
///   f_n = K max(d, 0),   |f_t| <= friction f_n, else none of the tangential way                 (frictionForce)
/// with the penetration d = -(gap + n . (du - predicted)) at the end of the step.
struct ContactRow {
  Eigen::Vector4f normal = Eigen::Vector4f::Zero();     // unit, out of what is touched, where the point was
  Eigen::Vector4f predicted = Eigen::Vector4f::Zero();  // m, increment of the point without this step's contact; of a
                                                        // pair the face's taken off
  Eigen::Vector4f surface = Eigen::Vector4f::Zero();    // m, likewise of what is touched; pairs have it in `predicted`
  Eigen::Vector4f stick = Eigen::Vector4f::Zero();      // N, tangential force carried over from the last step
  Eigen::Vector4f force = Eigen::Vector4f::Zero();      // N, on the point
  Eigen::Vector4f change = Eigen::Vector4f::Zero();     // N, of it in the last sweep
  Eigen::Vector4f course = Eigen::Vector4f::Zero();     // N, that it took until then (Sweeps)
  float gap = 0;                                        // m, at the end of the step if there were no contact
  float highest = 1e3F;                                 // m, gap that contact brings it to at most in this step
  float largest = std::numeric_limits<float>::max();    // N, that presses at most
  float stiffness = 0;                                  // N/m, K
  float mobility = 0;                                   // m/N, response of the point to a force on it
  float friction = 0;                                   // Coulomb coefficient
  float penetration = 0;                                // m, d when it was last solved
  int slot = 0;                                         // where its group remembers it
};

/// Solves one row's law with all other forces held; returns the change of its force.
/// @param increment  of the point, m
inline Eigen::Vector4f updateForce(ContactRow& row, const Eigen::Vector4f& increment) {
  const float K = row.stiffness, A = row.mobility;
  const float old = row.normal.dot(row.force);
  const float gap = row.gap + row.normal.dot(increment - row.predicted);
  const float free = gap - A * old;  // without this force
  const float law = -K / (1 + K * A) * free, most = std::min(row.largest, (row.highest - free) / A);
  const float pressed = std::max(0.0F, std::min(law, most));
  Eigen::Vector4f force = pressed * row.normal;
  if (row.friction > 0 && pressed > 0) {
    Eigen::Vector4f slip = increment - row.surface;
    slip -= row.normal.dot(slip) * row.normal;
    force += frictionForce(row.stick, slip, row.force - old * row.normal, K, A, row.friction * pressed);
  }
  row.penetration = -(gap + A * (pressed - old));
  const Eigen::Vector4f change = force - row.force;
  row.force = force;
  return change;
}

/// A sweep that changes forces by less than this part of their size (2-norms over rows) settles them; in batch, where
/// what is left would keep a relaxation from coming to rest (a kidney's force within 1e-5 for ever).
constexpr float settled_change = 1e-4F, settled_in_batch = 1e-6F;

/// The sweeps of a group's rows in one step. Alone they take hundreds where many points hold each other by friction: so
/// each starts further on the course of those before, by nonlinear conjugate gradients whose gradient is what a sweep
/// changes (Silcowitz-Hansen, Niebe and Erleben 2010, A nonsmooth nonlinear conjugate gradient method for interactive
/// contact force problems):
///   beta_k = |r_k|^2 / |r_k-1|^2,   f_k+1 = sweep(f_k + beta_k p_k-1),   p_k = r_k + beta_k p_k-1
/// with r_k what the k-th sweep changed, and from anew (beta = 0) where it changed more than the one before. What is
/// beyond a row's law by that, the next sweep takes back.
class Sweeps {
 public:
  /// Once before each sweep, with what sweepRows goes over. Until the third, rows may have another step's course, which
  /// may not be finite.
  template <class RowAt, class Push>
  void goOn(std::size_t count, RowAt rowAt, Push push) const {
    for (std::size_t k = 0; k < count; ++k) {
      auto& row = rowAt(k);
      const Eigen::Vector4f further = share_ > 0 ? Eigen::Vector4f(share_ * row.course) : Eigen::Vector4f::Zero();
      row.course = further + row.change;
      if (further.isZero(0)) continue;
      row.force += further;
      push(row, further);
    }
  }

  /// Goes once over `count` rows.
  /// @param rowAt(k), incrementOf(row), push(row, force)  the k-th; of its point, m; adds what a force does to du
  template <class RowAt, class IncrementOf, class Push>
  void sweepRows(std::size_t count, bool forwards, RowAt rowAt, IncrementOf incrementOf, Push push) {
    for (std::size_t k = 0; k < count; ++k) {
      auto& row = rowAt(forwards ? k : count - 1 - k);
      row.change = updateForce(row, incrementOf(row));
      size_ += row.force.squaredNorm();
      if (row.change.isZero(0)) continue;
      changed_ += row.change.squaredNorm();
      push(row, row.change);
    }
  }

  /// Once after each. @return whether it changed less than this part of the forces
  bool end(float tolerance) {
    const bool settled = changed_ <= tolerance * tolerance * size_;
    share_ = changed_ <= last_ && last_ > 0 ? changed_ / last_ : 0;
    last_ = changed_;
    changed_ = size_ = 0;
    return settled;
  }

  /// What comes is not on that course.
  void startAnew() { share_ = last_ = 0; }

 private:
  float changed_ = 0, size_ = 0;  // N^2, sums over the rows
  float last_ = 0, share_ = 0;    // what the sweep before changed, N^2; beta
};

/// What a step's contact reads and corrects.
struct ContactStep {
  const SkinModel& skin;
  float alpha;                // s^2, mobility factor of paper eq. 12
  const float* inverse_mass;  // (node_count) 1/kg
  const Float4* u;            // (node_count) m, displacement at the step's start
  Float4* du;                 // (node_count) m, predicted increment; corrected
  float settled = settled_change;
  float stiffer = 1;  // than it was loaded the tissue is: so is the layer
};

/// N/m, of the contact layer on `area` (m^2) at a vertex.
inline float layerStiffness(const ContactStep& step, int vertex, double area) {
  return step.stiffer * step.skin.layer[vertex] * static_cast<float>(area);
}

/// Rows of one kind, whose last step's forces act on du from the start: gaps and normals are then those of where the
/// skin goes. Real-time: no allocation, no lock, no throw.
class ContactGroup {
 public:
  virtual ~ContactGroup() = default;

  /// Those that touch, or nearly. @return how many
  virtual std::size_t makeRows() = 0;
  /// Goes once over them. @return whether little has changed
  virtual bool sweep(bool forwards) = 0;
};

}  // namespace palpate
