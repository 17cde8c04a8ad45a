#include "simulation/limit_compression.h"

#include <algorithm>

#include "base/float4.h"

namespace palpate {
namespace {

constexpr double kept_volume = 0.5;  // of a squeezed point's volume
constexpr int most_sweeps = 24;
constexpr std::size_t most_points = 2048;  // squeezed at a time; more is flooded tissue, which the watchdog puts back

Mat3 cofactorOf(const Mat3& F) {
  Mat3 cof;
  cof << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return cof;
}

/// sum_i field_i (x) gradN_i
Mat3 gradientOf(const ShapeTable& shape, int row, const Float4* field) {
  Mat3 sum = Mat3::Zero();
  for (int e = shape.begin[row]; e < shape.begin[row + 1]; ++e)
    sum += toVec3(field[shape.node[e]]) * shape.gradN[e].transpose();
  return sum;
}

/// Gives a point the impulse that keeps its volume. @return whether it needed one
bool keepVolume(const ShapeTable& shape, int row, const Mat3& F, double allowed, const float* inverse_mass,
                Float4* du) {
  const Mat3 dF = gradientOf(shape, row, du);
  const double lacking = allowed - (F + dF).determinant();
  if (!(lacking > 0)) return false;
  const Mat3 cof = cofactorOf(F + 0.5 * dF);  // J(F + dF) - J(F) is cof : dF, but for the third order
  double mobility = 0;
  for (int e = shape.begin[row]; e < shape.begin[row + 1]; ++e)
    mobility += static_cast<double>(inverse_mass[shape.node[e]]) * (cof * shape.gradN[e]).squaredNorm();
  if (!(mobility > 0)) return false;
  // Not beyond what undoes the squeeze.
  const double squeeze = std::max(0.0, -cof.cwiseProduct(dF).sum()), impulse = std::min(lacking, squeeze) / mobility;
  for (int e = shape.begin[row]; e < shape.begin[row + 1]; ++e) {
    const int i = shape.node[e];
    addScaled(du[i], inverse_mass[i], toFloat4(Vec3(impulse * (cof * shape.gradN[e]))));
  }
  return true;
}

}  // namespace

CompressionLimit::CompressionLimit(const Model& model)
    : squeezed_(std::min(most_points, static_cast<std::size_t>(model.pointCount()))) {}

void CompressionLimit::apply(const Model& model, const AlignedVector<float>& J, float least, const StepMasses& masses,
                             State& state) {
  if (!(least < watched_J)) return;
  const ShapeTable& shape = model.point_shape;
  std::size_t count = 0;
  for (std::size_t place = 0; place < J.size() && count < squeezed_.size(); ++place) {
    if (!(J[place] < watched_J) || model.kernel.point[place] < 0) continue;
    Point& point = squeezed_[count++];
    point.row = model.kernel.point[place];
    point.F = Mat3::Identity() + gradientOf(shape, point.row, state.u.data());
    const double now = point.F.determinant();
    point.allowed = std::min(std::max(kept_volume * now, least_J), now);
  }
  bool corrected = true;
  for (int sweep = 0; sweep < most_sweeps && corrected; ++sweep) {
    corrected = false;
    for (std::size_t k = 0; k < count; ++k) {
      const Point& point = squeezed_[sweep % 2 == 0 ? k : count - 1 - k];
      corrected |= keepVolume(shape, point.row, point.F, point.allowed, masses.inverse, state.du.data());
    }
  }
}

}  // namespace palpate
