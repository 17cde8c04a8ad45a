#pragma once

#include "contact/rigid_bodies.h"

namespace palpate {

/// Rigid bodies as a static solution meets them: elastic forces without friction, which dynamic relaxation settles.
/// Each point of the skin has a plane, the body's tangent where the point last was when follow() was called, which goes
/// with the body, and in front of it a spring with a preload p,
///   f = max(0, p - K gap) n,   gap = n . (x - x_plane)
/// update() takes the force as the new preload (augmented Lagrangian: Alart and Curnier 1991), which takes the
/// penetration away without a stiff spring. K is a share of the tissue's own stiffness there.
///
/// A point that has no shell over it at rest is left alone by what encloses the organ; one that slides to an opening
/// keeps its plane.
/// Test: simulation/rigid_shell_test.cpp, simulation/rigid_bodies_test.cpp
class RigidLayer {
 public:
  /// @param mass  fictitious masses that are the rows of the tissue's stiffness, N/m (node_count); the springs' are
  ///              added
  RigidLayer(const RigidBodies& bodies, const SkinModel& skin, std::vector<double>& mass);

  /// The bodies, and the planes on them, are where they are at `time` (s).
  void moveTo(double time);

  /// Adds the forces at a displacement (node_count); they are kept for loads().
  void addForces(const AlignedVector<Double4>& u, AlignedVector<Double4>& force);

  /// New planes, where the points are now.
  void follow(const AlignedVector<Double4>& u);
  /// New planes and preloads. @return  m, how far the planes just taken are from their complementarity
  /// min(gap, f / K) = 0 at most: penetration, or force across a gap
  double update(const AlignedVector<Double4>& u);
  /// New planes, no preloads: for a body put anywhere.
  void restart(const AlignedVector<Double4>& u);

  /// What the springs add to the highest eigenvalue of stiffness over mass at most, 1/s^2.
  double highest() const { return highest_; }

  bool empty() const { return point_.empty(); }
  /// Of the last forces. The penetration is that into the planes.
  const RigidLoads& loads() const { return loads_; }

 private:
  struct Point {
    double stiffness = 0;        // N/m
    double preload = 0;          // N
    Vec3 normal = Vec3::Zero();  // out of the body, in its frame; zero: it is not near
    double offset = 0;           // m: gap = normal . X + offset
  };
  Vec3 positionOf(std::size_t p, std::size_t body, const AlignedVector<Double4>& u) const;
  void takePlane(std::size_t p, const RigidBody& body, const Vec3& X);
  template <class Call>
  void forEachPoint(Call call);

  const RigidBodies& bodies_;
  const SkinModel& skin_;
  std::vector<Pose> place_;  // (body_count)
  std::vector<Point> point_;
  double highest_ = 0;
  RigidLoads loads_;
};

}  // namespace palpate
