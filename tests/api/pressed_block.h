#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "api/palpate.h"
#include "support/block_text.h"
#include "support/temp_folder.h"

namespace palpate::test {

/// A block under a sphere of 10 mm that comes to rest.
inline const std::string damped_text = touched_block_text + "[dynamics]\ndamping = 60\n";

struct ModelDeleter {
  void operator()(palpate_model* model) const { palpate_model_destroy(model); }
};
struct SimulationDeleter {
  void operator()(palpate_simulation* simulation) const { palpate_destroy(simulation); }
};
using ModelHandle = std::unique_ptr<palpate_model, ModelDeleter>;
using SimulationHandle = std::unique_ptr<palpate_simulation, SimulationDeleter>;

template <class T>
T sized() {
  T value{};
  value.size = sizeof value;
  return value;
}

/// A block under a sphere of 10 mm, read from a file as callers do.
inline ModelHandle loadBlock(const std::string& text = touched_block_text) {
  const TempFolder folder;
  palpate_model* model = nullptr;
  auto error = sized<palpate_error>();
  if (palpate_load(folder.write("block.toml", text).c_str(), nullptr, &model, &error) != PALPATE_OK)
    throw std::runtime_error(error.text);
  return ModelHandle(model);
}

inline SimulationHandle create(const ModelHandle& model) {
  palpate_simulation* simulation = nullptr;
  REQUIRE(palpate_create(model.get(), &simulation, nullptr) == PALPATE_OK);
  return SimulationHandle(simulation);
}

inline palpate_model_info describe(const ModelHandle& model) {
  auto info = sized<palpate_model_info>();
  REQUIRE(palpate_describe(model.get(), &info) == PALPATE_OK);
  return info;
}

/// The tip `depth` m below the resting skin, beside the middle.
inline std::array<double, 7> poseAtDepth(const palpate_model_info& info, double depth) {
  std::array<double, 7> pose{};
  std::copy_n(info.tool_start, 7, pose.begin());
  pose[0] += 0.011;
  pose[2] -= info.first_contact_travel + depth;
  return pose;
}

/// Presses at 50 mm/s from just above the skin, a pose each tick; no REQUIRE, so that any thread may do it.
inline palpate_state press(const SimulationHandle& simulation, const palpate_model_info& info, int begin, int end) {
  auto state = sized<palpate_state>();
  for (int k = begin; k < end; ++k) {
    const auto pose = poseAtDepth(info, -0.001 + 0.05 * k / info.rate_hz);
    if (palpate_step(simulation.get(), 1, pose.data(), &state) != PALPATE_OK) return {};
  }
  return state;
}

inline std::uint64_t hashOf(const SimulationHandle& simulation) {
  std::uint64_t hash = 0;
  REQUIRE(palpate_hash(simulation.get(), &hash) == PALPATE_OK);
  return hash;
}

/// Saves one and restores the other.
inline void copyState(const SimulationHandle& from, const SimulationHandle& to) {
  std::vector<char> bytes(palpate_save_size(from.get()));
  REQUIRE(palpate_save(from.get(), bytes.data(), bytes.size()) == PALPATE_OK);
  REQUIRE(palpate_restore(to.get(), bytes.data(), bytes.size(), nullptr) == PALPATE_OK);
}

inline std::vector<float> skinOf(const SimulationHandle& simulation, const palpate_model_info& info) {
  std::vector<float> x(3 * static_cast<std::size_t>(info.skin_vertex_count));
  REQUIRE(palpate_skin_positions(simulation.get(), x.data(), info.skin_vertex_count) == PALPATE_OK);
  return x;
}

/// A vertex of the upper face near (x, y).
inline std::int32_t upperVertex(const std::vector<float>& skin, double x = 0, double y = 0) {
  std::int32_t best = 0;
  double nearest = 1;
  for (std::size_t v = 0; v < skin.size() / 3; ++v) {
    const double distance = std::hypot(skin[3 * v] - x, skin[3 * v + 1] - y, skin[3 * v + 2] - 0.03);
    if (distance < nearest) nearest = distance, best = static_cast<std::int32_t>(v);
  }
  return best;
}

/// The upward force of the base on the tissue, N.
inline double baseForce(const SimulationHandle& simulation) {
  double force[3];
  REQUIRE(palpate_reactions(simulation.get(), force, nullptr, 1) == PALPATE_OK);
  return force[2];
}

}  // namespace palpate::test
