#pragma once

#include <optional>

#include "contact/tool_set.h"

namespace palpate {

/// Where the tools of a batch solution are: none of them is there, or each is where it says.
struct ToolsAt {
  int count = 0;  // 0, or as many as the model has; only the first of them with 1
  ToolPostures posture;

  ToolsAt() = default;
  ToolsAt(std::nullopt_t) {}
  ToolsAt(const Pose& only) : count(1) { posture[0].pose = only; }
  ToolsAt(const std::optional<Pose>& only) {
    if (only) *this = ToolsAt(*only);
  }
  explicit operator bool() const { return count > 0; }
};

/// A share of the way between two, turning and closing included; there are as many as in `to`.
ToolsAt between(const ToolsAt& from, const ToolsAt& to, double share);

}  // namespace palpate
