#include "mechanics/node_patch.h"

#include <Eigen/LU>
#include <algorithm>

namespace palpate {
namespace {

constexpr double min_weight = 1e-6;  // of a point for a node of its cell: no patch has points but no volume
constexpr double max_own = 0.999;    // of a point's volume: the same

}  // namespace

NodePatches makeNodePatches(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                            const std::vector<Vec3>& point_X, const std::vector<double>& volume,
                            const std::vector<int>& point_cell, const std::vector<int>& point_material,
                            const std::vector<Material>& materials, double own_bulk) {
  NodePatches patches;
  patches.volume.assign(X.size(), 0);
  patches.bulk_modulus.assign(X.size(), 0);
  for (std::size_t q = 0; q < point_X.size(); ++q) {
    const auto& cell = cells[point_cell[q]];
    Mat3 edges;
    for (int c = 0; c < 3; ++c) edges.col(c) = X[cell[c + 1]] - X[cell[0]];
    const Vec3 l = edges.inverse() * (point_X[q] - X[cell[0]]);
    std::array<double, 4> weight{1 - l.sum(), l[0], l[1], l[2]};
    if (*std::min_element(weight.begin(), weight.end()) < min_weight) {
      double sum = 0;
      for (double& w : weight) sum += w = std::max(w, min_weight);
      for (double& w : weight) w /= sum;
    }
    if (own_bulk > 0) {
      const Material& material = materials[point_material[q]];
      const double shear = material.shear_modulus * material.longTermShare();
      patches.own.push_back(std::min(max_own, own_bulk * shear / material.bulk_modulus));
      for (double& w : weight) w *= 1 - patches.own.back();
    }
    for (int a = 0; a < 4; ++a) {
      patches.volume[cell[a]] += volume[q] * weight[a];
      patches.bulk_modulus[cell[a]] += volume[q] * weight[a] / materials[point_material[q]].bulk_modulus;
    }
    patches.node.push_back(cell);
    patches.weight.push_back(weight);
  }
  for (std::size_t a = 0; a < X.size(); ++a)
    if (patches.volume[a] > 0) patches.bulk_modulus[a] = patches.volume[a] / patches.bulk_modulus[a];
  return patches;
}

std::vector<double> patchDilatation(const NodePatches& patches, const std::vector<double>& volume,
                                    const std::vector<double>& J_minus_1) {
  std::vector<double> theta(patches.volume.size(), 0);
  for (std::size_t q = 0; q < J_minus_1.size(); ++q)
    for (int a = 0; a < 4; ++a) {
      const int node = patches.node[q][a];
      theta[node] += volume[q] * patches.weight[q][a] / patches.volume[node] * J_minus_1[q];
    }
  return theta;
}

std::vector<double> pointPressure(const NodePatches& patches, const std::vector<double>& node_pressure) {
  std::vector<double> pressure(patches.node.size(), 0);
  for (std::size_t q = 0; q < pressure.size(); ++q)
    for (int a = 0; a < 4; ++a) pressure[q] += patches.weight[q][a] * node_pressure[patches.node[q][a]];
  return pressure;
}

std::vector<double> patchPressure(const NodePatches& patches, const std::vector<double>& volume,
                                  const std::vector<double>& J_minus_1) {
  std::vector<double> pressure = patchDilatation(patches, volume, J_minus_1);
  for (std::size_t a = 0; a < pressure.size(); ++a) pressure[a] *= patches.bulk_modulus[a];
  return pointPressure(patches, pressure);
}

void addOwnPressure(const NodePatches& patches, const std::vector<int>& point_material,
                    const std::vector<Material>& materials, const std::vector<double>& J_minus_1,
                    std::vector<double>& pressure) {
  for (std::size_t q = 0; q < patches.own.size(); ++q)
    pressure[q] += patches.own[q] * materials[point_material[q]].bulk_modulus * J_minus_1[q];
}

std::vector<double> averagedShares(const NodePatches& patches) {
  std::vector<double> share(patches.volume.size(), 1);
  if (patches.own.empty()) return share;
  std::vector<double> whole(share.size(), 0), averaged(share.size(), 0);
  for (std::size_t q = 0; q < patches.own.size(); ++q)
    for (std::size_t a = 0; a < 4; ++a) {
      const auto node = static_cast<std::size_t>(patches.node[q][a]);
      averaged[node] += patches.weight[q][a];
      whole[node] += patches.weight[q][a] / (1 - patches.own[q]);
    }
  for (std::size_t a = 0; a < share.size(); ++a)
    if (whole[a] > 0) share[a] = averaged[a] / whole[a];
  return share;
}

}  // namespace palpate
