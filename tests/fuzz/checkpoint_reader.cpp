#include <cmath>

#include "base/key.h"
#include "fuzz/memory_file.h"
#include "fuzz/reader.h"
#include "io/text_file.h"
#include "mtled/run/checkpoint.h"

namespace palpate::fuzz {

namespace {

using tools::Checkpoint;

constexpr std::uint64_t model_hash = 0x0123456789abcdef;
constexpr std::size_t node_count = 3, checksum_size = 8;

/// Without their checksum: `readCheckpointFrom` adds the one that holds, else hardly any input would pass it.
std::vector<std::string> checkpointSeeds() {
  Checkpoint c;
  c.model_hash = model_hash;
  c.position = 7;
  c.rows = 6;
  c.largest = 0.01;
  c.frame_time = {0.25, 0.5};
  for (std::size_t i = 0; i < node_count; ++i) {
    c.u.push_back({0.1 * static_cast<double>(i), -1.0 / 3, 1e-300, 0});
    c.du.push_back({1e-9, 0, 0, 0});
  }
  std::vector<std::string> seeds;
  for (int k = 0; k < 2; ++k) {
    seeds.push_back(tools::checkpointBytes(c));
    seeds.back().resize(seeds.back().size() - checksum_size);
    c.frame_time.clear();
  }
  return seeds;
}

void readCheckpointFrom(const std::string& bytes) {
  static const MemoryFile file;
  const std::uint64_t sum = fnv1a(bytes);
  const std::string whole = bytes + std::string(reinterpret_cast<const char*>(&sum), sizeof sum);
  const Checkpoint c = tools::readCheckpoint(file.write(whole), model_hash, node_count);
  hold(c.position >= 0 && c.rows >= 0 && c.rows <= c.position, "a solution can't have stood there");
  hold(std::isfinite(c.largest), "the largest displacement is not finite");
  hold(c.u.size() == node_count && c.du.size() == node_count, "not all nodes");
  hold(tools::checkpointBytes(c) == whole, "written again it has other bytes");
}

}  // namespace

const Reader checkpoint_reader = {"checkpoint", checkpointSeeds, readCheckpointFrom};

}  // namespace palpate::fuzz
