#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "mechanics/materials/material_law.h"

namespace palpate::test {

/// A material of the law with each parameter, also those of all laws, at some allowed value unlike the others' and its
/// default; lists have two entries.
inline Material sampleMaterial(const MaterialLaw& law) {
  Material m = Material::of(law.name);
  double number = 1;
  forEachParameter(std::as_const(m), [&](const Parameter& p, auto) {
    const bool below = std::isfinite(p.range.low), above = std::isfinite(p.range.high);
    std::vector<double> values(p.type == Parameter::Type::Numbers ? 2 : 1);
    for (double& value : values) {
      number += 1;
      value = below && above ? p.range.low + (p.range.high - p.range.low) * number / 32
              : above        ? p.range.high - number
                             : (below ? p.range.low : 0) + number;
    }
    if (p.type == Parameter::Type::Pairs) values = {0.25, number + 1, 0.125, number + 2};
    m.set(p.name, values);
  });
  return m;
}

}  // namespace palpate::test
