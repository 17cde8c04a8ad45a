#include "realtime/loop/input_recorder.h"

namespace palpate {
namespace {

bool samePose(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

}  // namespace

void InputRecorder::add(std::int64_t tick, const Request& request) {
  if (ring_ != nullptr && !ring_->push({tick, request})) ++lost_;
}

void InputRecorder::addCommand(std::int64_t tick, const Command& command) {
  if (!samePose(command.tools[0].pose, command_.tools[0].pose)) add(tick, Request::moveTool(command.tools[0].pose));
  if (command.pull_vertex != command_.pull_vertex || command.pull_target != command_.pull_target) {
    add(tick, command.pull_vertex < 0 ? Request::simple(Request::Kind::ReleasePull)
                                      : Request::pull(command.pull_vertex, command.pull_target));
  }
  for (int k = 0; k < max_tools; ++k) {
    const ToolPosture& now = command.tools[static_cast<std::size_t>(k)];
    const ToolPosture& before = command_.tools[static_cast<std::size_t>(k)];
    if (k > 0 && !samePose(now.pose, before.pose)) add(tick, Request::moveHand(k, now.pose));
    if (now.opening != before.opening) add(tick, Request::setOpening(k, now.opening));
  }
  command_ = command;
}

void InputRecorder::addJump(std::int64_t tick, Request::Kind kind, const Command& command) {
  command_ = command;
  add(tick, Request::simple(kind));
}

}  // namespace palpate
