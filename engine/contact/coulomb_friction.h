#pragma once

#include <Eigen/Core>

namespace palpate {

/// Coulomb's friction of a point on an elastic layer, in place of which a rigid body or tool can't be scratched:
///   f_t = stick - K slip,  |f_t| <= limit      stick, else slip
/// solved with the point's own response A, all other forces held. `stick` is the force carried over from the last step,
/// so that static friction does not creep.
/// @param slip        of the point over the body in the step with `tangential`, m
/// @param tangential  the force that is in force, N
/// @param K, A        of the layer, N/m; of the point, m/N
/// Real-time.
inline Eigen::Vector4f frictionForce(const Eigen::Vector4f& stick, const Eigen::Vector4f& slip,
                                     const Eigen::Vector4f& tangential, float K, float A, float limit) {
  Eigen::Vector4f force = (stick - K * (slip - A * tangential)) / (1.0F + K * A);
  const float size = force.norm();
  if (size > limit) force *= limit / size;
  return force;
}

}  // namespace palpate
