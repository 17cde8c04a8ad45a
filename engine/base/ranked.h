#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace palpate {

/// The value that stands at `rank` once the values are sorted: at size / 2 the median. Changes their order.
template <class T>
T ranked(std::vector<T>& values, std::size_t rank) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace palpate
