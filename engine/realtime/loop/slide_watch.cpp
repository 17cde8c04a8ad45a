#include "realtime/loop/slide_watch.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "setup/free_axes.h"

namespace palpate {
namespace {

/// Cosine of the angle of the rotation that fits the nodes' motion best, in the sense of least squares (Kabsch 1976).
/// @param moments  sum of x X^T over the nodes, X about its mean
double cosineOfTurn(const Mat3& moments) {
  const Eigen::JacobiSVD<Mat3> svd(moments, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 proper = Mat3::Identity();
  proper(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return ((svd.matrixU() * proper * svd.matrixV().transpose()).trace() - 1) / 2;
}

/// What lies loose on rigid bodies may be pushed anywhere, and what slides off them has slid off.
bool isLoose(const Model& model) {
  return std::all_of(model.imposed.begin(), model.imposed.end(), [](std::uint8_t axes) { return axes == 0; });
}

}  // namespace

SlideWatch::SlideWatch(const Model& model)
    : needed_(std::llround(seconds * model.scene.rate_hz)),
      free_(isLoose(model) ? Vec3(Vec3::Zero()) : freeAxes(model)),
      model_(&model) {
  if (free_.isZero(0)) return;
  Vec3 low = model.X.front(), high = low;
  for (const Vec3& X : model.X) {
    low = low.cwiseMin(X);
    high = high.cwiseMax(X);
  }
  far_ = away * (high - low).norm();
}

bool SlideWatch::hasLeft(const State& state) const {
  // What slides, slides as a whole: any node tells.
  if (toVec3(state.u.front()).cwiseProduct(free_).norm() > far_) return true;
  const std::vector<Vec3>& X = model_->X;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& x : X) mean += x / static_cast<double>(X.size());
  Mat3 moments = Mat3::Zero();
  for (std::size_t i = 0; i < X.size(); ++i) moments += (X[i] - mean + toVec3(state.u[i])) * (X[i] - mean).transpose();
  return cosineOfTurn(moments) < 0;
}

bool SlideWatch::update(const State& state, const StepReport& report, bool pulled) {
  if (free_.isZero(0)) return false;
  memory_.ticks = !pulled && !report.isTouched() ? memory_.ticks + 1 : 0;
  if (memory_.ticks < needed_) return false;
  memory_ = {};
  return hasLeft(state);
}

}  // namespace palpate
