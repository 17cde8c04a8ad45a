#pragma once

#include <vector>

#include "model/preparation.h"

namespace palpate {

/// Several bodies that are not joined to one another as one: nodes, cells, points and skin of the first, then those of
/// the next, each with its own supports. The step's limit is the smallest of all.
/// @param bodies  at least one
Preparation joinBodies(std::vector<Preparation> bodies);

}  // namespace palpate
