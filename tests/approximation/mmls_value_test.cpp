#include "approximation/mmls_value.h"

#include <catch2/catch.hpp>
#include <random>

using namespace palpate;

TEST_CASE("The value alone is that of the shape functions", "[mmls][mmls_value]") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  MmlsOptions each;
  each.mu_each = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  MmlsOptions linear;
  linear.degree = 1;
  double worst = 0;
  for (const MmlsOptions& options : {MmlsOptions{}, each, linear}) {
    Mmls<3> mmls(options);
    MmlsValue value(options);
    for (int trial = 0; trial < 20; ++trial) {
      std::vector<MmlsValue::Node> node;
      std::vector<Vec3> X;
      std::vector<double> radius;
      for (int j = 0; j < 30; ++j) {
        X.push_back(0.01 * Vec3(unit(random), unit(random), unit(random)));
        radius.push_back(0.02 * (1 + 0.2 * unit(random)));
        node.push_back({X.back(), radius.back(), Vec3(unit(random), unit(random), unit(random))});
      }
      const Vec3 x = 0.005 * Vec3(unit(random), unit(random), unit(random));
      REQUIRE(mmls.evaluate(x, X.data(), radius.data(), 30));
      Vec3 expected = Vec3::Zero(), u;
      for (std::size_t j = 0; j < node.size(); ++j) expected += mmls.N()[j] * node[j].u;
      REQUIRE(value.at(x, node, u));
      worst = std::max(worst, (u - expected).norm());
    }
  }
  CHECK(worst < 1e-10);  // both are right to 1e-16 times a condition of at most 1e4 or so
}

TEST_CASE("A support that can't carry an approximation gives no value", "[mmls][mmls_value]") {
  MmlsValue value(MmlsOptions{});
  std::vector<MmlsValue::Node> flat;
  for (int j = 0; j < 16; ++j) flat.push_back({Vec3(0.001 * (j % 4), 0.001 * (j / 4), 0), 0.02, Vec3::Zero()});
  Vec3 u;
  CHECK_FALSE(value.at(Vec3(0.0015, 0.0015, 0), flat, u));
  flat.resize(3);
  CHECK_FALSE(value.at(Vec3(0.0015, 0.0015, 0), flat, u));
}

TEST_CASE("Far off a sheet of nodes that is hardly thick no values are made up", "[mmls][mmls_value]") {
  for (const double thickness : {1e-5, 1e-3}) {  // m
    std::vector<MmlsValue::Node> sheet;
    std::vector<Vec3> X;
    for (int j = 0; j < 16; ++j) {
      X.emplace_back(0.001 * (j % 4), 0.001 * (j / 4), thickness * (j % 3));
      sheet.push_back({X.back(), 0.02, Vec3::Zero()});
    }
    const Vec3 off(0.0015, 0.0015, 0.002);
    Mmls<3> mmls(MmlsOptions{});
    REQUIRE(mmls.evaluate(off, X.data(), std::vector<double>(X.size(), 0.02).data(), 16, nullptr, false));
    CHECK(mmls.quality().linear_error < 1e-8);
    double sum = 0;
    for (const double N : mmls.N()) sum += std::abs(N);
    CHECK(mmls.quality().magnitude == Approx(sum));
    CHECK((sum > 50) == (thickness < 1e-4));
    Vec3 u;
    CHECK(AdmissibilityLimits{}.admit(mmls.quality()) == (thickness > 1e-4));
    CHECK(MmlsValue(MmlsOptions{}).at(off, sheet, u) == (thickness > 1e-4));
  }
}
