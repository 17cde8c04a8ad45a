#include "mechanics/materials/material.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "mechanics/materials/laws.h"
#include "mechanics/materials/material_law.h"

namespace palpate {
namespace {

[[noreturn]] void refuse(const MaterialLaw& law, std::string_view parameter, const char* problem) {
  std::string text = "material law ";
  throw std::invalid_argument(text.append(law.name).append(", ").append(parameter).append(": ").append(problem));
}

}  // namespace

const MaterialLaw& Material::lawDescription() const { return materialLaws()[static_cast<std::size_t>(law)]; }

Material Material::of(std::string_view law) {
  const auto laws = materialLaws();
  const auto found = std::find_if(laws.begin(), laws.end(), [&](const MaterialLaw& l) { return law == l.name; });
  if (found == laws.end()) throw std::invalid_argument(std::string("there is no material law ").append(law));
  Material material;
  material.law = static_cast<int>(found - laws.begin());
  forEachParameter(material, [](const Parameter& parameter, std::span<double> values) {
    if (!parameter.isRequired()) std::fill(values.begin(), values.end(), parameter.fallbackValue());
  });
  return material;
}

Material Material::neoHookean(double young, double poisson, double density) {
  return of(NeoHookean::name).set("young", young).set("poisson", poisson).set("density", density);
}

Material Material::ogden(const double* mu, const double* alpha, int term_count, double D1, double density) {
  if (term_count < 1 || term_count > max_terms) throw std::invalid_argument("Ogden material: 1 to 6 terms");
  const auto terms = static_cast<std::size_t>(term_count);
  return of(Ogden::name).set("mu", {mu, terms}).set("alpha", {alpha, terms}).set("D1", D1).set("density", density);
}

Material& Material::set(std::string_view parameter, std::span<const double> values) {
  bool known = false;
  forEachParameter(*this, [&](const Parameter& p, std::span<double> present) {
    if (parameter != p.name) return;
    known = true;
    const bool is_list = p.type == Parameter::Type::Numbers, is_pairs = p.type == Parameter::Type::Pairs,
               is_vector = p.type == Parameter::Type::Vector;
    const auto room = static_cast<std::size_t>(is_pairs ? 2 * max_relaxation_terms : roomOf(p));
    if (values.empty() || values.size() > room || (is_pairs && values.size() % 2 == 1) ||
        (is_vector && values.size() < room))
      refuse(lawDescription(), parameter,
             is_list     ? "1 to 6 numbers"
             : is_pairs  ? "1 to 3 pairs"
             : is_vector ? "three numbers"
                         : "one number");
    if (is_list) term_count = static_cast<int>(values.size());
    if (is_pairs) relaxation_count = static_cast<int>(values.size()) / 2;
    std::copy(values.begin(), values.end(), present.data());  // a list has room for them
  });
  if (!known) refuse(lawDescription(), parameter, "it has no such parameter");
  updateModuli();
  return *this;
}

std::span<const double> Material::get(std::string_view parameter) const {
  std::span<const double> found;
  forEachParameter(*this, [&](const Parameter& p, std::span<const double> values) {
    if (parameter == p.name) found = values;
  });
  if (found.data() == nullptr) refuse(lawDescription(), parameter, "it has no such parameter");
  return found;
}

void Material::updateModuli() {
  const RestModuli moduli = lawDescription().restModuli(*this);
  shear_modulus = moduli.shear;
  bulk_modulus = moduli.bulk;
  fibre_modulus = moduli.fibre;
  std::copy_n(moduli.direction.data(), 3, fibre);
}

double Material::longTermShare() const {
  double share = 1;
  for (int i = 0; i < relaxation_count; ++i) share -= relaxation[2 * i];
  return share;
}

double Material::barrierPressure(double J) const {
  if (barrier_strength == 0 || J >= barrier_J0) return 0;
  const double Jc = std::max(J, min_isochoric_J);
  return bulk_modulus * barrier_strength * (std::log(Jc / barrier_J0) + (J - Jc) / Jc);
}

double Material::energy(const Mat3& F) const {
  const double J = F.determinant();
  double W = 0.5 * bulk_modulus * (J - 1) * (J - 1);
  if (barrier_strength > 0 && J < barrier_J0) {
    const double Jc = std::max(J, min_isochoric_J), d = J - Jc;
    W += bulk_modulus * barrier_strength *
         (Jc * std::log(Jc / barrier_J0) - Jc + barrier_J0 + d * std::log(Jc / barrier_J0) + d * d / (2 * Jc));
  }
  return W + lawDescription().shapeEnergy(*this, F);
}

Mat3 Material::firstPiola(const Mat3& F) const { return firstPiola(F, bulk_modulus * (F.determinant() - 1)); }

Mat3 Material::firstPiola(const Mat3& F, double pressure) const {
  return lawDescription().firstPiola(*this, F, pressure + barrierPressure(F.determinant()));
}

Material stiffened(Material material, double factor) {
  forEachParameter(material, [factor](const Parameter& parameter, std::span<double> values) {
    const std::string_view unit = parameter.unit;
    for (double& value : values) {
      if (unit == "Pa") value *= factor;
      if (unit == "1/Pa") value /= factor;
    }
  });
  material.updateModuli();
  return material;
}

double vonMises(const Mat3& P, const Mat3& F) {
  const Mat3 cauchy = P * F.transpose() / F.determinant();
  const Mat3 deviator = cauchy - cauchy.trace() / 3 * Mat3::Identity();
  return std::sqrt(1.5) * deviator.norm();
}

}  // namespace palpate
