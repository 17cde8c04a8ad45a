#include "mtled/verify/multilevel_spline.h"

#include <algorithm>
#include <cmath>

namespace palpate::tools {

template <class Each>
void MultilevelSpline::Level::around(const Vec3& X, Each each) const {
  std::array<std::size_t, 3> low{};
  double weight[3][4];
  for (std::size_t a = 0; a < 3; ++a) {
    const double index = std::clamp((X - origin)[static_cast<Eigen::Index>(a)] / edge, 0.0, cells[a] * (1 - 1e-12));
    low[a] = static_cast<std::size_t>(index);
    const double t = index - static_cast<double>(low[a]), s = 1 - t;
    weight[a][0] = s * s * s / 6;
    weight[a][1] = (3 * t * t * t - 6 * t * t + 4) / 6;
    weight[a][2] = (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6;
    weight[a][3] = t * t * t / 6;
  }
  const std::size_t row = static_cast<std::size_t>(cells[0]) + 3,
                    plane = row * (static_cast<std::size_t>(cells[1]) + 3);
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t i = 0; i < 4; ++i)
        each((low[2] + k) * plane + (low[1] + j) * row + low[0] + i, weight[0][i] * weight[1][j] * weight[2][k]);
}

void MultilevelSpline::Level::fit(const std::vector<Vec3>& X, const std::vector<Vec3>& value) {
  std::size_t count = 1;
  for (const int c : cells) count *= static_cast<std::size_t>(c + 3);
  phi.assign(count, Vec3::Zero());
  std::vector<double> sum(count, 0);
  for (std::size_t p = 0; p < X.size(); ++p) {
    double squares = 0;
    around(X[p], [&](std::size_t, double w) { squares += w * w; });
    around(X[p], [&](std::size_t c, double w) {
      phi[c] += w * w * w / squares * value[p];
      sum[c] += w * w;
    });
  }
  for (std::size_t c = 0; c < count; ++c)
    if (sum[c] > 0) phi[c] /= sum[c];
}

Vec3 MultilevelSpline::Level::at(const Vec3& X) const {
  Vec3 value = Vec3::Zero();
  around(X, [&](std::size_t c, double w) { value += w * phi[c]; });
  return value;
}

MultilevelSpline::MultilevelSpline(const std::vector<Vec3>& X, const std::vector<Vec3>& value, const Box3& box,
                                   double finest) {
  std::vector<Vec3> left = value;
  for (double edge = box.sizes().maxCoeff();; edge /= 2) {
    Level& level = levels_.emplace_back();
    level.origin = box.min();
    level.edge = edge;
    for (int a = 0; a < 3; ++a)
      level.cells[static_cast<std::size_t>(a)] = std::max(1, static_cast<int>(std::ceil(box.sizes()[a] / edge - 1e-9)));
    level.fit(X, left);
    for (std::size_t p = 0; p < X.size(); ++p) left[p] -= level.at(X[p]);
    if (edge <= finest) break;
  }
}

Vec3 MultilevelSpline::at(const Vec3& X) const {
  Vec3 value = Vec3::Zero();
  for (const Level& level : levels_) value += level.at(X);
  return value;
}

}  // namespace palpate::tools
