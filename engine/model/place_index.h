#pragma once

#include <array>

#include "contact/tool_set.h"

namespace palpate {

/// Which place of a cloud that follows the tools (place.h): the centre of each tool's ball by number, -1 beyond the
/// last tool.
using PlaceIndex = std::array<int, max_tools>;

/// Of states whose cloud stays.
inline constexpr PlaceIndex no_place = [] {
  PlaceIndex index{};
  for (int& centre : index) centre = -1;
  return index;
}();

}  // namespace palpate
