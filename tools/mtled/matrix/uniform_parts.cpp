#include "mtled/matrix/uniform_parts.h"

#include <algorithm>
#include <utility>

#include "mtled/matrix/follow.h"

namespace palpate::tools {

Laminate::Laminate(std::vector<Layer> from, const Vec3& motion) : layers(std::move(from)) {
  const auto count = static_cast<Eigen::Index>(layers.size());
  double height = 0, modulus = 0;
  for (const Layer& layer : layers) {
    height += layer.height;
    modulus = std::max(modulus, layer.material.waveModulus());
  }
  const auto tractionOf = [&](Eigen::Index k, const Vec3& gradient) -> Vec3 {
    return layers[static_cast<std::size_t>(k)].material.firstPiola(Mat3::Identity() +
                                                                   gradient * Vec3::UnitZ().transpose()) *
           Vec3::UnitZ();
  };
  const auto residual = [&](const Eigen::VectorXd& x, double load) {
    Eigen::VectorXd r(3 * count);
    Vec3 reached = -load * motion;
    for (Eigen::Index k = 0; k < count; ++k)
      reached += layers[static_cast<std::size_t>(k)].height * x.segment<3>(3 * k);
    r.segment<3>(0) = reached / height;
    const Vec3 first = tractionOf(0, x.segment<3>(0));
    for (Eigen::Index k = 1; k < count; ++k)
      r.segment<3>(3 * k) = (tractionOf(k, x.segment<3>(3 * k)) - first) / modulus;
    return r;
  };
  const Eigen::VectorXd x = follow(residual, 3 * count, 1, 3 * count);
  for (Eigen::Index k = 0; k < count; ++k) c.emplace_back(x.segment<3>(3 * k));
  traction = tractionOf(0, c[0]);
}

Vec3 Laminate::moved(const Vec3& X) const {
  Vec3 x = X;
  double from = 0;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    x += std::clamp(X.z() - from, 0.0, layers[k].height) * c[k];
    from += layers[k].height;
  }
  return x;
}

double stressBetweenPlates(const Material& material, double along, bool y_held) {
  const auto stress = [&](const Eigen::VectorXd& x, double load) {
    const Vec3 stretch(1 + x[0], y_held ? 1 : 1 + x[1], 1 + load * (along - 1));
    return material.firstPiola(Mat3(stretch.asDiagonal()));
  };
  const double modulus = material.waveModulus();
  const auto residual = [&](const Eigen::VectorXd& x, double load) {
    const Mat3 P = stress(x, load);
    return Eigen::VectorXd(Eigen::Vector2d(P(0, 0) / modulus, y_held ? x[1] : P(1, 1) / modulus));
  };
  return stress(follow(residual, 2, 1, 2), 1)(2, 2);
}

}  // namespace palpate::tools
