#pragma once

#include <functional>
#include <vector>

#include "model/preparation.h"

namespace palpate {

/// The scene as a body has it: what is of other organs holds nothing.
/// @param surface  of the body
Scene sceneOf(const Scene& scene, const TriangleSurface& surface);

/// Throws InputError where a boundary of the scene imposes no node of any body, or is of one body among several.
/// @param has  whether a boundary (by its number) imposes a node of a body
void checkBoundaries(const Scene& scene, std::size_t body_count,
                     const std::function<bool(std::size_t body, std::size_t boundary)>& has);

/// Several bodies that are not joined to one another as one: nodes, cells, points and skin of the first, then those of
/// the next, each with its own supports. The step's limit is the smallest of all.
/// @param bodies  at least one
Preparation joinBodies(std::vector<Preparation> bodies);

}  // namespace palpate
