#pragma once

#include <cstdint>

namespace palpate {

struct Model;
struct State;

/// 64-bit FNV-1a over all that decides a run's result but its input: nodes, points, masses, kernel, boundaries, skin,
/// tool, materials, time step.
std::uint64_t modelHash(const Model& model);

/// 64-bit FNV-1a over all that decides a state's future under its model: tick, step, u, du, u_low, contact forces, tool
/// pose, and the live settings where they differ from what the model was loaded with. Left as loaded they add
/// nothing, so
/// that states which were never set live compare with those of programs that had no live settings.
std::uint64_t stateHash(const Model& model, const State& state);

}  // namespace palpate
