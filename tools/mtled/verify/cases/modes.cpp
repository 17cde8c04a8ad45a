#include <Eigen/Eigenvalues>
#include <cmath>

#include "discretization/cells/adaptive_quadrature.h"
#include "discretization/cells/cell_division.h"
#include "discretization/cells/delaunay.h"
#include "mtled/verify/cases/cases.h"
#include "setup/body_points.h"

namespace palpate::tools {
namespace {

using Matrix = Eigen::MatrixXd;

/// Adds V (p B_tr B_tr^T + mu (H : H + H : H^T - 2/3 tr^2)) of one point, H being the gradient of a displacement.
void addIsochoric(const ShapeTable& shape, int q, double weight, Matrix& K) {
  const int begin = shape.begin[q], end = shape.begin[q + 1];
  for (int e = begin; e < end; ++e)
    for (int f = begin; f < end; ++f) {
      const Vec3& a = shape.gradN[e];
      const Vec3& b = shape.gradN[f];
      K.block<3, 3>(3 * shape.node[e], 3 * shape.node[f]) +=
          weight * (a.dot(b) * Mat3::Identity() + b * a.transpose() - 2.0 / 3 * a * b.transpose());
    }
}

/// Stiffness at rest, as the scheme of the model sees it.
Matrix stiffness(const Model& model) {
  const int n = 3 * model.nodeCount();
  const Material& material = model.materials[0];
  Matrix K = Matrix::Zero(n, n);
  Matrix trace = Matrix::Zero(n, model.patches.empty() ? model.pointCount() : model.nodeCount());
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(trace.cols());
  for (int q = 0; q < model.pointCount(); ++q) {
    addIsochoric(model.point_shape, q, model.point_volume[q] * material.shear_modulus, K);
    for (int e = model.point_shape.begin[q]; e < model.point_shape.begin[q + 1]; ++e) {
      const int row = 3 * model.point_shape.node[e];
      const Vec3& b = model.point_shape.gradN[e];
      if (model.patches.empty()) {
        trace.block<3, 1>(row, q) += b;
        weight[q] = model.point_volume[q] * material.bulk_modulus;
        continue;
      }
      for (int a = 0; a < 4; ++a) {
        const int patch = model.patches.node[q][a];
        trace.block<3, 1>(row, patch) +=
            model.point_volume[q] * model.patches.weight[q][a] / model.patches.volume[patch] * b;
        weight[patch] = model.patches.volume[patch] * model.patches.bulk_modulus[patch];
      }
    }
  }
  return K + trace * weight.asDiagonal() * trace.transpose();
}

/// Of the same shape functions: mu int |grad u|^2 with 32 points a cell, exact enough for any mode.
Matrix gradientNorm(const Model& model) {
  IntegrationPoints fine;
  const CellRule rule = cellRule(4);
  for (std::size_t c = 0; c < model.cells.size(); ++c) {
    std::array<Vec3, 4> corners;
    for (int v = 0; v < 4; ++v) corners[v] = model.X[model.cells[c][v]];
    const double volume = tetrahedronVolume(corners[0], corners[1], corners[2], corners[3]);
    std::array<Corners, 8> children;
    divideCell(corners, 8, 0, children);
    for (const auto& child : children) rule.append(child, volume / 8, static_cast<int>(c), fine);
  }
  const ShapeTable shape = shapeAt(model, fine.X);
  const int n = model.nodeCount();
  Matrix scalar = Matrix::Zero(n, n);
  for (int q = 0; q < shape.rowCount(); ++q)
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e)
      for (int f = shape.begin[q]; f < shape.begin[q + 1]; ++f)
        scalar(shape.node[e], shape.node[f]) +=
            fine.volume[q] * model.materials[0].shear_modulus * shape.gradN[e].dot(shape.gradN[f]);
  Matrix G = Matrix::Zero(3 * n, 3 * n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int c = 0; c < 3; ++c) G(3 * i + c, 3 * j + c) = scalar(i, j);
  return G;
}

}  // namespace

std::vector<double> energyShares(const Model& model) {
  const int n = model.nodeCount();
  // Rigid motions get the share 1000 in both.
  Matrix rigid = Matrix::Zero(3 * n, 6);
  for (int i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c) {
      rigid(3 * i + c, c) = 1;
      rigid.block<3, 1>(3 * i, 3 + c) = Vec3::Unit(c).cross(model.X[i]);
    }
  // Rotations have a gradient: the norm takes its symmetric counterpart out by the projection.
  Eigen::HouseholderQR<Matrix> qr(rigid);
  const Matrix Q = qr.householderQ() * Matrix::Identity(3 * n, 6);
  const Matrix P = Matrix::Identity(3 * n, 3 * n) - Q * Q.transpose();
  const Matrix G0 = P * gradientNorm(model) * P, K0 = P * stiffness(model) * P;
  const double scale = G0.trace() / (3 * n);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix> eigen(K0 + 1e3 * scale * Q * Q.transpose(),
                                                               G0 + scale * Q * Q.transpose(), Eigen::EigenvaluesOnly);
  const auto& all = eigen.eigenvalues();  // ascending
  return {all.data(), all.data() + (3 * n - 6)};
}

CaseResult modesCase(const CaseContext& context) {
  CaseResult result;
  result.name = "modes";
  result.title = "Zero-energy modes at one point a cell and less";
  result.reference = "The same shape functions integrated with 32 points a cell.";
  result.text =
      "A free cube of 100 mm at rest, nu 0.49. For every displacement field u that the shape functions hold, but rigid "
      "motions: the "
      "energy that the scheme sees over mu int |grad u|^2 / 2. A mode that one point a cell does not see would have a "
      "share near 0. "
      "Rotation-like fields cost little in any scheme, also with 4 points a cell.";
  constexpr double spacing = 0.024;
  struct Row {
    const char* name;
    Variant variant;
    int points_per_cell;
    double cells_per_point = 1;
  };
  const Row rows[] = {{"1 point, as the paper", variants[0], 1},         {"1 point, node patches", variants[1], 1},
                      {"1 point, consistent gradients", variants[2], 1}, {"1 point, both", variants[3], 1},
                      {"1.5 cells a point, both", variants[3], 1, 1.5},  {"2 cells a point, both", variants[3], 1, 2},
                      {"4 points, as the paper", variants[0], 4}};
  ResultTable table{"Share of the energy that is seen: the poorest modes",
                    {"scheme", "nodes", "points", "1st", "2nd", "5th", "20th"},
                    {},
                    ""};
  double poorest_both = NAN, poorest_pairs = NAN, poorest_four = NAN;
  int done = 0;
  for (const Row& row : rows) {
    context.progress(done++ / 7.0, row.name);
    Scene scene = caseScene(3000, 0.49);
    scene.name = "modes";
    scene.organs[0].solid = OrganSpec::Solid::Box;
    scene.organs[0].size = Vec3(0.1, 0.1, 0.1);
    scene.discretization.spacing = spacing;
    scene.tools[0].shape.radius = 0.05;
    scene.discretization.quadrature.points_per_cell = row.points_per_cell;
    scene.discretization.quadrature.cells_per_point = row.cells_per_point;
    scene.boundaries = {planeBoundary("base", Vec3::Zero(), Vec3::UnitZ())};  // a model needs one; it is not used
    apply(row.variant, scene);
    const StaticSolution s = solveCase(scene, {}, context);
    const Model& model = *s.model;
    const auto share = energyShares(model);
    table.rows.push_back({row.name, std::to_string(model.nodeCount()), std::to_string(model.pointCount()),
                          formatted(share[0]), formatted(share[1]), formatted(share[4]), formatted(share[19])});
    if (row.points_per_cell == 4)
      poorest_four = share[0];
    else if (row.cells_per_point == 2)
      poorest_pairs = share[0];
    else if (row.cells_per_point == 1 && row.variant.consistent_gradients && row.variant.node_patch_volume)
      poorest_both = share[0];
  }
  result.tables.push_back(table);
  result.bounds.push_back({"Poorest mode, 1 point, both", poorest_both, 0.1, false, "", "no mode goes unseen"});
  result.bounds.push_back(
      {"Poorest mode over that with 4 points", poorest_both / poorest_four, 0.5, false, "", "nothing soft appears"});
  result.bounds.push_back({"Poorest mode, 2 cells a point, over that with 4 points", poorest_pairs / poorest_four, 0.5,
                           false, "", "nor when pairs share a point"});
  return result;
}

}  // namespace palpate::tools
