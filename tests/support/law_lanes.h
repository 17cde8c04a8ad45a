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

}  // namespace palpate::test
