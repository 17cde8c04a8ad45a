#pragma once

#include "mechanics/materials/laws.h"

namespace palpate::test {

template <class Real, class... Laws>
PointStateOf<Real> lanesFirstPiola(LawList<Laws...>, const Material& m, const SimdTensor<Real>& H,
                                   SimdTensor<Real>& P) {
  PointStateOf<Real> state{};
  int place = 0;
  ((m.law == place++ ? void(state = typename Laws::template Lanes<Real>(m).firstPiola(H, P)) : void()), ...);
  return state;
}

/// The fast stress of the material's law, which the kernel takes.
template <class Real>
PointStateOf<Real> lanesFirstPiola(const Material& m, const SimdTensor<Real>& H, SimdTensor<Real>& P) {
  return lanesFirstPiola<Real>(RegisteredLaws{}, m, H, P);
}

/// The same of one F: the last lane's, and the energy where asked for.
template <class Real>
Mat3 lanesPiola(const Material& m, const Mat3& F, Real* energy = nullptr) {
  SimdTensor<Real> H, P;
  for (int k = 0; k < 9; ++k) H[k] = static_cast<Real>((F - Mat3::Identity())(k / 3, k % 3));
  const PointStateOf<Real> state = lanesFirstPiola(m, H, P);
  const auto last = [](const Simd<Real>& lanes) {
    alignas(64) Real a[Simd<Real>::width];
    lanes.store(a);
    return a[Simd<Real>::width - 1];
  };
  Mat3 r;
  for (int k = 0; k < 9; ++k) r(k / 3, k % 3) = static_cast<double>(last(P[k]));
  if (energy) *energy = last(state.energy);
  return r;
}

}  // namespace palpate::test
