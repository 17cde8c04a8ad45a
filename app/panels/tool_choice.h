#pragma once

#include "contact/tool.h"

namespace palpate::app {

/// A probe as it is chosen in the window, in place of the scene's.
struct ToolChoice {
  ToolKind kind{};
  double radius = 0;  // m
};

}  // namespace palpate::app
