#pragma once

#include <Eigen/Core>

#include "base/float4.h"
#include "contact/skin.h"

namespace palpate {

/// A force on the skin's vertex v changes the increments of the nodes that carry it: du_i += alpha / m_i N_i(X_v) f.
/// @param f      N, the fourth component 0
/// @param alpha  s^2, of the time step
inline void applyForce(const SkinModel& skin, int v, const Eigen::Vector4f& f, float alpha, const float* inverse_mass,
                       Float4* du) {
  const Group scaled = alpha * loadGroup(f.data());
  for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e) {
    Float4& increment = du[skin.node[e]];
    store(increment, load(increment) + (skin.N[e] * inverse_mass[skin.node[e]]) * scaled);
  }
}

/// The vertex's response to a force on itself, per alpha: sum_i N_i^2 / m_i, 1/kg.
inline float compliance(const SkinModel& skin, int v, const float* inverse_mass) {
  float sum = 0;
  for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e) sum += skin.N[e] * skin.N[e] * inverse_mass[skin.node[e]];
  return sum;
}

}  // namespace palpate
