#pragma once

#include <optional>
#include <span>

#include "base/parameter.h"
#include "mechanics/materials/material.h"

namespace palpate {

class ByteKey;

/// Moduli at rest, Pa.
struct RestModuli {
  double shear, bulk;
  double fibre = 0;  // added along `direction`, under tension
  Vec3 direction = Vec3::Zero();
};

/// What is wrong with the values of a law's parameters together.
struct ParameterProblem {
  const char* parameter;  // the one to look at
  const char* problem;
  const char* advice;
};

/// What the program knows of a law of laws.h, whose file has the formulas.
struct MaterialLaw {
  const char* name;       // the scene's `model`: "neo-hookean"
  const char* title;      // "neo-Hookean"
  const char* reference;  // where the formula stands: "paper eq. 32"; "" where everyone knows it
  std::span<const Parameter> parameters;
  RestModuli (*restModuli)(const Material&);
  std::optional<ParameterProblem> (*check)(const Material&);
  double (*shapeEnergy)(const Material&, const Mat3& F);                // J/m^3, all but the volume's
  Mat3 (*firstPiola)(const Material&, const Mat3& F, double pressure);  // Pa
};

/// All laws, in the order of the scene reference.
std::span<const MaterialLaw> materialLaws();

/// A parameter that every law has, with its place in Material.
struct CommonMaterialParameter {
  Parameter parameter;
  double Material::*member;
  bool is_key = true;  // of scenes; else it follows from their scheme
};

/// In the order of the scene reference.
std::span<const CommonMaterialParameter> commonMaterialParameters();

/// Numbers that a law's parameter takes in Material::value.
constexpr int roomOf(const Parameter& p) {
  return p.type == Parameter::Type::Numbers ? Material::max_terms : p.type == Parameter::Type::Vector ? 3 : 1;
}

/// "relaxation", which every law has: 1 to 3 pairs [g, tau], or none.
const Parameter& relaxationParameter();

/// What is wrong with a material's relaxation, if anything.
std::optional<ParameterProblem> relaxationProblem(const Material& material);

/// Calls `call(parameter, values)` for each parameter of the material's law and then for those that all laws have;
/// `values` is a span of one number, of three for a vector, or of term_count for a list; at last for the relaxation,
/// with pairs or nothing.
template <class SomeMaterial, class Call>
void forEachParameter(SomeMaterial&& material, Call call) {
  auto* value = material.value;
  for (const Parameter& p : materialLaws()[static_cast<std::size_t>(material.law)].parameters) {
    const bool is_list = p.type == Parameter::Type::Numbers;
    call(p, std::span(value, static_cast<std::size_t>(is_list ? material.term_count : roomOf(p))));
    value += roomOf(p);
  }
  for (const CommonMaterialParameter& c : commonMaterialParameters())
    call(c.parameter, std::span(&(material.*c.member), 1));
  call(relaxationParameter(),
       std::span(&material.relaxation[0], 2 * static_cast<std::size_t>(material.relaxation_count)));
}

/// Whether it has the shear modulus of some matter: from softer than any gel to stiffer than diamond.
inline bool isOfMatter(const Material& material) {
  constexpr double least_Pa = 0.1, most_Pa = 1e13;
  return material.shear_modulus >= least_Pa && material.shear_modulus <= most_Pa;
}

/// Adds the law, all its values and the moduli at rest.
void add(ByteKey& key, const Material& material);

}  // namespace palpate
