#include "mtled/solve/checkpoint.h"

#include <cstring>
#include <fstream>

#include "base/input_error.h"
#include "base/key.h"
#include "io/output_file.h"

namespace palpate::tools {
namespace {

constexpr char magic[] = "mtled checkpoint 2\n";

template <class T>
void add(std::string& bytes, const T* data, std::size_t count) {
  bytes.append(reinterpret_cast<const char*>(data), count * sizeof(T));
}

template <class T>
void take(const char*& at, T* data, std::size_t count) {
  if (count != 0) std::memcpy(static_cast<void*>(data), at, count * sizeof(T));  // an empty vector has no address
  at += count * sizeof(T);
}

}  // namespace

void writeCheckpoint(const std::string& path, const Checkpoint& c) {
  std::string bytes(magic);
  const std::uint64_t nodes = c.u.size(), frames = c.frame_time.size();
  add(bytes, &c.model_hash, 1);
  add(bytes, &c.position, 1);
  add(bytes, &c.rows, 1);
  add(bytes, &c.largest, 1);
  add(bytes, &frames, 1);
  add(bytes, &nodes, 1);
  add(bytes, c.frame_time.data(), frames);
  add(bytes, c.u.data(), c.u.size());
  add(bytes, c.du.data(), c.du.size());
  const std::uint64_t sum = fnv1a(bytes);
  add(bytes, &sum, 1);
  writeWholeFile(path, bytes);
}

Checkpoint readCheckpoint(const std::string& path, std::uint64_t model_hash, std::size_t node_count) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError({path}, "there is no checkpoint", "start without --resume");
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  constexpr std::size_t head = sizeof magic - 1 + 6 * 8, tail = 8;
  const auto damaged = [&] { return InputError({path}, "the checkpoint is damaged", "start without --resume"); };
  if (bytes.size() < head + tail || bytes.compare(0, sizeof magic - 1, magic) != 0) throw damaged();
  Checkpoint c;
  std::uint64_t nodes = 0, frames = 0, sum = 0;
  std::memcpy(&sum, bytes.data() + bytes.size() - tail, tail);
  if (sum != fnv1a(bytes.substr(0, bytes.size() - tail))) throw damaged();
  const char* at = bytes.data() + sizeof magic - 1;
  take(at, &c.model_hash, 1);
  take(at, &c.position, 1);
  take(at, &c.rows, 1);
  take(at, &c.largest, 1);
  take(at, &frames, 1);
  take(at, &nodes, 1);
  if (bytes.size() != head + tail + frames * sizeof(double) + 2 * nodes * sizeof(Double4)) throw damaged();
  if (c.model_hash != model_hash || nodes != node_count)
    throw InputError({path}, "the checkpoint was made with another scene, load_steps, end_time, mode or tool script",
                     "take them back, or start without --resume");
  c.frame_time.resize(frames);
  c.u.resize(nodes);
  c.du.resize(nodes);
  take(at, c.frame_time.data(), frames);
  take(at, c.u.data(), nodes);
  take(at, c.du.data(), nodes);
  return c;
}

}  // namespace palpate::tools
