#pragma once

#include "model/body.h"

namespace palpate {

/// 1 along each axis along which nothing holds the body, so that it may slide there as a whole, 0 along the others;
/// zero where nothing is known to hold it at all, no rigid body either.
Vec3 freeAxes(const Body& body);

}  // namespace palpate
