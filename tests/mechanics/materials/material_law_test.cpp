#include "mechanics/materials/material_law.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "base/key.h"
#include "support/law_values.h"

using namespace palpate;
using namespace palpate::test;

// What follows from the parameter lists, for every registered law.

namespace {

std::string keyOf(const Material& m) {
  ByteKey key;
  add(key, m);
  return key.bytes();
}

}  // namespace

TEST_CASE("A material's key changes with its law and with every value", "[material][law]") {
  std::set<std::string> seen;
  std::size_t count = 0;
  for (const MaterialLaw& law : materialLaws()) {
    const Material m = sampleMaterial(law);
    seen.insert(keyOf(m));
    ++count;
    forEachParameter(m, [&](const Parameter& p, std::span<const double> values) {
      for (std::size_t k = 0; k < values.size(); ++k) {
        std::vector<double> changed(values.begin(), values.end());
        changed[k] *= 1 + 1e-15;
        REQUIRE(changed[k] != values[k]);
        seen.insert(keyOf(Material(m).set(p.name, changed)));
        ++count;
      }
    });
  }
  CHECK(seen.size() == count);
}

TEST_CASE("A law's values are read as they were set, others refused", "[material][law]") {
  for (const MaterialLaw& law : materialLaws()) {
    INFO(law.name);
    Material m = sampleMaterial(law);
    forEachParameter(m, [&](const Parameter& p, std::span<double> values) {
      INFO(p.name);
      const auto read = m.get(p.name);
      CHECK(std::vector<double>(read.begin(), read.end()) == std::vector<double>(values.begin(), values.end()));
      for (const double value : values) CHECK(p.range.contains(value));
      const std::vector<double> seven(7, 1.0);
      CHECK_THROWS_AS(Material(m).set(p.name, seven), std::invalid_argument);
      CHECK_THROWS_AS(Material(m).set(p.name, std::span<const double>()), std::invalid_argument);
    });
    CHECK_THROWS_AS(m.set("jelly", 1), std::invalid_argument);
    CHECK_THROWS_AS(m.get("jelly"), std::invalid_argument);
  }
  CHECK_THROWS_AS(Material::of("jelly"), std::invalid_argument);
}

TEST_CASE("Laws that share a scene key agree on what it may be", "[material][law]") {
  for (const MaterialLaw& a : materialLaws())
    for (const MaterialLaw& b : materialLaws())
      for (const Parameter& p : a.parameters)
        for (const Parameter& q : b.parameters)
          if (std::string(p.name) == q.name) {
            INFO(a.name << " and " << b.name << ": " << p.name);
            CHECK(p.type == q.type);
            CHECK(std::string(p.unit) == q.unit);
            CHECK(p.range == q.range);
          }
}

TEST_CASE("A material 2.5 times as stiff has 2.5 times the stress, energy and moduli, whatever its law",
          "[material][law]") {
  Mat3 F;
  F << 1.1, 0.2, -0.1, 0.05, 0.6, 0.3, -0.2, 0.1, 0.7;
  for (const MaterialLaw& law : materialLaws()) {
    INFO(law.name);
    const Material m = sampleMaterial(law), stiff = stiffened(m, 2.5);
    CHECK((stiff.firstPiola(F) - 2.5 * m.firstPiola(F)).norm() < 1e-12 * m.firstPiola(F).norm());
    CHECK(stiff.energy(F) == Approx(2.5 * m.energy(F)).epsilon(1e-12));
    CHECK(stiff.waveModulus() == Approx(2.5 * m.waveModulus()).epsilon(1e-12));
    CHECK(stiff.density == m.density);
    CHECK(stiffened(m, 1) == m);
  }
}
