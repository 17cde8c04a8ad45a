#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "mechanics/materials/material_law.h"

namespace palpate::test {

/// A material of the law with each parameter, also those of all laws, at some allowed value unlike the others' and its
/// default; lists have two entries.
inline Material sampleMaterial(const MaterialLaw& law) {
  Material m = Material::of(law.name);
  double number = 1;
  forEachParameter(std::as_const(m), [&](const Parameter& p, auto) {
    const bool below = std::isfinite(p.range.low), above = std::isfinite(p.range.high);
    std::vector<double> values(p.type == Parameter::Type::Numbers ? 2 : p.type == Parameter::Type::Vector ? 3 : 1);
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

/// Materials of the law as soft tissue might have them, 2 kPa to 2 MPa of bulk modulus and exponents up to 6, drawn
/// from a fixed seed; some have a barrier.
inline std::vector<Material> plausibleMaterials(const MaterialLaw& law, int count = 6) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Material> all;
  while (static_cast<int>(all.size()) < count) {
    Material m = Material::of(law.name);
    for (const Parameter& p : law.parameters) {
      std::vector<double> values(p.type == Parameter::Type::Numbers ? 2 : p.type == Parameter::Type::Vector ? 3 : 1);
      for (double& value : values) {
        const double x = unit(random);
        if (std::string_view(p.unit) == "Pa")
          value = 2000 * x;
        else if (std::string_view(p.unit) == "1/Pa")
          value = std::pow(10, -6 + 3 * x);
        else
          value = std::max(p.range.low, -6.0) + x * (std::min(p.range.high, 6.0) - std::max(p.range.low, -6.0));
      }
      m.set(p.name, values);
    }
    if (all.size() % 3 == 2) m.set("barrier_strength", 1.5);
    if (!law.check(m)) all.push_back(m);
  }
  return all;
}

/// An irregular F of a given determinant.
inline Mat3 withJ(double J) {
  Mat3 F;
  F << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, -0.2, 0.1, 1.0;
  F.col(2) *= J / F.determinant();
  return F;
}

/// Deformation gradients: rest, repeated and nearly repeated stretches, irregular ones, some of them nearly collapsed
/// and inverted; and fifteen of them turned by 90 degrees.
inline std::vector<Mat3> irregularStates() {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-0.35, 0.35);
  std::vector<Mat3> all{Mat3::Identity(), 1.1 * Mat3::Identity(), Vec3(2, 2, 0.25).asDiagonal(),
                        Vec3(1.9, 2.05, 0.25).asDiagonal(), Vec3(0.9, 1.0, -0.2).asDiagonal()};
  for (int k = 0; k < 40; ++k) {
    Mat3 F = Mat3::Identity();
    for (int c = 0; c < 9; ++c) F(c / 3, c % 3) += unit(random);
    all.push_back(F);
  }
  for (const double J : {0.6, 0.3, 0.1, 0.01, -0.1, -0.5}) all.push_back(withJ(J));
  const Mat3 turn = Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()).toRotationMatrix();
  for (std::size_t k = 0; k < 15; ++k) all.emplace_back(turn * all[k]);
  return all;
}

/// The stress by central differences of the energy, `e` to both sides.
inline Mat3 energyDifferences(const Material& m, const Mat3& F, double e) {
  Mat3 P;
  for (int k = 0; k < 9; ++k) {
    Mat3 ahead = F, behind = F;
    ahead(k / 3, k % 3) += e;
    behind(k / 3, k % 3) -= e;
    P(k / 3, k % 3) = (m.energy(ahead) - m.energy(behind)) / (2 * e);
  }
  return P;
}

}  // namespace palpate::test
