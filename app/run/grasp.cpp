#include "app/run/grasp.h"

#include <algorithm>

namespace palpate::app {

std::vector<Request> Grasp::next(const Snapshot& snapshot, ToolHand& hand) {
  constexpr double closer = 1e-4;  // m: less is no closing
  const double now = snapshot.force.time_s, opening = snapshot.tools.tool[0].opening;
  if (done_) return {};
  if (begin_s_ < 0) {
    begin_s_ = closed_at_ = now;
    begin_opening_ = least_opening_ = opening;
  }
  if (opening < least_opening_ - closer) {
    least_opening_ = opening;
    closed_at_ = now;
  }
  if (now - closed_at_ > still_seconds) {
    done_ = true;
    return hand.raise(lift, lifting_speed);
  }
  return {hand.open(std::max(0.0, begin_opening_ - jaw_speed * (now - begin_s_)))};
}

}  // namespace palpate::app
