#include "discretization/gradients/gradient_energy.h"

#include <limits>

namespace palpate {

Vec3 GradientEnergy::operator()(const Vec3& x) {
  neighbours_->find(x, support_);
  support_X_.clear();
  support_radius_.clear();
  for (int j : support_) {
    support_X_.push_back((*X_)[j]);
    support_radius_.push_back((*radius_)[j]);
  }
  if (!mmls_.evaluate(x, support_X_.data(), support_radius_.data(), static_cast<int>(support_.size())) ||
      !AdmissibilityLimits{}.admit(mmls_.quality())) {
    return Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  }
  Vec3 f = Vec3::Zero();
  for (const Vec3& gradient : mmls_.gradN()) f += gradient.cwiseAbs2();
  return f;
}

}  // namespace palpate
