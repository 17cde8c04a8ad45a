#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "approximation/mmls.h"
#include "approximation/shape_functions.h"
#include "mtled/verify/clouds.h"

using namespace palpate;
using namespace palpate::tools;

namespace {

constexpr double mu = 0.1;

}  // namespace

TEMPLATE_TEST_CASE_SIG("MMLS stands on every cloud where classical moving least squares is singular", "[mmls]",
                       ((int Dim), Dim), 2, 3) {
  const AdmissibilityLimits limits;
  Mmls<Dim> classical({2, 0}), modified({2, mu});
  for (const auto& cloud : singularClouds<Dim>())
    for (const auto& x : cloud.at) {
      const int n = static_cast<int>(cloud.X.size());
      INFO(Dim << "D, " << cloud.name << " at " << x.transpose());
      const PlainMls plain = plainMls<Dim>(x, cloud.X, cloud.radius, 0);
      CHECK(plain.reciprocal_condition < 1e-15);  // singular but for rounding
      CHECK_FALSE(classical.evaluate(x, cloud.X.data(), cloud.radius.data(), n));
      const bool stands =
          modified.evaluate(x, cloud.X.data(), cloud.radius.data(), n) && limits.admit(modified.quality());
      CHECK(stands == cloud.mmls_admissible);
      if (!stands) continue;
      CHECK(modified.quality().linear_error < 1e-13);  // some hundred roundings of numbers near 1
      CHECK(modified.quality().gradient_error < 1e-12);
      const PlainMls reference = plainMls<Dim>(x, cloud.X, cloud.radius, mu);
      for (int j = 0; j < n; ++j) REQUIRE(modified.N()[j] == Approx(reference.N[j]).margin(1e-11));
    }
}

TEMPLATE_TEST_CASE_SIG("The singular clouds lie where they say, and a small nudge frees them", "[mmls]",
                       ((int Dim), Dim), 2, 3) {
  // Moved off their curve by 0.3 at random, the clouds that have nodes enough are no longer singular: it is the
  // place of the nodes, not their number, that defeats classical moving least squares.
  for (auto cloud : singularClouds<Dim>()) {
    constexpr int coefficients = (Dim + 1) * (Dim + 2) / 2;
    if (static_cast<int>(cloud.X.size()) < coefficients) continue;
    for (std::size_t j = 0; j < cloud.X.size(); ++j)
      for (int k = 0; k < Dim; ++k) cloud.X[j][k] += 0.3 * std::sin(7.0 * static_cast<double>(j * Dim + k));
    Mmls<Dim> classical({2, 0});
    INFO(cloud.name);
    CHECK(classical.evaluate(cloud.at[0], cloud.X.data(), cloud.radius.data(), static_cast<int>(cloud.X.size())));
  }
}

// The demonstration of section 2.1. Run with: approximation_tests "[.table]"
TEMPLATE_TEST_CASE_SIG("Classical and modified moving least squares on singular clouds", "[.table]", ((int Dim), Dim),
                       2, 3) {
  std::printf(
      "%dD                       nodes | MLS: rcond  unity    linear  engine  | MMLS: rcond unity    linear  engine\n",
      Dim);
  const AdmissibilityLimits limits;
  for (const auto& cloud : singularClouds<Dim>()) {
    const auto x = cloud.at[0];
    const PlainMls a = plainMls<Dim>(x, cloud.X, cloud.radius, 0), b = plainMls<Dim>(x, cloud.X, cloud.radius, mu);
    const auto verdict = [&](double weight) {
      Mmls<Dim> mmls({2, weight});
      return mmls.evaluate(x, cloud.X.data(), cloud.radius.data(), static_cast<int>(cloud.X.size())) &&
                     limits.admit(mmls.quality())
                 ? "stands"
                 : "refuses";
    };
    std::printf("%-24s  %4zu | %9.1e %8.1e %8.1e %-7s | %9.1e %8.1e %8.1e %s\n", cloud.name.c_str(), cloud.X.size(),
                a.reciprocal_condition, a.unity_error, a.linear_error, verdict(0), b.reciprocal_condition,
                b.unity_error, b.linear_error, verdict(mu));
  }
}
