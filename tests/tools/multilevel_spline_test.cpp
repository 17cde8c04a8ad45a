#include "mtled/verify/multilevel_spline.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace palpate;
using palpate::tools::MultilevelSpline;

TEST_CASE("A multilevel spline goes through its points and nears a smooth field between them", "[multilevel_spline]") {
  const auto field = [](const Vec3& X) {
    return Vec3(std::sin(30 * X.x()), std::cos(20 * X.y()) * X.z(), X.x() + 2 * X.y());
  };
  std::vector<double> between;
  for (const int n : {8, 16}) {
    std::vector<Vec3> X, value;
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          X.emplace_back(0.1 * i / (n - 1), 0.1 * j / (n - 1), 0.1 * k / (n - 1));
          value.push_back(field(X.back()));
        }
    const MultilevelSpline spline(X, value, Box3(Vec3::Zero(), Vec3::Constant(0.1)), 0.1 / (2 * n));
    CHECK(spline.levelCount() == (n == 8 ? 5 : 6));
    double worst = 0, sum = 0;
    for (std::size_t p = 0; p < X.size(); ++p) worst = std::max(worst, (spline.at(X[p]) - value[p]).norm());
    CHECK(worst < 0.02);  // of 1
    for (int m = 0; m < 500; ++m) {
      const Vec3 at = 0.1 * Vec3(std::fmod(0.37 + 0.754878 * m, 1), std::fmod(0.569840 * m, 1), std::fmod(0.43 * m, 1));
      sum += (spline.at(at) - field(at)).norm() / 500;
    }
    between.push_back(sum);
  }
  CHECK(between[1] < 0.5 * between[0]);
  CHECK(between[1] < 0.05);
}
