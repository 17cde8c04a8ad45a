#pragma once

#include "contact/rigid_bodies.h"

namespace palpate {

/// The rows of rigid bodies, all points of all of them, with the layer's stiffness K = bodies.stiffness a_v. A point
/// that is deeper in a body than the layer comes back by no more than 0.02 mm a step, so that it is not shot out; one
/// that is 3 mm beyond a surface is left alone: it went out by an opening.
///
/// Costs 2 four-lane operations a node and about 60 four-lane FMAs a point near a body, beside what rows cost.
/// Test: simulation/rigid_bodies_test.cpp, simulation/rigid_shell_test.cpp
class RigidRows final : public ContactGroup {
 public:
  /// @param bodies, state  null: none
  /// @param begin, end     s, of the step: the bodies go from where they are at one to where they are at the other
  RigidRows(const ContactStep& step, const RigidBodies* bodies, double begin, double end, RigidState* state);

  std::size_t makeRows() override;
  bool sweep(bool forwards) override;
  /// Keeps the forces for the next step.
  RigidLoads finish();

 private:
  /// Where a body is at a time.
  struct Place;

  int vertexOf(int point) const { return bodies_->vertex[static_cast<std::size_t>(point)]; }
  void push(int point, const Eigen::Vector4f& f) const;
  double farthestWay() const;
  void findNear(double reach);
  void listNear();
  bool makeRow(const RigidBody& body, const Place& from, const Place& to, int point, RigidRow& row);
  void carryOver(const RigidBody& body, const Place& from, const Place& to, RigidRow& row);
  void letGo(int point);

  const ContactStep& step_;
  const RigidBodies* bodies_;
  double begin_, end_;
  RigidState* state_;
  std::size_t count_ = 0;  // of rows
  Sweeps sweeps_;
};

}  // namespace palpate
