#include "imaging/warp.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "discretization/surface/solids.h"

using namespace palpate;

namespace {

/// A field by formula on a ball, and what it does to an image by formula.
class FormulaDeformation : public Deformation {
 public:
  static constexpr double radius = 0.036;  // m
  double surfaceDistance(const Vec3& X) const override { return (X - centre()).norm() - radius; }
  Box3 box() const override { return {centre().array() - radius, centre().array() + radius}; }
  static Vec3 centre() { return {0.01, -0.02, 0.03}; }
};

class AffineField : public FormulaDeformation {
 public:
  bool at(const Vec3& X, Vec3& u, Mat3& gradient) const override {
    gradient << 0.05, 0.1, 0, -0.08, -0.04, 0.02, 0.03, 0, 0.06;
    u = gradient * X + Vec3(0.004, -0.003, 0.002);
    return true;
  }
};

/// A dent of 26.7 mm, the paper's largest displacement, from above.
class DentField : public FormulaDeformation {
 public:
  bool at(const Vec3& X, Vec3& u, Mat3& gradient) const override {
    constexpr double depth = 0.0267, width = 0.035;
    const Vec3 d = X - (centre() + Vec3(0, 0, radius));
    const double share = std::exp(-d.squaredNorm() / (2 * width * width));
    u = Vec3(0, 0, -depth * share);
    gradient = u * (-d / (width * width)).transpose();
    return true;
  }
};

/// Oblique, of 0.9 x 0.9 x 2.5 mm.
ImageGrid obliqueGrid() {
  const Mat3 turn = Eigen::AngleAxisd(0.4, Vec3(1, -1, 2).normalized()).toRotationMatrix();
  const Mat3 axes = turn * Vec3(-0.9e-3, 0.9e-3, 2.5e-3).asDiagonal();
  const std::array<int, 3> size{96, 96, 36};
  return {size, axes, FormulaDeformation::centre() - axes * Vec3(47.5, 47.5, 17.5)};
}

float imageAt(const Vec3& X) {
  return static_cast<float>(100 + 40 * std::sin(60 * X.x()) + 30 * std::cos(50 * X.y() + 1) +
                            20 * std::sin(70 * X.z()));
}

}  // namespace

TEST_CASE("An affine field and a dent are inverted on an oblique grid", "[imaging][warp]") {
  const AffineField affine;
  const DentField dent;
  for (const Deformation* whole : {static_cast<const Deformation*>(&affine), static_cast<const Deformation*>(&dent)}) {
    const SampledDeformation sampled(*whole, 2.5e-3);
    const BackwardField field = backwardField(sampled, InverseDeformation(sampled), obliqueGrid());
    REQUIRE(countOf(field.body) > 10000);
    const WarpCheck check = checkField(field, *whole, InverseDeformation(sampled), 2000);
    CHECK(check.count > 1950);
    CHECK(check.mean < 0.02e-3);
    CHECK(check.max < 0.1e-3);
    CHECK(check.round_trip < 0.1e-3);
    // Forward after inverse on the sampled field itself: what Newton's method leaves.
    double worst = 0;
    for (int k = 0; k < 36; k += 3)
      for (int j = 0; j < 96; j += 3)
        for (int i = 0; i < 96; i += 3)
          if (const std::size_t v = obliqueGrid().at(i, j, k); field.body.value[v]) {
            const Vec3 x = obliqueGrid().worldOf(i, j, k), X = x + field.to_rest.value[v].cast<double>();
            Vec3 u;
            Mat3 gradient;
            REQUIRE(sampled.at(X, u, gradient));
            worst = std::max(worst, (X + u - x).norm());
          }
    CHECK(worst < 1e-6);  // 0.001 mm; float32 leaves 1e-9 m
  }
}

namespace {

/// A narrow bump of 3 mm, which samples 2.5 mm apart miss by up to 0.1 mm.
class BumpField : public FormulaDeformation {
 public:
  bool at(const Vec3& X, Vec3& u, Mat3& gradient) const override {
    constexpr double height = 3e-3, width = 4.5e-3;
    const Vec3 d = X - (centre() + Vec3(0, 0, 0.8 * radius));
    u = Vec3(0, 0, -height * std::exp(-d.squaredNorm() / (2 * width * width)));
    gradient = u * (-d / (width * width)).transpose();
    return true;
  }
};

}  // namespace

TEST_CASE("Where samples are too far apart, the field itself is asked", "[imaging][warp]") {
  const BumpField bump;
  const SampledDeformation sampled(bump, 2.5e-3);
  const BackwardField field = backwardField(sampled, InverseDeformation(sampled), obliqueGrid());
  const VectorImage forward = forwardField(sampled, obliqueGrid());
  double by_samples = 0, back = 0, away = 0;
  int rough = 0;
  for (int k = 0; k < 36; ++k)
    for (int j = 0; j < 96; ++j)
      for (int i = 0; i < 96; ++i) {
        const std::size_t v = obliqueGrid().at(i, j, k);
        const Vec3 x = obliqueGrid().worldOf(i, j, k);
        Vec3 u, other;
        Mat3 gradient;
        if (field.body.value[v]) {
          const Vec3 X = x + field.to_rest.value[v].cast<double>();
          bump.at(X, u, gradient);
          back = std::max(back, (X + u - x).norm());
        }
        if (bump.surfaceDistance(x) > -0.2e-3) continue;  // there the samples may say outside
        rough += sampled.isRough(x);
        bump.at(x, u, gradient);
        REQUIRE(sampled.at(x, other, gradient));
        by_samples = std::max(by_samples, (other - u).norm());
        away = std::max(away, (forward.value[v].cast<double>() - u).norm());
      }
  CHECK(by_samples > 0.02e-3);  // or this test would say nothing
  CHECK(back < 0.015e-3);       // at single voxels
  CHECK(away < 0.01e-3);
  CHECK(rough > 50);
  CHECK(rough < 20000);  // of the ball's 96,000 voxels
}

TEST_CASE("A warped image is what was there, and vacated space is empty", "[imaging][warp]") {
  const DentField dent;
  const SampledDeformation sampled(dent, 2.5e-3);
  const ImageGrid grid = obliqueGrid();
  Image image(grid);
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) image(i, j, k) = imageAt(grid.worldOf(i, j, k));
  const BackwardField field = backwardField(sampled, InverseDeformation(sampled), grid);
  const Image result = warped(image, field, Between::Cubic, -1);
  const Mask valid = validOf(grid, field);
  double worst = 0;
  int empty = 0, outside = 0, changed = 0;
  for (int k = 1; k + 1 < grid.size[2]; ++k)
    for (int j = 1; j + 1 < grid.size[1]; ++j)
      for (int i = 1; i + 1 < grid.size[0]; ++i) {
        const std::size_t v = grid.at(i, j, k);
        const Vec3 x = grid.worldOf(i, j, k);
        if (field.body.value[v]) {
          worst = std::max(worst, std::abs(static_cast<double>(result.value[v]) -
                                           static_cast<double>(imageAt(x + field.to_rest.value[v].cast<double>()))));
        } else if (field.vacated.value[v]) {
          ++empty;
          changed += result.value[v] != -1 || valid.value[v] != 0;
        } else {
          ++outside;
          changed += std::abs(result.value[v] - image.value[v]) > 1e-3F;
        }
      }
  CHECK(worst < 1);  // of a range of 180; cubic between voxels of up to 2.5 mm
  CHECK(empty > 100);
  CHECK(outside > 1000);
  CHECK(changed == 0);
}

TEST_CASE("The jacobian of an affine field is its determinant", "[imaging][warp]") {
  const AffineField affine;
  const SampledDeformation sampled(affine, 4e-3);
  const BackwardField field = backwardField(sampled, InverseDeformation(sampled), obliqueGrid());
  Vec3 u;
  Mat3 gradient;
  affine.at(Vec3::Zero(), u, gradient);
  const double expected = (Mat3::Identity() + gradient).determinant();
  double worst = 0;
  for (std::size_t v = 0; v < field.body.value.size(); ++v)
    if (field.body.value[v]) worst = std::max(worst, std::abs(static_cast<double>(field.jacobian.value[v]) - expected));
  CHECK(worst < 1e-4);  // float32 samples, 4e-9 m of 4 mm
}

TEST_CASE("Values between voxels: cubic is exact for quadratics, labels stay labels", "[imaging][image]") {
  Image image(ImageGrid({7, 6, 5}, Mat3::Identity() * 1e-3, Vec3::Zero()));
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 7; ++i) image(i, j, k) = static_cast<float>(i * i + 3 * j + 2 * k);
  const Vec3 at(3.3, 2.6, 1.7);
  CHECK(cubicValue(image, at) == Approx(3.3 * 3.3 + 3 * 2.6 + 2 * 1.7).epsilon(1e-5));
  CHECK(linearValue(image, Vec3(3, 2.6, 1.7)) == Approx(9 + 3 * 2.6 + 2 * 1.7).epsilon(1e-5));
  CHECK(nearestValue(image, at) == 9 + 3 * 3 + 2 * 2);
  CHECK(cubicValue(image, Vec3(-3, 0, 0)) == image(0, 0, 0));
}
