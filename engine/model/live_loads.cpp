#include "model/live_loads.h"

#include <algorithm>

#include "base/float4.h"

namespace palpate {

bool VertexValues::operator==(const VertexValues& other) const {
  const auto same = [](const Float4& a, const Float4& b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
  return count == other.count && vertex == other.vertex &&
         std::equal(value.begin(), value.begin() + count, other.value.begin(), same);
}

bool VertexValues::put(int at, const Vec3& of) {
  const auto end = vertex.begin() + count;
  const auto place = std::lower_bound(vertex.begin(), end, at);
  const auto k = place - vertex.begin();
  if (place == end || *place != at) {
    if (count == capacity) return false;
    std::move_backward(place, end, end + 1);
    std::move_backward(value.begin() + k, value.begin() + count, value.begin() + count + 1);
    ++count;
  }
  vertex[static_cast<std::size_t>(k)] = at;
  value[static_cast<std::size_t>(k)] = toFloat4(of);
  return true;
}

Vec3 VertexValues::at(int skin_vertex) const {
  if (!has(skin_vertex)) return Vec3::Zero();
  const auto k = std::lower_bound(vertex.begin(), vertex.begin() + count, skin_vertex) - vertex.begin();
  return toVec3(value[static_cast<std::size_t>(k)]);
}

void VertexValues::drop(int at) {
  const auto end = vertex.begin() + count;
  const auto place = std::lower_bound(vertex.begin(), end, at);
  if (place == end || *place != at) return;
  const auto k = place - vertex.begin();
  std::move(place + 1, end, place);
  std::move(value.begin() + k + 1, value.begin() + count, value.begin() + k);
  --count;
  vertex[static_cast<std::size_t>(count)] = 0;
  value[static_cast<std::size_t>(count)] = {};
}

bool LiveLoads::any() const { return forces.count > 0 || pins.count > 0 || !gravity.isZero(0) || region_shift.any(); }

bool LiveLoads::setForce(int at, const Vec3& newtons) {
  if (!newtons.isZero(0)) return forces.put(at, newtons);
  forces.drop(at);
  return true;
}

}  // namespace palpate
