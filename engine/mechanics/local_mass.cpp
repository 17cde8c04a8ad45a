#include "mechanics/local_mass.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

/// Entries of a node's row below this part of the row's largest are left out: the mean changes by less than a percent.
constexpr double least_weight = 0.02;

/// One row of weights, summed by key.
class WeightRow {
 public:
  explicit WeightRow(std::size_t count) : weight_(count, 0) {}
  void add(int key, double weight) {
    if (weight_[static_cast<std::size_t>(key)] == 0) keys_.push_back(key);
    weight_[static_cast<std::size_t>(key)] += weight;
  }
  /// Appends the keys, ascending, with weights of sum 1, and forgets them.
  void flush(std::vector<std::int32_t>& keys, AlignedVector<float>& weights) {
    std::sort(keys_.begin(), keys_.end());
    double largest = 0, sum = 0;
    const auto of = [&](int key) -> double& { return weight_[static_cast<std::size_t>(key)]; };
    for (const int key : keys_) largest = std::max(largest, of(key));
    for (const int key : keys_)
      if (of(key) >= least_weight * largest) sum += of(key);
    for (const int key : keys_) {
      if (of(key) >= least_weight * largest) {
        keys.push_back(key);
        weights.push_back(static_cast<float>(of(key) / sum));
      }
      of(key) = 0;
    }
    keys_.clear();
  }

 private:
  std::vector<double> weight_;
  std::vector<int> keys_;
};

}  // namespace

StiffnessMeans makeStiffnessMeans(const KernelLayout& layout, const ShapeTable& shape,
                                  const std::vector<std::array<int, 4>>& point_vertices,
                                  const std::vector<double>& volume, const std::vector<int>& point_material,
                                  const std::vector<Material>& materials, const EssentialBoundary& boundary) {
  const auto nodes = static_cast<std::size_t>(layout.node_count);
  StiffnessMeans means;
  means.point_begin.push_back(0);
  means.node_begin.push_back(0);

  std::vector<int> place(volume.size(), 0);
  for (std::size_t p = 0; p < layout.point.size(); ++p)
    if (layout.point[p] >= 0) place[static_cast<std::size_t>(layout.point[p])] = static_cast<int>(p);
  std::vector<std::vector<int>> points_at(nodes), rows_of(nodes);  // around a node; with it in their support
  std::vector<double> gradient_sum(volume.size(), 0);
  for (std::size_t q = 0; q < volume.size(); ++q) {
    for (const int a : point_vertices[q]) points_at[static_cast<std::size_t>(a)].push_back(static_cast<int>(q));
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) gradient_sum[q] += shape.gradN[e].norm();
  }
  WeightRow points(layout.point.size());
  for (std::size_t i = 0; i < nodes; ++i) {
    for (const int q : points_at[i]) points.add(place[q], std::abs(volume[q]));
    points.flush(means.point, means.point_weight);
    means.point_begin.push_back(static_cast<int>(means.point.size()));
  }

  std::vector<std::vector<std::pair<int, double>>> row(nodes);  // (point, its part of the node's Gershgorin row)
  for (std::size_t q = 0; q < volume.size(); ++q) {
    const double weight = std::abs(volume[q]) * materials[point_material[q]].waveModulus() * gradient_sum[q];
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e)
      row[shape.node[e]].emplace_back(static_cast<int>(q), weight * shape.gradN[e].norm());
  }
  WeightRow neighbours(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    for (const auto& [q, weight] : row[i])
      for (const int a : point_vertices[q]) neighbours.add(a, weight);
    neighbours.flush(means.node, means.node_weight);
    means.node_begin.push_back(static_cast<int>(means.node.size()));
  }

  means.bounded.assign(nodes, 0);
  for (const auto& set : boundary.sets)
    for (const int j : set.touched) means.bounded[j] = 1;
  const auto first = std::find(means.bounded.begin(), means.bounded.end(), 1);
  if (first != means.bounded.end()) means.first_bounded = static_cast<int>(first - means.bounded.begin());
  return means;
}

void squeezedModulus(const float* cofactor_norm2, const float* J, int count, float bulk, float shear, float* modulus) {
  constexpr float min_J = Material::min_isochoric_J, max_J = 8;
  for (int k = 0; k < count; ++k) {
    const float j = std::min(std::max(J[k], min_J), max_J);
    float root = 0.35F + 0.65F * j;  // J^(1/3) by Newton's iteration
    for (int round = 0; round < 4; ++round) root = (2.0F * root + j / (root * root)) / 3.0F;
    const float J23 = root * root;
    // s = J^(2/3) (1 + d) with d = sqrt(e (1 + d) / (3 + d)), e = |cof F|^2 / J^(4/3) - 3. From above, each round
    // divides the relative error by 7 or more.
    const float e = std::max(cofactor_norm2[k] / (J23 * J23) - 3.0F, 0.0F);
    float d = std::sqrt(e);
    for (int round = 0; round < 3; ++round) d = std::sqrt(e * (1.0F + d) / (3.0F + d));
    const float t = 1.0F + d, s = J23 * t;  // t^3 = s^3 / J^2
    modulus[k] = bulk * s * s + shear / J23 * (5.0F / 9.0F * (1.0F + 2.0F * t * t * t) - 1.0F / 3.0F);
  }
}

}  // namespace palpate
