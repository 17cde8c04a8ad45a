#include "discretization/gradients/gradient_system.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "base/parallel_for.h"

namespace palpate {

void NodeMatrix::apply(const NodeField& x, NodeField& y) const {
  parallelFor(rows(), [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      double sum[3] = {0, 0, 0};
      for (std::size_t k = begin[i]; k < begin[i + 1]; ++k) {
        const double* at = x.data() + 3 * static_cast<std::size_t>(column[k]);
        for (int c = 0; c < 3; ++c) sum[c] += value[k] * at[c];
      }
      for (int c = 0; c < 3; ++c) y(i, c) = sum[c];
    }
  });
}

GradientSystem::GradientSystem(const ShapeTable& shape, const NodeEntries& entries, const std::vector<Vec3>& point_X,
                               const std::vector<double>& volume, const std::vector<Vec3>& X)
    : shape_(shape), entries_(entries), volume_(volume), g_(shape.node.size()) {
  parallelFor(shape.rowCount(), [&](int first, int last) {
    for (int q = first; q < last; ++q) {
      double R = 0;
      for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) R = std::max(R, (X[shape.node[e]] - point_X[q]).norm());
      Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
      for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) {
        g_[e] << 1, (X[shape.node[e]] - point_X[q]) / R;
        M += g_[e] * g_[e].transpose();
      }
      const Eigen::LLT<Eigen::Matrix4d> factor(M);  // positive: the support is admissible
      for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) factor.matrixL().solveInPlace(g_[e]);
    }
  });
}

NodeMatrix GradientSystem::matrix() const {
  const int nodes = entries_.nodeCount();
  struct Row {
    std::vector<int> column;
    std::vector<double> value;
  };
  std::vector<Row> rows(nodes);  // the upper half, with the diagonal
  parallelFor(nodes, [&](int first, int last) {
    std::vector<double> sum(nodes, 0);
    std::vector<char> touched(nodes, 0);
    for (int i = first; i < last; ++i) {
      std::vector<int>& column = rows[i].column;
      for (int k = entries_.begin[i]; k < entries_.begin[i + 1]; ++k) {
        const int q = entries_.point[k], own = entries_.entry[k];
        const Eigen::Vector4d g = volume_[q] * g_[own];
        sum[i] += volume_[q];
        for (int e = own; e < shape_.begin[q + 1]; ++e) {  // a support's nodes ascend
          const int j = shape_.node[e];
          if (!touched[j]) {
            touched[j] = 1;
            column.push_back(j);
          }
          sum[j] -= g.dot(g_[e]);
        }
      }
      std::sort(column.begin(), column.end());
      rows[i].value.reserve(column.size());
      for (const int j : column) {
        rows[i].value.push_back(sum[j]);
        sum[j] = 0;
        touched[j] = 0;
      }
    }
  });
  std::vector<std::size_t> lower(nodes, 0);  // entries left of the diagonal
  for (int i = 0; i < nodes; ++i)
    for (const int j : rows[i].column) lower[j] += j > i;
  NodeMatrix A;
  A.begin.assign(1, 0);
  for (int i = 0; i < nodes; ++i) A.begin.push_back(A.begin.back() + lower[i] + rows[i].column.size());
  A.column.resize(A.begin.back());
  A.value.resize(A.begin.back());
  std::vector<std::size_t> next(A.begin.begin(), A.begin.end() - 1);
  for (int i = 0; i < nodes; ++i) {  // ascending, so that each row's lower half ascends, too
    for (std::size_t k = 0; k < rows[i].column.size(); ++k) {
      const int j = rows[i].column[k];
      A.column[next[i]] = j;
      A.value[next[i]++] = rows[i].value[k];
      if (j == i) continue;
      A.column[next[j]] = i;
      A.value[next[j]++] = rows[i].value[k];
    }
    rows[i] = {};
  }
  return A;
}

void GradientSystem::correct(const NodeField& lambda, std::vector<Vec3>& gradN) const {
  parallelFor(shape_.rowCount(), [&](int first, int last) {
    for (int q = first; q < last; ++q) {
      Eigen::Matrix<double, 4, 3> sum = Eigen::Matrix<double, 4, 3>::Zero();
      for (int e = shape_.begin[q]; e < shape_.begin[q + 1]; ++e) sum += g_[e] * lambda.row(shape_.node[e]);
      for (int e = shape_.begin[q]; e < shape_.begin[q + 1]; ++e)
        gradN[e] += (lambda.row(shape_.node[e]) - g_[e].transpose() * sum).transpose();
    }
  });
}

}  // namespace palpate
