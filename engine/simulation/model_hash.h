#pragma once

#include <cstdint>

namespace palpate {

struct Model;

/// 64-bit FNV-1a over all that decides a run's result but its input: nodes, points, masses, kernel, boundaries, skin,
/// tool, materials, time step.
std::uint64_t modelHash(const Model& model);

}  // namespace palpate
