#include "mechanics/materials/material_law.h"

#include <array>

#include "base/key.h"
#include "mechanics/materials/fibre_energy.h"
#include "mechanics/materials/laws.h"

namespace palpate {
namespace {

template <class Law>
constexpr int valueCount() {
  int count = 0;
  for (const Parameter& p : Law::parameters) count += roomOf(p);
  return count;
}

template <class Law>
constexpr bool onlyNumbersHaveDefaults() {
  for (const Parameter& p : Law::parameters)
    if (p.type != Parameter::Type::Number && !p.isRequired()) return false;
  return true;
}

template <class Law>
constexpr MaterialLaw describe() {
  static_assert(valueCount<Law>() <= Material::max_values, "raise Material::max_values");
  static_assert(onlyNumbersHaveDefaults<Law>(), "a list or vector of a law has no default");
  return {Law::name,       Law::title, Law::reference,   Law::parameters,
          Law::restModuli, Law::check, Law::shapeEnergy, Law::firstPiola};
}

template <class... Laws>
constexpr std::array<MaterialLaw, sizeof...(Laws)> describeAll(LawList<Laws...>) {
  return {describe<Laws>()...};
}

constexpr auto law_table = describeAll(RegisteredLaws{});

using FibreFunction = double (*)(const Material&, double I4);

/// Of laws that have a `Fibre`.
template <class Law>
constexpr FibreFunction fibreOf() {
  if constexpr (requires { typename Law::Fibre; })
    return [](const Material& m, double I4) { return typename Law::Fibre(m, I4).energy; };
  else
    return nullptr;
}

template <class... Laws>
constexpr std::array<FibreFunction, sizeof...(Laws)> fibresOfAll(LawList<Laws...>) {
  return {fibreOf<Laws>()...};
}

constexpr auto fibre_table = fibresOfAll(RegisteredLaws{});

using T = Parameter::Type;
constexpr CommonMaterialParameter common_parameters[] = {
    {{"barrier_strength", "", T::Number, "", "0", between(0, 10),
      "Barrier b against collapse: adds K b ln(J / J0) to the pressure where J < J0, which the paper's energy "
      "lacks. 0: none."},
     &Material::barrier_strength,
     false},
    {{"barrier_J0", "", T::Number, "", "0.5", between(0.05, 0.95), "Where the barrier begins."},
     &Material::barrier_J0,
     false},
    {{"density", "Density", T::Number, "kg/m^3", "1000", between(1, 30000), "Mass density."}, &Material::density},
};

// Up to 100 s: in 1e5 steps and more the loop's float32 loses the last percents of what relaxes.
constexpr double max_relaxation_time = 100;

constexpr Parameter relaxation = {
    "relaxation",
    "Relaxation",
    T::Pairs,
    "",
    "",
    anyNumber(),
    "Viscoelasticity: 1 to 3 pairs `[g, tau]`, like `[[0.3, 0.1], [0.2, 2.0]]`. The share g of the isochoric stress "
    "(their sum below 1) relaxes with the time tau (up to 100 s): G(t) = G0 (1 - sum g (1 - exp(-t/tau))). The law's "
    "moduli are those at once, G0. The loop and transient solutions keep the history; a static one is the equilibrium "
    "after a long time. Without it the tissue is elastic."};

}  // namespace

const Parameter& relaxationParameter() { return relaxation; }

std::optional<ParameterProblem> relaxationProblem(const Material& material) {
  const char* pairs = "give pairs [g, tau], like [[0.3, 0.1], [0.2, 2.0]]: g of the stress relaxes with tau, s";
  for (int i = 0; i < material.relaxation_count; ++i) {
    const double g = material.relaxation[2 * i], tau = material.relaxation[2 * i + 1];
    if (!(g > 0 && g < 1)) return {{relaxation.name, "a share g of \"relaxation\" is not above 0 and below 1", pairs}};
    if (!(tau > 0 && tau <= max_relaxation_time))
      return {{relaxation.name, "a time tau of \"relaxation\" is not above 0 and up to 100 s", pairs}};
  }
  if (material.longTermShare() > 0) return {};
  return {{relaxation.name, "the shares g of \"relaxation\" add up to 1 or more",
           "leave some of the stress: 1 minus their sum is what stays after a long time"}};
}

std::span<const MaterialLaw> materialLaws() { return law_table; }

double fibreEnergy(const Material& material, double I4) {
  const FibreFunction fibre = fibre_table[static_cast<std::size_t>(material.law)];
  return fibre != nullptr && I4 > 1 ? fibre(material, I4) : 0;
}

std::span<const CommonMaterialParameter> commonMaterialParameters() { return common_parameters; }

void add(ByteKey& key, const Material& material) {
  key.add(fnv1a(material.lawDescription().name), material.shear_modulus, material.bulk_modulus);
  forEachParameter(material, [&](const Parameter& parameter, std::span<const double> values) {
    if (parameter.type == Parameter::Type::Pairs && values.empty()) return;  // keys of elastic materials stay
    key.add(values.size());
    for (const double value : values) key.add(value);
  });
}

}  // namespace palpate
