#include "realtime/loop/further_hands.h"

#include <algorithm>
#include <cmath>

namespace palpate {

void FurtherHands::take(const Request& request, Command& command) {
  if (request.index < 0 || request.index >= model_.tools.toolCount()) return;
  const auto k = static_cast<std::size_t>(request.index);
  if (request.kind == Request::Kind::SetOpening) {
    if (!std::isfinite(request.value) || !model_.tools.tool[k].jaws) return;
    command.tools[k].opening = std::max(0.0, request.value);
    memory_.opened[k] = true;
    return;
  }
  if (k == 0 || !request.pose.isSound()) return;
  command.tools[k].pose = request.pose;
  memory_.moved[k] = true;
}

void FurtherHands::next(std::int64_t tick, Command& command) const {
  for (std::size_t k = 0; k < model_.tools.tool.size(); ++k) {
    const std::vector<ToolPosture>& path = model_.tools.tool[k].path;
    if (path.empty()) continue;
    const auto at = static_cast<std::size_t>(std::max<std::int64_t>(0, tick - memory_.begin));
    const ToolPosture& wanted = path[std::min(at, path.size() - 1)];
    if (!memory_.moved[k]) command.tools[k].pose = wanted.pose;
    if (!memory_.opened[k]) command.tools[k].opening = wanted.opening;
  }
}

void FurtherHands::restart(std::int64_t tick) {
  memory_ = {};
  memory_.begin = tick;
}

}  // namespace palpate
