#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/types.h"

namespace palpate {

/// How many corners may still be looked at while polygons are cut: a corner costs a few nanoseconds.
struct CutBudget {
  std::int64_t visits = 200'000'000;
};

/// Cuts a polygon, concave or not and nearly flat, into corner_count - 2 triangles of its corners (indices into
/// `corners`) that turn as it does: ears are cut off it as seen along its normal. Where it crosses itself, so that it
/// has no ear left, the rest becomes a fan. Corners on one line make triangles without area.
/// Costs ~ corner_count^2, of a polygon that crosses itself up to corner_count^3.
/// @param budget  one for all polygons of a file: is it used up, the rest becomes fans
std::vector<std::array<int, 3>> polygonTriangles(std::span<const Vec3> corners, CutBudget& budget);

/// Fills a closed curve in space, e.g. the rim of a hole, with the triangles of its corners whose summed area is least
/// (Barequet and Sharir 1995), which turn as the curve does; triangles without area only where there is no other way.
/// Costs ~ corner_count^3: for up to 100 corners or so.
std::vector<std::array<int, 3>> smallestFill(std::span<const Vec3> corners);

}  // namespace palpate
