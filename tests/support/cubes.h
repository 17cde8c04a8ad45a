#pragma once

#include <array>
#include <cstddef>
#include <map>

#include "discretization/surface/triangle_surface.h"

namespace palpate::test {

/// The skin of what is made of cubes, where `filled` (their middle, in cubes) says so.
template <class Filled>
TriangleSurface cubes(const std::array<int, 3>& count, double size, Filled&& filled) {
  TriangleSurface surface;
  std::map<std::array<int, 3>, int> number;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [found, is_new] = number.try_emplace(at, static_cast<int>(number.size()));
    if (is_new) surface.vertices.push_back(size * Vec3(at[0], at[1], at[2]));
    return found->second;
  };
  const auto isFilled = [&](const std::array<int, 3>& c) {
    for (std::size_t a = 0; a < 3; ++a)
      if (c[a] < 0 || c[a] >= count[a]) return false;
    return filled(Vec3(c[0] + 0.5, c[1] + 0.5, c[2] + 0.5));
  };
  for (int n = 0; n < count[0] * count[1] * count[2]; ++n) {
    const std::array<int, 3> cell = {n % count[0], n / count[0] % count[1], n / count[0] / count[1]};
    if (!isFilled(cell)) continue;
    for (std::size_t a = 0; a < 3; ++a)
      for (const int side : {0, 1}) {
        std::array<int, 3> beside = cell, corner = cell;
        beside[a] += 2 * side - 1;
        if (isFilled(beside)) continue;
        corner[a] += side;
        const std::size_t b = (a + (side == 1 ? 1 : 2)) % 3, c = 3 - a - b;
        std::array<int, 3> at_b = corner, at_c = corner, opposite = corner;
        ++at_b[b], ++at_c[c], ++opposite[b], ++opposite[c];
        surface.triangles.push_back({vertex(corner), vertex(at_b), vertex(opposite)});
        surface.triangles.push_back({vertex(corner), vertex(opposite), vertex(at_c)});
      }
  }
  return surface;
}

}  // namespace palpate::test
