#include "mechanics/local_mass.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

namespace palpate {
namespace {

/// Entries of a row below this part of its largest are left out: a mean is then over some 16 nodes.
constexpr double least_weight = 0.15;

/// One row of weights, summed by key.
class WeightRow {
 public:
  explicit WeightRow(std::size_t count) : weight_(count, 0) {}
  void add(int key, double weight) {
    if (weight_[static_cast<std::size_t>(key)] == 0) keys_.push_back(key);
    weight_[static_cast<std::size_t>(key)] += weight;
  }
  /// Appends the keys, ascending, with weights of sum 1, and forgets them.
  void flush(StiffnessMeans::Rows& rows) {
    std::sort(keys_.begin(), keys_.end());
    double largest = 0, sum = 0;
    const auto of = [&](int key) -> double& { return weight_[static_cast<std::size_t>(key)]; };
    for (const int key : keys_) largest = std::max(largest, of(key));
    for (const int key : keys_)
      if (of(key) >= least_weight * largest) sum += of(key);
    for (const int key : keys_) {
      if (of(key) >= least_weight * largest) {
        rows.index.push_back(key);
        rows.weight.push_back(static_cast<float>(of(key) / sum));
      }
      of(key) = 0;
    }
    rows.begin.push_back(static_cast<int>(rows.index.size()));
    keys_.clear();
  }

 private:
  std::vector<double> weight_;
  std::vector<int> keys_;
};

/// What the rows of each group of nodes have in them, `per` entries of an index being one.
StiffnessMeans::Lists listsOf(const StiffnessMeans::Rows& rows, int per) {
  StiffnessMeans::Lists lists;
  const int count = static_cast<int>(rows.begin.size()) - 1;
  std::vector<std::int32_t> all;
  for (int first = 0; first < count; first += StiffnessMeans::group_size) {
    const int last = std::min(first + StiffnessMeans::group_size, count);
    all.clear();
    for (int e = rows.begin[first]; e < rows.begin[last]; ++e) all.push_back(rows.index[e] / per);
    std::sort(all.begin(), all.end());
    lists.index.insert(lists.index.end(), all.begin(), std::unique(all.begin(), all.end()));
    lists.begin.push_back(static_cast<int>(lists.index.size()));
  }
  return lists;
}

}  // namespace

float StiffnessMeans::Rows::mean(int row, const float* values) const {
  float sum[4] = {};  // so that the additions overlap; their order is fixed
  int e = begin[row];
  const int end = begin[row + 1];
  for (; e + 4 <= end; e += 4)
    for (int k = 0; k < 4; ++k) sum[k] += weight[e + k] * values[index[e + k]];
  for (; e < end; ++e) sum[0] += weight[e] * values[index[e]];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

StiffnessMeans makeStiffnessMeans(const KernelLayout& layout, const ShapeTable& shape,
                                  const std::vector<std::array<int, 4>>& point_vertices,
                                  const std::vector<double>& volume, const std::vector<int>& point_material,
                                  const std::vector<Material>& materials, const EssentialBoundary& boundary) {
  const auto nodes = static_cast<std::size_t>(layout.node_count);
  StiffnessMeans means;
  std::vector<int> place(volume.size(), 0);
  for (std::size_t p = 0; p < layout.point.size(); ++p)
    if (layout.point[p] >= 0) place[static_cast<std::size_t>(layout.point[p])] = static_cast<int>(p);
  std::vector<std::vector<int>> points_at(nodes);  // around a node
  for (std::size_t q = 0; q < volume.size(); ++q)
    for (const int a : point_vertices[q]) points_at[static_cast<std::size_t>(a)].push_back(static_cast<int>(q));
  WeightRow points(layout.point.size());
  for (std::size_t i = 0; i < nodes; ++i) {
    for (const int q : points_at[i]) points.add(place[q], std::abs(volume[q]));
    points.flush(means.points);
  }

  std::vector<int> row_begin(nodes + 1, 0);
  for (const int i : shape.node) ++row_begin[static_cast<std::size_t>(i) + 1];
  std::partial_sum(row_begin.begin(), row_begin.end(), row_begin.begin());
  std::vector<std::pair<int, double>> row(shape.node.size());  // (point, its part of the node's Gershgorin row) by node
  std::vector<int> next(row_begin.begin(), row_begin.end() - 1);
  std::vector<double> norm;  // 1/m
  for (std::size_t q = 0; q < volume.size(); ++q) {
    norm.clear();
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) norm.push_back(shape.gradN[e].norm());
    const double weight = std::abs(volume[q]) * materials[point_material[q]].waveModulus() *
                          std::accumulate(norm.begin(), norm.end(), 0.0);
    for (std::size_t k = 0; k < norm.size(); ++k)
      row[next[shape.node[shape.begin[q] + k]]++] = {static_cast<int>(q), weight * norm[k]};
  }
  WeightRow neighbours(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    for (int e = row_begin[i]; e < row_begin[i + 1]; ++e)
      for (const int a : point_vertices[row[e].first]) neighbours.add(a, row[e].second);
    neighbours.flush(means.nodes);
  }
  means.batches = listsOf(means.points, 16);
  means.groups = listsOf(means.nodes, StiffnessMeans::group_size);

  means.bounded.assign(nodes, 0);
  for (const auto& set : boundary.sets)
    for (const int j : set.touched) means.bounded[j] = 1;
  const auto first = std::find(means.bounded.begin(), means.bounded.end(), 1);
  if (first != means.bounded.end()) means.first_bounded = static_cast<int>(first - means.bounded.begin());
  return means;
}

bool hardlySqueezed(const float* cofactor_norm2, const float* J) {
  // |cof F|^2 / J^(4/3) - 3 <= 0.01, J within 3 %: s^2 <= 1.17
  int above = 0;
  for (int k = 0; k < 16; ++k) {
    const float change = J[k] - 1.0F;
    above += static_cast<int>(!(cofactor_norm2[k] - 3.0F - 4.0F * change <= 0.01F)) |
             static_cast<int>(!(change * change <= 9e-4F));
  }
  return above == 0;
}

void squeezedModulus(const float* cofactor_norm2, const float* J, const float* squeeze, const float* other,
                     float* modulus) {
  constexpr int n = 16;
  constexpr float min_J = Material::min_isochoric_J, max_J = 8;
  float j[n], root[n], e[n], d[n];  // one short loop for each line: they become vectors
  for (int k = 0; k < n; ++k) j[k] = J[k] > min_J ? J[k] : min_J;
  for (int k = 0; k < n; ++k) j[k] = j[k] < max_J ? j[k] : max_J;
  // J^(1/3): a third of the exponent, within 4 %, then Newton's iteration.
  for (int k = 0; k < n; ++k) root[k] = std::bit_cast<float>(std::bit_cast<std::int32_t>(j[k]) / 3 + 0x2a5137a0);
  for (int round = 0; round < 2; ++round)
    for (int k = 0; k < n; ++k) root[k] = (2.0F / 3.0F) * root[k] + j[k] / (3.0F * root[k] * root[k]);
  // s = J^(2/3) (1 + d) with d = sqrt(e (1 + d) / (3 + d)), e = |cof F|^2 / J^(4/3) - 3. From above, each round divides
  // the relative error by 7 or more.
  for (int k = 0; k < n; ++k) root[k] *= root[k];  // J^(2/3)
  for (int k = 0; k < n; ++k) e[k] = cofactor_norm2[k] / (root[k] * root[k]) - 3.0F;
  for (int k = 0; k < n; ++k) e[k] = e[k] > 0.0F ? e[k] : 0.0F;
  for (int k = 0; k < n; ++k) d[k] = std::sqrt(e[k]);
  for (int round = 0; round < 2; ++round)
    for (int k = 0; k < n; ++k) d[k] = std::sqrt(e[k] * (1.0F + d[k]) / (3.0F + d[k]));
  for (int k = 0; k < n; ++k) {
    const float s = root[k] * (1.0F + d[k]);
    modulus[k] = squeeze[k] * s * s + other[k];
  }
}

}  // namespace palpate
