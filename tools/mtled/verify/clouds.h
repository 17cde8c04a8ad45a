#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace palpate::tools {

/// Nodes on which the quadratic moment matrix of classical moving least squares is singular, because a
/// polynomial of second degree vanishes on all of them or because they are fewer than its coefficients.
template <int Dim>
struct SingularCloud {
  using Vec = Eigen::Matrix<double, Dim, 1>;
  std::string name;
  std::string reason;           // the polynomial that vanishes, or what else is missing
  bool mmls_admissible = true;  // false: the linear part is lost as well, and no mu restores it
  std::vector<Vec> X;           // (node_count) m
  std::vector<double> radius;   // (node_count) m; every node supports every point
  std::vector<Vec> at;          // where to evaluate, m
};

/// The clouds of Dim = 2 or 3 dimensions; the same bits with every standard library.
/// Test: approximation/singular_clouds_test.cpp
template <int Dim>
std::vector<SingularCloud<Dim>> singularClouds();

template <>
std::vector<SingularCloud<2>> singularClouds<2>();
template <>
std::vector<SingularCloud<3>> singularClouds<3>();

/// Quadratic moving least squares at one point without guards, scale derivatives or reuse: what Mmls is
/// compared with, and what classical moving least squares would say on a singular cloud.
struct PlainMls {
  double reciprocal_condition = 0;  // smallest over largest singular value of the moment matrix
  double unity_error = 0;           // |sum N - 1|
  double linear_error = 0;          // |sum N (X - x)|_inf / scale
  std::vector<double> N;            // (node_count)
};

/// @param mu  weight of the constraints, dimensionless (mmls.h); 0: classical moving least squares
template <int Dim>
PlainMls plainMls(const Eigen::Matrix<double, Dim, 1>& x, const std::vector<Eigen::Matrix<double, Dim, 1>>& X,
                  const std::vector<double>& radius, double mu);

extern template PlainMls plainMls<2>(const Eigen::Vector2d&, const std::vector<Eigen::Vector2d>&,
                                     const std::vector<double>&, double);
extern template PlainMls plainMls<3>(const Eigen::Vector3d&, const std::vector<Eigen::Vector3d>&,
                                     const std::vector<double>&, double);

}  // namespace palpate::tools
