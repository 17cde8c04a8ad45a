#pragma once

// The register of material laws. A law is one file here, with its parameters, energy, stress and a bound of
// its tangent; in the register it is
// its file and its name.
#include "mechanics/materials/fibre_reinforced.h"
#include "mechanics/materials/mooney_rivlin.h"
#include "mechanics/materials/neo_hookean.h"
#include "mechanics/materials/ogden.h"

namespace palpate {
inline namespace PALPATE_KERNEL {

template <class... Laws>
struct LawList {};

/// In the order of the scene reference.
using RegisteredLaws = LawList<NeoHookean, MooneyRivlin, Ogden, FibreReinforced>;

template <class Law, class... Laws>
consteval int placeOf(LawList<Laws...>) {
  int place = -1, here = 0;
  ((std::is_same_v<Law, Laws> ? void(place = here++) : void(here++)), ...);
  return place;
}

/// A law's place in the register: Material::law.
template <class Law>
consteval int lawNumber() {
  static_assert(placeOf<Law>(RegisteredLaws{}) >= 0, "the law is not registered");
  return placeOf<Law>(RegisteredLaws{});
}

}  // namespace PALPATE_KERNEL
}  // namespace palpate
