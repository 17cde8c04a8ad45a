#pragma once

#include <array>
#include <random>
#include <vector>

#include "approximation/shape_functions.h"
#include "base/types.h"
#include "mechanics/materials/material.h"
#include "mechanics/node_patch.h"

namespace palpate::test {

/// A lattice of n^3 nodes, x fastest: six tetrahedra around each cube's diagonal (Kuhn).
inline std::vector<std::array<int, 4>> kuhnCells(int n) {
  const auto id = [n](const int* a) { return (a[2] * n + a[1]) * n + a[0]; };
  const int order[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  std::vector<std::array<int, 4>> cells;
  for (int k = 0; k + 1 < n; ++k)
    for (int j = 0; j + 1 < n; ++j)
      for (int i = 0; i + 1 < n; ++i)
        for (const auto& o : order) {
          int at[3] = {i, j, k};
          std::array<int, 4> cell = {id(at)};
          for (int s = 0; s < 3; ++s) {
            ++at[o[s]];
            cell[s + 1] = id(at);
          }
          cells.push_back(cell);
        }
  return cells;
}

/// A jittered lattice in a box, cut into tetrahedra: the small irregular body of the unit tests.
struct TestBody {
  std::vector<Vec3> X;
  std::vector<std::array<int, 4>> cells;
  std::vector<double> radius;
  std::vector<Vec3> point_X;
  std::vector<double> volume;
  std::vector<int> point_material;
  std::vector<int> point_cell;
  std::vector<double> mass;
  ShapeTable shape;
  std::vector<Material> materials;
  int n = 0;

  /// @param n        nodes per edge
  /// @param edge     m
  /// @param points   per cell, 1 or 4
  /// @param jitter   of inner nodes, in lattice spacings
  TestBody(int nodes_per_edge, double edge, int points, double factor = 1.8, double mu = 0.1, double jitter = 0.2,
           const Material& material = Material::neoHookean(3000, 0.49, 1000))
      : materials{material}, n(nodes_per_edge) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> offset(-jitter, jitter);
    const double h = edge / (n - 1);
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const double dx = offset(random), dy = offset(random), dz = offset(random);
          const auto inner = [&](int a) { return a > 0 && a < n - 1; };
          X.emplace_back(h * (i + (inner(i) ? dx : 0)), h * (j + (inner(j) ? dy : 0)), h * (k + (inner(k) ? dz : 0)));
        }
    cells = kuhnCells(n);
    mass.assign(X.size(), 0);
    constexpr double a = 0.58541019662496845, b = 0.13819660112501052;
    for (const auto& c : cells) {
      const double v = std::abs((X[c[1]] - X[c[0]]).cross(X[c[2]] - X[c[0]]).dot(X[c[3]] - X[c[0]])) / 6;
      for (int s = 0; s < 4; ++s) mass[c[s]] += material.density * v / 4;
      const int cell = static_cast<int>(&c - cells.data());
      for (int p = 0; p < points; ++p) point_cell.push_back(cell);
      if (points == 1) {
        point_X.push_back((X[c[0]] + X[c[1]] + X[c[2]] + X[c[3]]) / 4);
        volume.push_back(v);
      } else {
        for (int s = 0; s < 4; ++s) {
          Vec3 x = Vec3::Zero();
          for (int t = 0; t < 4; ++t) x += (s == t ? a : b) * X[c[t]];
          point_X.push_back(x);
          volume.push_back(v / 4);
        }
      }
    }
    point_material.assign(point_X.size(), 0);
    radius.assign(X.size(), factor * h * 1.3);  // 1.3 h: mean edge of the tetrahedra
    const Neighbours neighbours(X, radius);
    std::vector<InadmissibleSupport> failed;
    shape = shapeFunctions(point_X, X, radius, neighbours, {2, mu}, failed);
    if (!failed.empty()) throw std::runtime_error("test body has inadmissible supports");
  }

  NodePatches patches() const {
    return makeNodePatches(X, cells, point_X, volume, point_cell, point_material, materials);
  }
  int nodeCount() const { return static_cast<int>(X.size()); }
  std::vector<Vec3> displacement(const Mat3& F) const {
    std::vector<Vec3> u;
    for (const auto& x : X) u.emplace_back((F - Mat3::Identity()) * x);
    return u;
  }
};

inline AlignedVector<Float4> toFloat4s(const std::vector<Vec3>& u) {
  AlignedVector<Float4> r;
  for (const auto& a : u) r.push_back(toFloat4(a));
  return r;
}

}  // namespace palpate::test
