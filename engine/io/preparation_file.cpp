#include "io/preparation_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <type_traits>

#include "base/parallel_for.h"

namespace palpate {
namespace {

constexpr std::uint64_t magic = 0x31657461706c6170;  // "palpate1" as bytes
constexpr std::uint64_t version = 8;                 // of the layout below
constexpr std::size_t block_bytes = 1 << 20;

/// A word-wise mix: each step is a bijection of the state, so one changed word always changes the result.
std::uint64_t mix(std::uint64_t state, std::uint64_t word) {
  state = (state ^ word) * 0x9e3779b97f4a7c15ull;
  return state ^ (state >> 32);
}

std::uint64_t hashBytes(const char* bytes, std::size_t count, std::uint64_t seed) {
  std::uint64_t lane[4] = {seed, seed ^ 0x5555, seed ^ 0xaaaa, seed ^ 0xffff};  // four at once: a multiplication waits
  std::size_t at = 0;
  for (; at + 32 <= count; at += 32)
    for (int k = 0; k < 4; ++k) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes + at + 8 * k, 8);
      lane[k] = mix(lane[k], word);
    }
  std::uint64_t hash = mix(seed, count);
  for (; at < count; ++at) hash = mix(hash, static_cast<unsigned char>(bytes[at]));
  for (const std::uint64_t l : lane) hash = mix(hash, l);
  return hash;
}

template <class P, class Visit>
void forEachTable(P& table, Visit&& visit) {
  visit(table.begin);
  visit(table.node);
  visit(table.N);
  visit(table.gradN);
}

/// All arrays, in the file's order.
template <class P, class Visit>
void forEachArray(P& p, Visit&& visit) {
  visit(p.X);
  visit(p.support_radius);
  visit(p.mass);
  visit(p.own_mass);
  visit(p.cells);
  visit(p.point_X);
  visit(p.point_volume);
  visit(p.point_material);
  visit(p.point_cell);
  visit(p.point_other_cell);
  visit(p.side_node);
  visit(p.vertex_group);
  visit(p.volume_cells);
  visit(p.end_node);
  visit(p.end_point);
  forEachTable(p.point_shape, visit);
  forEachTable(p.node_shape, visit);
  visit(p.skin.surface.vertices);
  visit(p.skin.surface.triangles);
  visit(p.skin.begin);
  visit(p.skin.node);
  visit(p.skin.N);
  visit(p.essential.nodes);
  visit(p.essential.facets);
  visit(p.essential.facet_weight);
  forEachTable(p.essential.facet_phi, visit);
  visit(p.cloud.X);
  visit(p.cloud.on_surface);
  visit(p.cloud.coarsest);
  visit(p.missed_shares);
}
constexpr std::size_t array_count = 39;

struct Header {
  std::uint64_t magic_word = magic, layout = version;
  KeyHash key{};
  double surface_volume = 0, cell_volume = 0, dt = 0, dt_proven = 0, pair_moment = 0, layer_error = 0;
  std::int64_t thin_layer = -1, worst_node = 0, iterations = 0;
  std::array<std::uint64_t, array_count> length{};  // elements
  std::array<std::uint64_t, array_count> checksum{};
  std::uint64_t own_checksum = 0;  // of all before it
};
static_assert(std::is_trivially_copyable_v<Header> && sizeof(Header) == (14 + 2 * array_count) * 8);  // no padding

std::uint64_t checksumOf(const Header& header) {
  return hashBytes(reinterpret_cast<const char*>(&header), offsetof(Header, own_checksum), version);
}

/// Splits bytes into blocks; visit(block, offset, count) runs on all cores and says whether it worked.
template <class Visit>
bool forEachBlock(std::size_t bytes, Visit&& visit) {
  const auto blocks = static_cast<int>((bytes + block_bytes - 1) / block_bytes);
  std::atomic<bool> good{true};
  parallelFor(
      blocks,
      [&](int first, int last) {
        for (int b = first; b < last && good; ++b) {
          const std::size_t offset = static_cast<std::size_t>(b) * block_bytes;
          if (!visit(b, offset, std::min(block_bytes, bytes - offset))) good = false;
        }
      },
      1);
  return good;
}

/// The checksum of an array is that of its blocks' checksums; `prepare` runs on each block first.
template <class Prepare>
bool checksumOf(const char* bytes, std::size_t count, std::uint64_t& sum, Prepare&& prepare) {
  std::vector<std::uint64_t> of_block((count + block_bytes - 1) / block_bytes);
  const bool good = forEachBlock(count, [&](int b, std::size_t offset, std::size_t length) {
    if (!prepare(offset, length)) return false;
    of_block[b] = hashBytes(bytes + offset, length, static_cast<std::uint64_t>(b));
    return true;
  });
  sum = count;
  for (const std::uint64_t h : of_block) sum = mix(sum, h);
  return good;
}

int writeAll(int file, const char* bytes, std::size_t count) {
  while (count != 0) {
    const ssize_t written = ::write(file, bytes, count);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes += written;
    count -= static_cast<std::size_t>(written);
  }
  return 0;
}

bool readAt(int file, char* bytes, std::size_t count, std::size_t offset) {
  while (count != 0) {
    const ssize_t got = ::pread(file, bytes, count, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes += got;
    offset += static_cast<std::size_t>(got);
    count -= static_cast<std::size_t>(got);
  }
  return true;
}

}  // namespace

KeyHash hashOf(const std::string& bytes) {
  return {hashBytes(bytes.data(), bytes.size(), 0x243f6a8885a308d3ull),
          hashBytes(bytes.data(), bytes.size(), 0x13198a2e03707344ull)};
}

int writePreparation(int file, const KeyHash& key, const Preparation& p) {
  Header header;
  header.key = key;
  header.surface_volume = p.surface_volume;
  header.cell_volume = p.cell_volume;
  header.dt = p.limit.dt;
  header.dt_proven = p.limit.dt_proven;
  header.pair_moment = p.pair_moment;
  header.layer_error = p.layer_error;
  header.thin_layer = p.thin_layer;
  header.worst_node = p.limit.worst_node;
  header.iterations = p.limit.iterations;
  std::size_t k = 0;
  forEachArray(p, [&](const auto& array) {
    header.length[k] = array.size();
    checksumOf(reinterpret_cast<const char*>(array.data()), array.size() * sizeof array[0], header.checksum[k],
               [](std::size_t, std::size_t) { return true; });
    ++k;
  });
  header.own_checksum = checksumOf(header);
  int error = writeAll(file, reinterpret_cast<const char*>(&header), sizeof header);
  forEachArray(p, [&](const auto& array) {
    if (error == 0) error = writeAll(file, reinterpret_cast<const char*>(array.data()), array.size() * sizeof array[0]);
  });
  return error;
}

bool readPreparation(int file, const KeyHash& key, Preparation& p) {
  Header header;
  struct stat about {};
  if (::fstat(file, &about) != 0 || !readAt(file, reinterpret_cast<char*>(&header), sizeof header, 0)) return false;
  if (header.magic_word != magic || header.layout != version || header.key != key ||
      header.own_checksum != checksumOf(header))
    return false;
  // The header holds: its lengths are those that were written. They must be the file's.
  auto left = static_cast<std::uint64_t>(about.st_size) - sizeof header;
  std::size_t k = 0;
  bool good = true;
  forEachArray(p, [&](const auto& array) {
    const std::uint64_t length = header.length[k++], most = left / sizeof array[0];
    good = good && length <= most;
    if (good) left -= length * sizeof array[0];
  });
  if (!good || left != 0) return false;

  std::size_t offset = sizeof header;
  k = 0;
  forEachArray(p, [&](auto& array) {
    if (!good) return;
    array.resize(header.length[k]);
    auto* bytes = reinterpret_cast<char*>(array.data());
    const std::size_t count = array.size() * sizeof array[0];
    std::uint64_t sum = 0;
    good =
        checksumOf(bytes, count, sum,
                   [&](std::size_t at, std::size_t length) { return readAt(file, bytes + at, length, offset + at); }) &&
        sum == header.checksum[k];
    offset += count;
    ++k;
  });
  if (!good) return false;
  p.surface_volume = header.surface_volume;
  p.cell_volume = header.cell_volume;
  p.pair_moment = header.pair_moment;
  p.layer_error = header.layer_error;
  // What does not fit an int is no node; isSound refuses it.
  const auto toInt = [](std::int64_t a) { return a == static_cast<int>(a) ? static_cast<int>(a) : -1; };
  p.thin_layer = toInt(header.thin_layer);
  p.limit = {header.dt, header.dt_proven, toInt(header.worst_node), toInt(header.iterations)};
  return true;
}

}  // namespace palpate
