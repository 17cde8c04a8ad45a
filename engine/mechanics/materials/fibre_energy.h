#pragma once

#include "mechanics/materials/material.h"

namespace palpate {

/// What fibres store, Pa, by the square of their stretch I4 = |F n|^2, n the unit direction at rest (Material::fibre).
/// Nothing where the law has no fibres, or they are not under tension.
/// Test: mechanics/materials/fibre_reinforced_test.cpp
double fibreEnergy(const Material& material, double I4);

}  // namespace palpate
