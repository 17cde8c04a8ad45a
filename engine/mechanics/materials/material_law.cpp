#include "mechanics/materials/material_law.h"

#include <array>

#include "base/key.h"
#include "mechanics/materials/laws.h"

namespace palpate {
namespace {

template <class Law>
constexpr int valueCount() {
  int count = 0;
  for (const Parameter& p : Law::parameters) count += p.type == Parameter::Type::Numbers ? Material::max_terms : 1;
  return count;
}

template <class Law>
constexpr MaterialLaw describe() {
  static_assert(valueCount<Law>() <= Material::max_values, "raise Material::max_values");
  return {Law::name,       Law::title, Law::reference,       Law::parameters,
          Law::restModuli, Law::check, Law::isochoricEnergy, Law::firstPiola};
}

template <class... Laws>
constexpr std::array<MaterialLaw, sizeof...(Laws)> describeAll(LawList<Laws...>) {
  return {describe<Laws>()...};
}

constexpr auto law_table = describeAll(RegisteredLaws{});

using T = Parameter::Type;
constexpr CommonMaterialParameter common_parameters[] = {
    {{"barrier_strength", "", T::Number, "", "0", between(0, 10),
      "Barrier b against collapse: adds K b ln(J / J0) to the pressure where J < J0, which the paper's energy "
      "lacks. 0: none. 1 .. 3 where indentation goes beyond half the height."},
     &Material::barrier_strength},
    {{"barrier_J0", "", T::Number, "", "0.5", between(0.05, 0.95), "Where the barrier begins."}, &Material::barrier_J0},
    {{"density", "Density", T::Number, "kg/m^3", "1000", between(1, 30000), "Mass density."}, &Material::density},
};

}  // namespace

std::span<const MaterialLaw> materialLaws() { return law_table; }

std::span<const CommonMaterialParameter> commonMaterialParameters() { return common_parameters; }

void add(ByteKey& key, const Material& material) {
  key.add(fnv1a(material.lawDescription().name), material.shear_modulus, material.bulk_modulus);
  forEachParameter(material, [&](const Parameter&, std::span<const double> values) {
    key.add(values.size());
    for (const double value : values) key.add(value);
  });
}

}  // namespace palpate
