#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/types.h"

namespace palpate::tools {

/// Where a solution stood when it was saved.
struct Checkpoint {
  std::uint64_t model_hash = 0;    // of the model and the load that it belongs to
  std::int64_t position = 0;       // load steps done, or time steps of a transient solution
  std::int64_t rows = 0;           // of force.csv
  double largest = 0;              // m, largest displacement so far; what the tolerance is a share of
  std::vector<double> frame_time;  // (frame_count) s, of the VTU files written
  AlignedVector<Double4> u, du;    // (node_count) m
  AlignedVector<double> history;   // Pa, of materials that relax (BatchBody::history)
};

/// What the file holds: numbers as they lie in memory, and a checksum of them.
std::string checkpointBytes(const Checkpoint& checkpoint);

/// Whole or not at all. Throws std::runtime_error that names the file and the reason.
void writeCheckpoint(const std::string& path, const Checkpoint& checkpoint);

/// Throws InputError where the file is missing, cut short, damaged (numbers that no solution leaves are damage,
/// too), or
/// of another model or load.
Checkpoint readCheckpoint(const std::string& path, std::uint64_t model_hash, std::size_t node_count);

}  // namespace palpate::tools
