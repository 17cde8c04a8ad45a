#include "mtled/verify/thick_sphere.h"

#include <cmath>

namespace palpate::tools {
namespace {

struct RadialState {
  double r = 0, P = 0;  // m, Pa: place and radial stress of a shell
};

/// P_r and P_t of radial and hoop stretches.
Eigen::Vector2d stresses(const Material& m, double radial, double hoop) {
  const Mat3 P = m.firstPiola(Vec3(radial, hoop, hoop).asDiagonal().toDenseMatrix());
  return {P(0, 0), P(1, 1)};
}

/// The radial stretch at which P_r is as given, by Newton's method from that of unchanged volume.
double radialStretch(const Material& m, double hoop, double P) {
  double l = 1 / (hoop * hoop);
  for (int k = 0; k < 60; ++k) {
    constexpr double h = 1e-6;
    const double slope = (stresses(m, l + h, hoop)[0] - stresses(m, l - h, hoop)[0]) / (2 * h);
    const double step = (P - stresses(m, l, hoop)[0]) / slope;
    l += step;
    if (std::abs(step) < 1e-13) break;
  }
  return l;
}

RadialState slopes(const Material& m, double R, const RadialState& s) {
  const double hoop = s.r / R, radial = radialStretch(m, hoop, s.P);
  return {radial, 2 * (stresses(m, radial, hoop)[1] - s.P) / R};
}

/// From the outside, at rest at b and now at r_b, to the hollow.
RadialState atHollow(const Material& m, double a, double b, double r_b) {
  constexpr int steps = 400;
  const double h = (a - b) / steps;
  RadialState s{r_b, 0};
  const auto moved = [&](const RadialState& k, double share) {
    return RadialState{s.r + share * h * k.r, s.P + share * h * k.P};
  };
  for (int n = 0; n < steps; ++n) {
    const double R = b + n * h;
    const RadialState k1 = slopes(m, R, s), k2 = slopes(m, R + h / 2, moved(k1, 0.5));
    const RadialState k3 = slopes(m, R + h / 2, moved(k2, 0.5)), k4 = slopes(m, R + h, moved(k3, 1));
    s.r += h / 6 * (k1.r + 2 * k2.r + 2 * k3.r + k4.r);
    s.P += h / 6 * (k1.P + 2 * k2.P + 2 * k3.P + k4.P);
  }
  return s;
}

}  // namespace

ThickSphere::ThickSphere(const Material& material, double a, double b, double stretch) {
  double low = b, high = stretch * b;  // the outside widens by less than the hollow
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2;
    (atHollow(material, a, b, middle).r < stretch * a ? low : high) = middle;
  }
  const RadialState s = atHollow(material, a, b, low);
  pressure_ = -s.P * a * a / (s.r * s.r);
  outer_stretch_ = low / b;
}

}  // namespace palpate::tools
