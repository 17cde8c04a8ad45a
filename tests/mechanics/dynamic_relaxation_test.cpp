#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <cmath>

#include "mechanics/dynamic_relaxation.h"

using namespace palpate;
using Vector = Eigen::VectorXd;

namespace {

/// n equal masses in a row between walls, joined by equal springs: frequencies 2 sqrt(k/m) sin(i pi / (2 (n + 1))).
struct Chain {
  int n = 100;
  double stiffness = 50;  // N/m
  double mass = 0.02;     // kg

  double frequency(int i) const { return 2 * std::sqrt(stiffness / mass) * std::sin(i * M_PI / (2 * (n + 1))); }
  /// h = 2 / sqrt(w0^2 + w1^2)
  double bestStep() const { return 2 / std::hypot(frequency(1), frequency(n)); }
  double bestRate() const {
    const double root_k = 2 / (frequency(1) * bestStep());
    return (root_k - 1) / (root_k + 1);
  }
  Vector force(const Vector& u) const {
    Vector f = -2 * stiffness * u;
    f.head(n - 1) += stiffness * u.tail(n - 1);
    f.tail(n - 1) += stiffness * u.head(n - 1);
    return f;
  }
  /// Where the chain comes to rest under unlike loads.
  Vector equilibrium() const {
    Vector u(n);
    for (int i = 0; i < n; ++i) u[i] = 1e-3 * (std::sin(3.0 * i / n) + 0.2 * std::sin(40.0 * i / n));
    return u;
  }
};

/// The chain relaxing to its equilibrium under the load that belongs to it.
struct Run {
  const Chain& chain;
  DynamicRelaxation& relaxation;
  Vector rest = chain.equilibrium(), load = -chain.force(rest), u = Vector::Zero(chain.n), du = u;

  Run(const Chain& c, DynamicRelaxation& r) : chain(c), relaxation(r) {}
  Vector unbalanced() const { return load + chain.force(u); }
  void iterate() {
    du = relaxation.beta() * du + relaxation.alpha() / chain.mass * unbalanced();
    u += du;
  }
  double error() const { return (u - rest).lpNorm<Eigen::Infinity>(); }
  double increment() const { return du.lpNorm<Eigen::Infinity>(); }
};

/// Brings the load on as gently as the static solver, and feeds the estimate as it does.
void observeFor(Run& run, int iterations) {
  constexpr int reference_interval = 200, ramp = 200;
  const Vector whole = run.load;
  Vector u0, f0;
  for (int k = 1; k <= iterations; ++k) {
    const double s = std::min(1.0, static_cast<double>(k) / ramp);
    run.load = s * s * s * (10 + s * (-15 + 6 * s)) * whole;
    const Vector u = run.u, f = run.chain.force(u);
    if (k % reference_interval == 1) {
      u0 = u;
      f0 = f;
    } else {
      run.relaxation.observe(-(u - u0).dot(f - f0), run.chain.mass * (u - u0).squaredNorm());
    }
    run.iterate();
  }
}

}  // namespace

TEST_CASE("With the lowest frequency known, the error falls at the rate that theory gives", "[dynamic_relaxation]") {
  const Chain chain;
  DynamicRelaxation relaxation(chain.bestStep());
  relaxation.setLowestFrequency(chain.frequency(1));
  CHECK(relaxation.convergenceRate() == Approx(chain.bestRate()).epsilon(1e-12));
  CHECK(relaxation.beta() == Approx(chain.bestRate() * chain.bestRate()).epsilon(1e-12));

  Run run(chain, relaxation);
  const double start = run.error(), wanted = 1e-8;
  int iterations = 0;
  while (run.error() > wanted * start && iterations < 100000) {
    run.iterate();
    ++iterations;
  }
  // All roots have modulus r; that of the lowest mode is double, which costs (1 + k (1 - r)) more: with N (1 - r) =
  // ln 1e8 = 18.4 a factor 20, and N grows by ln 20 / (1 - r).
  const double single = std::log(1 / wanted) / -std::log(chain.bestRate());
  const double twofold = std::log(21 / wanted) / -std::log(chain.bestRate());
  INFO("iterations " << iterations << ", single roots " << single << ", with the double root " << twofold);
  CHECK(iterations > 0.95 * single);
  CHECK(iterations < 1.1 * twofold);
}

TEST_CASE("A step of the wrong rate converges more slowly, on either side", "[dynamic_relaxation]") {
  const Chain chain;
  const auto errorAfter = [&](double factor) {
    DynamicRelaxation relaxation(chain.bestStep());
    relaxation.setLowestFrequency(factor * chain.frequency(1));
    Run run(chain, relaxation);
    for (int k = 0; k < 600; ++k) run.iterate();
    return run.error();
  };
  const double best = errorAfter(1);
  CHECK(errorAfter(0.5) > 10 * best);
  CHECK(errorAfter(2) > 10 * best);
}

TEST_CASE("The lowest frequency is found from the way and the forces alone", "[dynamic_relaxation]") {
  const Chain chain;
  DynamicRelaxation relaxation(chain.bestStep());
  const double initial = relaxation.convergenceRate();
  Run run(chain, relaxation);
  observeFor(run, 800);  // to 1e-10 or so of the way: beyond 1200 only rounding is left to look at
  REQUIRE(relaxation.convergenceRate() != initial);
  // Higher modes that are left over, and the 1 % of agreement that is asked of w^2, raise the estimate a little.
  CHECK(1 - relaxation.convergenceRate() == Approx(1 - chain.bestRate()).epsilon(0.05));
}

TEST_CASE("Estimates that don't agree, or make no sense, change nothing", "[dynamic_relaxation]") {
  DynamicRelaxation relaxation(0.01);
  const double initial = relaxation.convergenceRate();
  for (int k = 0; k < 1000; ++k) relaxation.observe(k % 2 == 0 ? 1.0 : 1.03, 1.0);
  for (int k = 0; k < 1000; ++k) relaxation.observe(-1, 1);
  for (int k = 0; k < 1000; ++k) relaxation.observe(1, 0);
  for (int k = 0; k < 1000; ++k) relaxation.observe(NAN, 1);
  CHECK(relaxation.convergenceRate() == initial);
  for (int k = 0; k < 21; ++k) relaxation.observe(100, 1);
  const double root_k = 2 / (10 * 0.01);
  CHECK(relaxation.convergenceRate() == Approx((root_k - 1) / (root_k + 1)));
  // However slow or fast the mode, the iteration stays one.
  relaxation.setLowestFrequency(1e-9);
  CHECK(relaxation.convergenceRate() < 1);
  relaxation.setLowestFrequency(1e9);
  CHECK(relaxation.convergenceRate() >= 0.5);
}

TEST_CASE("What is estimated to remain is more than the true error", "[dynamic_relaxation]") {
  const Chain chain;
  for (const double factor : {0.8, 1.0, 1.1}) {  // the estimate of w0 is a Rayleigh quotient: high rather than low
    DynamicRelaxation relaxation(chain.bestStep());
    relaxation.setLowestFrequency(factor * chain.frequency(1));
    Run run(chain, relaxation);
    int calm = 0, iterations = 0;
    const double tolerance = 1e-4 * run.rest.lpNorm<Eigen::Infinity>();
    while (calm < 20 && ++iterations < 100000) {
      run.iterate();
      calm = relaxation.remaining(run.increment()) < tolerance ? calm + 1 : 0;
    }
    INFO("w0 times " << factor << ": error " << run.error() << " estimate " << relaxation.remaining(run.increment()));
    REQUIRE(calm == 20);
    CHECK(run.error() < tolerance);
    CHECK(run.error() > 0.01 * tolerance);  // not so cautious that it costs many times the iterations
  }
}
