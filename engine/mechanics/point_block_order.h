#pragma once

#include <vector>

#include "approximation/shape_table.h"

namespace palpate {

/// Regroups points so that the four points of each block share more of their nodes. The kernel's work is the union
/// support of each block, padded to whole groups of four nodes; points are exchanged between neighbouring blocks as
/// long as the sum of these over all blocks shrinks.
///
/// @param order  points by place, e.g. bisectionOrder(X, 4): each consecutive four are a block, -1 is padding
/// @return the same points, exchanged over short distances only (within `order`); equal for equal input
/// Cost ~ 1.5 us per point. Test: mechanics/point_block_order_test.cpp
std::vector<int> pointBlockOrder(const ShapeTable& shape, std::vector<int> order);

}  // namespace palpate
