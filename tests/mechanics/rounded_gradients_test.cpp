#include <catch2/catch.hpp>

#include "base/input_error.h"
#include "support/kernel_forces.h"

using namespace palpate;
using namespace palpate::test;

namespace {

KernelLayout roundedLayout(const TestBody& body) {
  return makeKernelLayout(body.shape, body.point_X, body.volume, body.point_material, body.materials, body.nodeCount(),
                          {}, GradientPrecision::Int16, body.X);
}

/// Gradients of point `place` (index into layout.point) at its block's union nodes, as the kernel sees them, 1/m.
std::vector<std::pair<int, Vec3>> gradientsAt(const KernelLayout& layout, std::size_t place) {
  const std::size_t block = place / 4, p = place % 4;
  const PointBlock& q = layout.blocks[block];
  std::vector<std::pair<int, Vec3>> result;
  for (std::size_t n = 0; n < static_cast<std::size_t>(q.group_count) * 4; ++n) {
    const std::size_t at = static_cast<std::size_t>(q.tile_begin) * 4 + n;
    Vec3 g;
    for (std::size_t b = 0; b < 3; ++b) {
      const auto in = [&](std::size_t tile) { return tile * 48 + b * 16 + n % 4 * 4 + p; };
      g[b] = static_cast<double>(layout.scale[block / 4 * 48 + b * 16 + block % 4 * 4 + p]) *
             (n < 4 ? layout.gradN[in(block)] : layout.rounded_gradN[in(q.rounded_begin + n / 4 - 1)]);
    }
    result.emplace_back(layout.short_node.empty() ? layout.node[at] : layout.short_node[at], g);
  }
  return result;
}

}  // namespace

TEST_CASE("16-bit gradients keep the zero sum and the first moments to float rounding", "[kernel][rounded]") {
  const TestBody body(6, 0.1, 4);
  const auto layout = roundedLayout(body);
  double largest_change = 0;
  for (std::size_t place = 0; place < layout.point.size(); ++place) {
    const int q = layout.point[place];
    if (q < 0) continue;
    const auto gradients = gradientsAt(layout, place);
    Vec3 sum = Vec3::Zero(), rounding = Vec3::Zero();
    Mat3 moment = Mat3::Zero();
    double reach = 0;
    for (std::size_t n = 0; n < gradients.size(); ++n) {
      const Vec3 r = body.X[gradients[n].first] - body.point_X[q];
      sum += gradients[n].second;
      moment += r * gradients[n].second.transpose();
      if (n >= 4) continue;  // only the anchors' floats are rounded after the correction, by half of 2^-23
      rounding += gradients[n].second.cwiseAbs() * 0x1p-24;
      reach = std::max(reach, r.cwiseAbs().maxCoeff());
    }
    for (int b = 0; b < 3; ++b) {
      CHECK(std::abs(sum[b]) <= rounding[b] + 1e-8);  // the double table's own sums are zero to 1e-9 /m
      for (int c = 0; c < 3; ++c) CHECK(std::abs(moment(c, b) - (c == b)) <= rounding[b] * reach + 1e-9);
    }
    for (int e = body.shape.begin[q]; e < body.shape.begin[q + 1]; ++e)
      for (const auto& [node, g] : gradients)
        if (node == body.shape.node[e] && !g.isZero(0)) {
          largest_change =
              std::max(largest_change, (g - body.shape.gradN[e]).cwiseAbs().maxCoeff() * body.radius[node]);
          break;
        }
  }
  CHECK(largest_change > 1e-6);  // they are rounded
  CHECK(largest_change <
        1e-3);  // times the radius gradients are about 1: 40 errors of 1.5e-5, to an anchor twice as far
}

TEST_CASE("16-bit gradients give J of uniform deformation as exactly as float32, and forces close in any",
          "[kernel][rounded]") {
  const TestBody body(6, 0.1, 1, 1.8, 0.1, 0.2, Material::neoHookean(3000, 0.499, 1000));
  const double ratio = body.materials[0].bulk_modulus / body.materials[0].shear_modulus;
  Mat3 sheared;
  sheared << 1.1, 0.5, 0, -0.1, 0.8, 0.05, 0.3, 0, 1.2;
  const Mat3 turn = Eigen::AngleAxisd(M_PI / 2, Vec3(0, 0.6, 0.8)).toRotationMatrix();
  for (const Mat3& F : {sheared, Mat3(turn * sheared), Mat3(Vec3(2.0, 2.0, 0.25).asDiagonal())}) {
    const auto u = body.displacement(F);
    const auto exact = referenceForces(body, u);
    ForceReport report;
    const double rounded = distance(fastForces(body, u, 1, &report, {}, GradientPrecision::Int16), exact) / norm(exact);
    INFO("int16 " << rounded << ", float32 " << distance(fastForces(body, u), exact) / norm(exact));
    CHECK(rounded < 3e-5 + 1e-6 * ratio);  // spreading the forces, and the float kernel's tolerance
    CHECK(report.min_J == Approx(std::min(1.0, F.determinant())).epsilon(3e-6));  // F as exact as float's
  }
  // Not uniform: a bend whose strain varies over a support.
  const auto u = wave(body, 0.3);
  const auto exact = referenceForces(body, u);
  const double rounded = distance(fastForces(body, u, 1, nullptr, {}, GradientPrecision::Int16), exact) / norm(exact);
  INFO("int16 " << rounded);
  CHECK(rounded < 3e-5 + 1e-6 * ratio);  // see kernel_instructions_test.cpp
}

TEST_CASE("A layout with 16-bit gradients streams little more than half the bytes", "[kernel][rounded]") {
  const TestBody body(8, 0.1, 1, 1.6);
  const auto whole =
      makeKernelLayout(body.shape, body.point_X, body.volume, body.point_material, body.materials, body.nodeCount());
  const auto rounded = roundedLayout(body);
  const double bytes =
      static_cast<double>(rounded.gradN.size() * 4 + rounded.rounded_gradN.size() * 2 + rounded.scale.size() * 4);
  CHECK(bytes <
        0.62 * 4 *
            static_cast<double>(whole.gradN.size()));  // half, 1 of 22 anchors' halves and 12 B of scale per point
}

TEST_CASE("Where 16-bit gradients can't be made this is said", "[kernel][rounded]") {
  TestBody body(4, 0.1, 1);
  for (auto& x : body.X) x[2] = 0.5 * x[0];  // all in one plane
  CHECK_THROWS_AS(roundedLayout(body), InputError);
  CHECK_THROWS_AS(makeKernelLayout<double>(body.shape, body.point_X, body.volume, body.point_material, body.materials,
                                           body.nodeCount(), {}, GradientPrecision::Int16, body.X),
                  std::invalid_argument);
}
