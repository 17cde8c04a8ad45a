#pragma once

#include <string>

#include "model/body.h"

namespace palpate {

/// 1 along each axis along which nothing holds the body, so that it may slide there as a whole, 0 along the others;
/// zero where nothing is known to hold it at all, no rigid body either.
Vec3 freeAxes(const Body& body);

/// A sentence about bodies that nothing holds, where others are held: touched, they go away and do not come back. ""
/// where there are none, or rigid bodies that they may lie on.
std::string looseWarning(const Body& body);

}  // namespace palpate
