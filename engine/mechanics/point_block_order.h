#pragma once

#include <vector>

#include "approximation/shape_table.h"

namespace palpate {

/// Regroups points so that each four share more of their nodes: a block's union support is what the kernel executes,
/// padded to whole groups of four nodes. Points are exchanged between neighbouring blocks as long as that sum shrinks.
///
/// @param order  points by place, e.g. bisectionOrder(X, 4): each consecutive four are a block, -1 is padding
/// @return the same points, exchanged over short distances only (within `order`); equal for equal input
/// Cost ~ 1.5 us per point. Test: mechanics/quad_order_test.cpp
std::vector<int> pointBlockOrder(const ShapeTable& shape, std::vector<int> order);

}  // namespace palpate
