#include "app/run/certified_watch.h"

#include <algorithm>
#include <utility>

namespace palpate::app {

namespace {
constexpr double share_beside = 0.25;  // of the touching radius
}

CertifiedWatch::CertifiedWatch(Certificate certificate, double touch_radius)
    : certificate_(std::move(certificate)), beside_(share_beside * touch_radius) {}

void CertifiedWatch::add(const ForceSample& sample) {
  const bool touches = sample.contact_count > 0;
  strayed_ = touches && (strayed_ || !certificate_.isOnWay(sample.tool_pose, sample.advance_m, beside_));
  const bool held = turns_.size() % 2 == 1;
  if ((touches && !strayed_) != held) turns_.push_back(sample.tick);
}

bool CertifiedWatch::holds(std::int64_t tick) const {
  return (std::upper_bound(turns_.begin(), turns_.end(), tick) - turns_.begin()) % 2 == 1;
}

}  // namespace palpate::app
