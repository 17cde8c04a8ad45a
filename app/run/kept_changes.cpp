#include "app/run/kept_changes.h"

namespace palpate::app {

void KeptChanges::add(const TimedRequest& change) {
  if (overflowed_) return;
  if (change.request.kind != Request::Kind::MoveTool) {
    others_.push_back({poses_.size(), change});
    return;
  }
  poses_.push_back({change.tick, change.request.pose, change.request.value});
  overflowed_ = poses_.size() > most_poses;
}

std::vector<TimedRequest> KeptChanges::before(std::int64_t end) const {
  std::vector<TimedRequest> all;
  std::size_t next = 0;
  const auto addOthers = [&](std::size_t poses) {
    for (; next < others_.size() && others_[next].after <= poses; ++next) {
      const TimedRequest& change = others_[next].change;
      if (change.tick < end || (change.tick == end && change.request.isSaid())) all.push_back(change);
    }
  };
  for (std::size_t k = 0; k < poses_.size(); ++k) {
    addOthers(k);
    if (poses_[k].tick < end) all.push_back({poses_[k].tick, Request::moveTool(poses_[k].pose, poses_[k].value)});
  }
  addOthers(poses_.size());
  return all;
}

}  // namespace palpate::app
