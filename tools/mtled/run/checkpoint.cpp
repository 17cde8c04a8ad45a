#include "mtled/run/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "base/input_error.h"
#include "base/key.h"
#include "io/output_file.h"
#include "io/text_file.h"

namespace palpate::tools {
namespace {

constexpr char magic[] = "mtled checkpoint 3\n";

template <class T>
void add(std::string& bytes, const T* data, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(data), count * sizeof(T));
}

template <class T>
void take(const char*& at, T* data, std::size_t count) {
  if (count != 0) std::memcpy(static_cast<void*>(data), at, count * sizeof(T));  // an empty vector has no address
  at += count * sizeof(T);
}

bool finite(const AlignedVector<Double4>& field) {
  return std::all_of(field.begin(), field.end(), [](const Double4& a) {
    return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z) && std::isfinite(a.w);
  });
}

/// Whether a solution can have stood so.
bool possible(const Checkpoint& c) {
  constexpr std::int64_t most = std::int64_t{1} << 53;  // what a double counts exactly, as times are computed
  return c.position >= 0 && c.position <= most && c.rows >= 0 && c.rows <= c.position && std::isfinite(c.largest) &&
         c.largest >= 0 && std::all_of(c.frame_time.begin(), c.frame_time.end(), [](double t) { return t >= 0; }) &&
         std::all_of(c.frame_time.begin(), c.frame_time.end(), [](double t) { return std::isfinite(t); }) &&
         std::is_sorted(c.frame_time.begin(), c.frame_time.end()) && finite(c.u) && finite(c.du) &&
         std::all_of(c.history.begin(), c.history.end(), [](double z) { return std::isfinite(z); });
}

}  // namespace

std::string checkpointBytes(const Checkpoint& c) {
  std::string bytes(magic);
  const std::uint64_t nodes = c.u.size(), frames = c.frame_time.size(), remembered = c.history.size();
  add(bytes, &c.model_hash, 1);
  add(bytes, &c.position, 1);
  add(bytes, &c.rows, 1);
  add(bytes, &c.largest, 1);
  add(bytes, &frames, 1);
  add(bytes, &nodes, 1);
  add(bytes, &remembered, 1);
  add(bytes, c.frame_time.data(), frames);
  add(bytes, c.u.data(), c.u.size());
  add(bytes, c.du.data(), c.du.size());
  add(bytes, c.history.data(), c.history.size());
  const std::uint64_t sum = fnv1a(bytes);
  add(bytes, &sum, 1);
  return bytes;
}

void writeCheckpoint(const std::string& path, const Checkpoint& checkpoint) {
  writeWholeFile(path, checkpointBytes(checkpoint));
}

Checkpoint readCheckpoint(const std::string& path, std::uint64_t model_hash, std::size_t node_count) {
  if (!std::filesystem::exists(path)) throw InputError({path}, "there is no checkpoint", "start without --resume");
  const std::string bytes = readWholeFile(path);
  constexpr std::size_t head = sizeof magic - 1 + 7 * 8, tail = 8;
  const auto damaged = [&] { return InputError({path}, "the checkpoint is damaged", "start without --resume"); };
  if (bytes.size() < head + tail || bytes.compare(0, sizeof magic - 1, magic) != 0) throw damaged();
  Checkpoint c;
  std::uint64_t nodes = 0, frames = 0, remembered = 0, sum = 0;
  std::memcpy(&sum, bytes.data() + bytes.size() - tail, tail);
  if (sum != fnv1a(bytes.substr(0, bytes.size() - tail))) throw damaged();
  const char* at = bytes.data() + sizeof magic - 1;
  take(at, &c.model_hash, 1);
  take(at, &c.position, 1);
  take(at, &c.rows, 1);
  take(at, &c.largest, 1);
  take(at, &frames, 1);
  take(at, &nodes, 1);
  take(at, &remembered, 1);
  // Divided, not multiplied: a forged count of 2^61 frames would come out as 0 bytes.
  const std::uint64_t rest = bytes.size() - head - tail, node_size = 2 * sizeof(Double4);
  if (nodes > rest / node_size || frames > rest / sizeof(double) || remembered > rest / sizeof(double) ||
      rest != (frames + remembered) * sizeof(double) + nodes * node_size)
    throw damaged();
  if (c.model_hash != model_hash || nodes != node_count)
    throw InputError({path}, "the checkpoint was made with another scene, load_steps, end_time, mode or tool script",
                     "take them back, or start without --resume");
  c.frame_time.resize(frames);
  c.u.resize(nodes);
  c.du.resize(nodes);
  take(at, c.frame_time.data(), frames);
  take(at, c.u.data(), nodes);
  take(at, c.du.data(), nodes);
  c.history.resize(remembered);
  take(at, c.history.data(), remembered);
  if (!possible(c)) throw damaged();
  return c;
}

}  // namespace palpate::tools
