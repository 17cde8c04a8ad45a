#include "realtime/loop/slide_watch.h"

#include <Eigen/SVD>
#include <cmath>

#include "simulation/free_axes.h"

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

}  // namespace

SlideWatch::SlideWatch(const Model& model)
    : needed_(std::llround(seconds * model.scene.rate_hz)), free_(freeAxes(model)) {
  if (free_.isZero(0)) return;
  Vec3 low = model.X.front(), high = low, mean = Vec3::Zero();
  for (const Vec3& X : model.X) {
    low = low.cwiseMin(X);
    high = high.cwiseMax(X);
    mean += X / static_cast<double>(model.X.size());
  }
  far_ = away * (high - low).norm();
  for (const Vec3& X : model.X) centred_.push_back(X - mean);
}

bool SlideWatch::hasLeft(const State& state) const {
  // What slides, slides as a whole: any node tells.
  if (toVec3(state.u.front()).cwiseProduct(free_).norm() > far_) return true;
  Mat3 moments = Mat3::Zero();
  for (std::size_t i = 0; i < centred_.size(); ++i)
    moments += (centred_[i] + toVec3(state.u[i])) * centred_[i].transpose();
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
