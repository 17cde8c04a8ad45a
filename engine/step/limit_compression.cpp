#include "step/limit_compression.h"

#include <algorithm>

#include "base/float4.h"
#include "step/follow_stiffness.h"

namespace palpate {
namespace {

constexpr double kept_volume = 0.5;  // of a squeezed point's volume
constexpr int most_sweeps = 24;
constexpr std::size_t most_points = 2048;  // at a time; more are doubted (Doubt::Inverted)

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
    : steepest2_(model.X.size(), 0),
      way2_(model.X.size(), 0),
      watched_(model.kernel.point.size(), 0),
      squeezed_(std::min(most_points, static_cast<std::size_t>(model.pointCount()))) {
  const ShapeTable& shape = model.point_shape;
  for (std::size_t e = 0; e < shape.node.size(); ++e) {
    float& steepest2 = steepest2_[shape.node[e]];
    steepest2 = std::max(steepest2, static_cast<float>(shape.gradN[e].squaredNorm()));
  }
}

/// The largest of way2_.
float CompressionLimit::findWays(const AlignedVector<Float4>& du) {
  float furthest = 0;
  for (std::size_t i = 0; i < way2_.size(); ++i) {
    const Float4& d = du[i];
    way2_[i] = (d.x * d.x + d.y * d.y + d.z * d.z) * steepest2_[i];
    furthest = std::max(furthest, way2_[i]);
  }
  return furthest;
}

bool CompressionLimit::isWatched(const Model& model, const KernelScratch& kernel, std::size_t place, double furthest,
                                 const State& state) const {
  const int row = model.kernel.point[place];
  if (row < 0) return false;
  const float J = kernel.J[place];
  if (J < watched_J) return true;
  const ShapeTable& shape = model.point_shape;
  const float flatness = kernel.cof2[place] / (J * J);  // |F^-1|^2, 3 at rest
  const float far_enough = static_cast<float>(far * far) / flatness;
  if (furthest <= static_cast<double>(far_enough) ||
      std::none_of(shape.node.begin() + shape.begin[row], shape.node.begin() + shape.begin[row + 1],
                   [&](int i) { return way2_[i] > far_enough; }))
    return false;
  // J(F + dF) / J = det(I + F^-1 dF) is above 3/4 where |F^-1|^2 |dF|^2 is below 1/40.
  const Mat3 dF = gradientOf(shape, row, state.du.data());
  if (dF.squaredNorm() * static_cast<double>(flatness) < 1.0 / 40) return false;
  // Where it goes half the way that is allowed: its neighbours' impulses may bring it the rest.
  const Mat3 F = Mat3::Identity() + gradientOf(shape, row, state.u.data());
  return (F + dF).determinant() < 0.5 * (1 + kept_volume) * F.determinant();
}

void CompressionLimit::apply(const Model& model, const KernelScratch& kernel, const ForceReport& forces,
                             const StepMasses& masses, State& state, SpinTeam& team) {
  const double furthest = findWays(state.du), least = forces.min_J;
  if (!(least < static_cast<double>(watched_J)) && furthest * forces.max_cof2 < far * far * least * least) return;
  constexpr int parts = 8;
  shareRows(team, parts, watched_.size(), [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) watched_[p] = isWatched(model, kernel, p, furthest, state) ? 1 : 0;
  });
  const ShapeTable& shape = model.point_shape;
  std::size_t count = 0;
  for (std::size_t place = 0; place < watched_.size() && count < squeezed_.size(); ++place) {
    if (watched_[place] == 0) continue;
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
