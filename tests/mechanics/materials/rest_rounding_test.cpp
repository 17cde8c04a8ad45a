#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "support/law_lanes.h"

using namespace palpate;
using namespace palpate::test;

TEST_CASE("Near rest the rounding of the fast stress is a share of the strain, whatever the law",
          "[material][kernel]") {
  // As the difference of two stresses of about mu, it would be a share of mu: 10 % of the stress at a strain of 1e-6,
  // and a body at rest would never come to rest.
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-1, 1);
  constexpr int width = Simd<float>::width;
  for (const double alpha : {-1.1, 2.0, 6.0}) {
    const double mu = 643.6;
    const Material m = Material::ogden(&mu, &alpha, 1, 1.2598e-4, 970);
    for (const float strain : {1e-2F, 1e-4F, 1e-6F, 1e-9F}) {
      SimdTensor<float> H, P;
      alignas(64) float h[9][width], p[9][width];
      for (int k = 0; k < 9; ++k) {
        for (float& a : h[k]) a = strain * unit(random);
        H[k] = Simd<float>::load(h[k]);
      }
      lanesFirstPiola(m, H, P);
      for (int k = 0; k < 9; ++k) P[k].store(p[k]);
      for (int i = 0; i < width; ++i) {
        Mat3 gradient, fast;
        for (int k = 0; k < 9; ++k) {
          gradient(k / 3, k % 3) = static_cast<double>(h[k][i]);
          fast(k / 3, k % 3) = static_cast<double>(p[k][i]);
        }
        // The scalar formula's own rounding is some 1e-15 of the moduli, so the smallest strain is held to Hooke's law.
        const Mat3 small = gradient + gradient.transpose();
        const Mat3 exact = strain < 1e-8F ? Mat3(m.shear_modulus * small + (m.bulk_modulus - 2 * m.shear_modulus / 3) *
                                                                               gradient.trace() * Mat3::Identity())
                                          : m.firstPiola(Mat3::Identity() + gradient);
        INFO("alpha " << alpha << ", strain " << strain << ": " << (fast - exact).norm() / exact.norm());
        CHECK((fast - exact).norm() < 1e-5 * exact.norm());
      }
    }
  }
}
