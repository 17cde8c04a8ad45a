#include "mtled/verify/clouds.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <functional>
#include <random>

#include "approximation/weight_function.h"

namespace palpate::tools {
namespace {

/// Uniform in (-1, 1).
class Unit {
 public:
  double operator()() { return (engine_() + 0.5) / 2147483648.0 - 1; }

 private:
  std::mt19937 engine_{11};
};

template <int Dim>
SingularCloud<Dim> cloud(const std::string& name, const std::string& reason, int count,
                         const std::function<typename SingularCloud<Dim>::Vec(int, Unit&)>& node) {
  SingularCloud<Dim> c;
  c.name = name;
  c.reason = reason;
  Unit unit;
  for (int j = 0; j < count; ++j) {
    c.X.push_back(node(j, unit));
    c.radius.push_back(3.0);
  }
  return c;
}

}  // namespace

template <>
std::vector<SingularCloud<2>> singularClouds<2>() {
  using Vec = Eigen::Vector2d;
  std::vector<SingularCloud<2>> clouds;
  clouds.push_back(
      cloud<2>("two lines", "y (y - 0.4) = 0", 20, [](int j, Unit& u) { return Vec(u(), j % 2 == 0 ? 0 : 0.4); }));
  clouds.push_back(cloud<2>("circle", "x^2 + y^2 - 1 = 0", 20, [](int, Unit& u) {
    const double angle = M_PI * u();
    return Vec(std::cos(angle), std::sin(angle));
  }));
  clouds.push_back(
      cloud<2>("crossed lines", "x y = 0", 20, [](int j, Unit& u) { return j % 2 == 0 ? Vec(u(), 0) : Vec(0, u()); }));
  clouds.push_back(cloud<2>("five nodes", "5 nodes, 6 coefficients", 5, [](int j, Unit& u) {
    return Vec(std::cos(1.2566 * j) + 0.2 * u(), std::sin(1.2566 * j) + 0.2 * u());
  }));
  clouds.push_back(cloud<2>("three nodes", "3 nodes, 6 coefficients", 3,
                            [](int j, Unit&) { return Vec(j == 1 ? 1.0 : -0.5, j == 2 ? 1.0 : -0.5); }));
  clouds.push_back(cloud<2>("one line", "y - 0.5 x = 0", 20, [](int, Unit& u) {
    const double x = u();
    return Vec(x, 0.5 * x);
  }));
  clouds.back().mmls_admissible = false;
  for (auto& c : clouds) c.at = {Vec(0.1, 0.05), Vec(-0.2, 0.15), Vec(0.05, 0.2)};
  return clouds;
}

template <>
std::vector<SingularCloud<3>> singularClouds<3>() {
  using Vec = Eigen::Vector3d;
  std::vector<SingularCloud<3>> clouds;
  clouds.push_back(cloud<3>("two planes", "z (z - 0.4) = 0", 40, [](int j, Unit& u) {
    const double x = u(), y = u();
    return Vec(x, y, j % 2 == 0 ? 0 : 0.4);
  }));
  clouds.push_back(cloud<3>("sphere", "x^2 + y^2 + z^2 - 1 = 0", 40, [](int, Unit& u) {
    const double z = u(), angle = M_PI * u(), r = std::sqrt(1 - z * z);
    return Vec(r * std::cos(angle), r * std::sin(angle), z);
  }));
  clouds.push_back(cloud<3>("cylinder", "x^2 + y^2 - 1 = 0", 40, [](int, Unit& u) {
    const double z = u(), angle = M_PI * u();
    return Vec(std::cos(angle), std::sin(angle), z);
  }));
  clouds.push_back(cloud<3>("crossed planes", "x z = 0", 40, [](int j, Unit& u) {
    const double a = u(), y = u();
    return j % 2 == 0 ? Vec(a, y, 0) : Vec(0, y, a);
  }));
  clouds.push_back(cloud<3>("nine nodes", "9 nodes, 10 coefficients", 9, [](int j, Unit& u) -> Vec {
    const Vec corner(j & 1 ? 0.7 : -0.7, j & 2 ? 0.7 : -0.7, j & 4 ? 0.7 : -0.7);
    const double x = u(), y = u(), z = u();
    return (j < 8 ? corner : Vec(Vec::Zero())) + 0.2 * Vec(x, y, z);
  }));
  clouds.push_back(cloud<3>("four nodes", "4 nodes, 10 coefficients", 4, [](int j, Unit&) {
    return Vec(j == 1 ? 1.0 : -0.5, j == 2 ? 1.0 : -0.5, j == 3 ? 1.0 : -0.5);
  }));
  clouds.push_back(cloud<3>("one plane", "z - 0.5 x = 0", 40, [](int, Unit& u) {
    const double x = u(), y = u();
    return Vec(x, y, 0.5 * x);
  }));
  clouds.back().mmls_admissible = false;
  for (auto& c : clouds) c.at = {Vec(0.1, -0.1, 0.05), Vec(-0.2, 0.1, 0.15), Vec(0.05, 0.02, 0.2)};
  return clouds;
}

template <int Dim>
PlainMls plainMls(const Eigen::Matrix<double, Dim, 1>& x, const std::vector<Eigen::Matrix<double, Dim, 1>>& X,
                  const std::vector<double>& radius, double mu) {
  constexpr int size = (Dim + 1) * (Dim + 2) / 2;
  const int n = static_cast<int>(X.size());
  Eigen::VectorXd w(n);
  for (int j = 0; j < n; ++j) w[j] = quarticSpline((x - X[j]).norm() / radius[j]);
  const double scale = w.dot(Eigen::Map<const Eigen::VectorXd>(radius.data(), n)) / w.sum();

  Eigen::MatrixXd P(n, size);
  for (int j = 0; j < n; ++j) {
    const Eigen::Matrix<double, Dim, 1> xi = (X[j] - x) / scale;
    P(j, 0) = 1;
    int m = 1;
    for (int k = 0; k < Dim; ++k) P(j, m++) = xi[k];
    for (int k = 0; k < Dim; ++k)
      for (int l = k; l < Dim; ++l) P(j, m++) = xi[k] * xi[l];
  }
  Eigen::MatrixXd M = P.transpose() * w.asDiagonal() * P;
  M.diagonal().tail(size - 1 - Dim).array() += mu;

  PlainMls result;
  const Eigen::VectorXd singular = Eigen::JacobiSVD<Eigen::MatrixXd>(M).singularValues();
  result.reciprocal_condition = singular[size - 1] / singular[0];
  const Eigen::VectorXd N = w.asDiagonal() * (P * M.partialPivLu().solve(Eigen::VectorXd::Unit(size, 0)));
  result.N.assign(N.data(), N.data() + n);
  result.unity_error = std::abs(N.sum() - 1);
  result.linear_error = (P.middleCols(1, Dim).transpose() * N).cwiseAbs().maxCoeff();
  return result;
}

template PlainMls plainMls<2>(const Eigen::Vector2d&, const std::vector<Eigen::Vector2d>&, const std::vector<double>&,
                              double);
template PlainMls plainMls<3>(const Eigen::Vector3d&, const std::vector<Eigen::Vector3d>&, const std::vector<double>&,
                              double);

}  // namespace palpate::tools
