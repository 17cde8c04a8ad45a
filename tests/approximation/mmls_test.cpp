#include <catch2/catch.hpp>
#include <random>

#include "approximation/mmls.h"
#include "approximation/neighbours.h"
#include "approximation/shape_functions.h"

using namespace palpate;

namespace {

template <int Dim>
struct Cloud {
  using Vec = typename Mmls<Dim>::Vec;
  std::vector<Vec> X;
  std::vector<double> radius;

  Cloud(int n, double r, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    while (static_cast<int>(X.size()) < n) {
      Vec x;
      for (int k = 0; k < Dim; ++k) x[k] = unit(random);
      X.push_back(x);
      radius.push_back(r * (1 + 0.3 * unit(random)));  // every node its own radius
    }
  }
  void support(const Vec& x, std::vector<Vec>& sX, std::vector<double>& sr) const {
    sX.clear();
    sr.clear();
    for (std::size_t j = 0; j < X.size(); ++j)
      if ((x - X[j]).norm() < radius[j]) {
        sX.push_back(X[j]);
        sr.push_back(radius[j]);
      }
  }
};

}  // namespace

TEMPLATE_TEST_CASE_SIG("MMLS reproduces what its basis promises", "[mmls]", ((int Dim), Dim), 2, 3) {
  using Vec = typename Mmls<Dim>::Vec;
  const Cloud<Dim> cloud(Dim == 2 ? 300 : 2000, Dim == 2 ? 0.2 : 0.25, 3);
  std::vector<Vec> sX;
  std::vector<double> sr;
  const Vec x = Vec::Constant(0.47);
  cloud.support(x, sX, sr);
  const int n = static_cast<int>(sX.size());

  for (const int degree : {1, 2})
    for (const double mu : {0.0, 0.1}) {
      Mmls<Dim> mmls({degree, mu});
      REQUIRE(mmls.evaluate(x, sX.data(), sr.data(), n));
      // Linear fields always; quadratics only without the constraint (mu = 0), degree 2.
      double one = 0;
      Vec lin = Vec::Zero(), done = Vec::Zero();
      double quad = 0;
      Vec dblock = Vec::Zero();
      for (int j = 0; j < n; ++j) {
        one += mmls.N()[j];
        lin += mmls.N()[j] * sX[j];
        done += mmls.gradN()[j];
        quad += mmls.N()[j] * sX[j][0] * sX[j][1];
        dblock += mmls.gradN()[j] * sX[j][0] * sX[j][1];
      }
      CHECK(std::abs(one - 1) < 1e-12);  // a few hundred rounding errors
      CHECK((lin - x).norm() < 1e-12);
      CHECK(done.norm() < 1e-10);
      const bool exact = degree == 2 && mu == 0;
      CHECK((std::abs(quad - x[0] * x[1]) < 1e-11) == exact);
      Vec expected = Vec::Zero();
      expected[0] = x[1];
      expected[1] = x[0];
      CHECK(((dblock - expected).norm() < 1e-9) == exact);
    }
}

TEMPLATE_TEST_CASE_SIG("MMLS gradients equal finite differences", "[mmls]", ((int Dim), Dim), 2, 3) {
  using Vec = typename Mmls<Dim>::Vec;
  const Cloud<Dim> cloud(Dim == 2 ? 300 : 2000, Dim == 2 ? 0.2 : 0.25, 5);
  const double step = 1e-6;
  // Away from cut-offs the field is smooth; values of nodes that enter or leave within the step are 0.
  for (const int degree : {1, 2}) {
    Mmls<Dim> at({degree, 0.1}), ahead({degree, 0.1}), behind({degree, 0.1});
    for (int trial = 0; trial < 5; ++trial) {
      const Vec x = Vec::Constant(0.35 + 0.06 * trial);
      for (int k = 0; k < Dim; ++k) {
        const Vec e = Vec::Unit(k) * step;
        std::vector<double> ones(cloud.X.size());
        const int n = static_cast<int>(cloud.X.size());
        // All nodes are handed over: beyond their radius their weight is zero.
        REQUIRE(at.evaluate(x, cloud.X.data(), cloud.radius.data(), n));
        REQUIRE(ahead.evaluate(x + e, cloud.X.data(), cloud.radius.data(), n));
        REQUIRE(behind.evaluate(x - e, cloud.X.data(), cloud.radius.data(), n));
        double worst = 0, largest = 0;
        for (int j = 0; j < n; ++j) {
          worst = std::max(worst, std::abs((ahead.N()[j] - behind.N()[j]) / (2 * step) - at.gradN()[j][k]));
          largest = std::max(largest, std::abs(at.gradN()[j][k]));
        }
        CHECK(worst < 1e-6 * largest);  // third derivatives ~ 1/R^3 times step^2, and rounding / step
      }
    }
  }
}

TEST_CASE("MMLS goes through pinned nodes, and stays linear and smooth", "[mmls]") {
  const Cloud<3> cloud(800, 0.3, 9);
  const int n = static_cast<int>(cloud.X.size());
  std::vector<std::uint8_t> pinned(cloud.X.size());
  for (std::size_t j = 0; j < pinned.size(); j += 4) pinned[j] = 1;
  const auto at = [&](Mmls<3>& mmls, const Vec3& x) {
    REQUIRE(mmls.evaluate(x, cloud.X.data(), cloud.radius.data(), n, pinned.data()));
  };
  Mmls<3> here({2, 0.1}), ahead({2, 0.1}), behind({2, 0.1}), free({2, 0.1});
  int tried = 0;
  for (std::size_t j = 0; j < pinned.size(); j += 4) {
    const Vec3& X = cloud.X[j];
    if ((X.array() < 0.25).any() || (X.array() > 0.75).any()) continue;
    ++tried;
    at(here, X);
    CHECK(here.N()[j] > 0.95);  // 1 but for the share of the floor, more where a support is lopsided
    REQUIRE(free.evaluate(X, cloud.X.data(), cloud.radius.data(), n));
    CHECK(free.N()[j] < 0.5);
    CHECK(here.quality().linear_error < 1e-10);
  }
  CHECK(tried > 5);
  const double step = 1e-6;
  const Vec3 x(0.41, 0.52, 0.47);
  at(here, x);
  for (int k = 0; k < 3; ++k) {
    at(ahead, x + Vec3::Unit(k) * step);
    at(behind, x - Vec3::Unit(k) * step);
    double worst = 0, largest = 0;
    for (std::size_t j = 0; j < cloud.X.size(); ++j) {
      worst = std::max(worst, std::abs((ahead.N()[j] - behind.N()[j]) / (2 * step) - here.gradN()[j][k]));
      largest = std::max(largest, std::abs(here.gradN()[j][k]));
    }
    CHECK(worst < 1e-6 * largest);
  }
}

TEST_CASE("MMLS stands where classical moving least squares is singular", "[mmls]") {
  // Nodes on two parallel planes: z^2 is constant on the nodes' span, the quadratic moment matrix singular.
  std::vector<Vec3> X;
  std::vector<double> radius;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int j = 0; j < 40; ++j) {
    X.emplace_back(unit(random), unit(random), j % 2 == 0 ? 0.0 : 0.4);
    radius.push_back(2.5);
  }
  Mmls<3> classical({2, 0.0}), modified({2, 0.1});
  const Vec3 x(0.1, -0.2, 0.2);
  CHECK_FALSE(classical.evaluate(x, X.data(), radius.data(), 40));
  REQUIRE(modified.evaluate(x, X.data(), radius.data(), 40));
  CHECK(modified.quality().linear_error < 1e-10);
  CHECK(modified.quality().gradient_error < 1e-9);
}

TEST_CASE("A coplanar support is refused, not hidden by its partition of unity", "[mmls]") {
  std::vector<Vec3> X;
  std::vector<double> radius;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      X.emplace_back(0.2 * i, 0.2 * j, 0.0);
      radius.push_back(0.9);
    }
  const Neighbours neighbours(X, radius);
  std::vector<InadmissibleSupport> failed;
  shapeFunctions({Vec3(0.5, 0.5, 0.0), Vec3(0.5, 0.5, 0.05)}, X, radius, neighbours, {2, 0.1}, failed);
  REQUIRE(failed.size() == 2);
  CHECK(failed[0].row == 0);
}

TEST_CASE("The interpolation error of a smooth field falls with spacing at the expected rate", "[mmls]") {
  // sin over jittered lattices of spacing h and h/2, radius proportional: error ~ h^2 for mu > 0
  // (linear consistency), and the halving must show at least 2^1.7.
  const auto error = [](int n) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> offset(-0.2, 0.2);
    std::vector<Vec3> X;
    const double h = 1.0 / n;
    for (int i = -2; i <= n + 2; ++i)
      for (int j = -2; j <= n + 2; ++j)
        for (int k = -2; k <= n + 2; ++k)
          X.emplace_back(h * (i + offset(random)), h * (j + offset(random)), h * (k + offset(random)));
    const std::vector<double> radius(X.size(), 2.2 * h);
    const Neighbours neighbours(X, radius);
    std::vector<Vec3> points;
    std::uniform_real_distribution<double> unit(0, 1);
    for (int q = 0; q < 300; ++q) points.emplace_back(unit(random), unit(random), unit(random));
    std::vector<InadmissibleSupport> failed;
    const ShapeTable table = shapeFunctions(points, X, radius, neighbours, {2, 0.1}, failed);
    REQUIRE(failed.empty());
    const auto f = [](const Vec3& x) { return std::sin(3 * x[0]) * std::cos(2 * x[1] + x[2]); };
    double sum = 0;
    for (int q = 0; q < 300; ++q) {
      double v = 0;
      for (int e = table.begin[q]; e < table.begin[q + 1]; ++e) v += table.N[e] * f(X[table.node[e]]);
      sum += std::pow(v - f(points[q]), 2);
    }
    return std::sqrt(sum / 300);
  };
  const double coarse = error(6), fine = error(12);
  INFO("rms error " << coarse << " -> " << fine);
  CHECK(coarse / fine > 3.2);
}

TEST_CASE("Supports are the nodes whose own radius reaches the point, in node order", "[neighbours]") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vec3> X;
  std::vector<double> radius;
  for (int j = 0; j < 500; ++j) {
    X.emplace_back(unit(random), unit(random), unit(random));
    radius.push_back(0.05 + 0.3 * unit(random));
  }
  const Neighbours neighbours(X, radius);
  std::vector<int> support;
  for (int q = 0; q < 50; ++q) {
    const Vec3 x(unit(random), unit(random), unit(random));
    std::vector<int> expected;
    for (int j = 0; j < 500; ++j)
      if ((x - X[j]).norm() < radius[j]) expected.push_back(j);
    neighbours.find(x, support);
    CHECK(support == expected);
  }
}
