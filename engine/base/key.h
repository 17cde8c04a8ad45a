#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/types.h"

namespace palpate {

/// 64-bit FNV-1a of bytes; `hash` is that of the bytes before them.
inline std::uint64_t fnv1a(std::string_view bytes, std::uint64_t hash = 0xcbf29ce484222325ull) {
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
  return hash;
}

/// Values as bytes without padding, lists after their length, so that no two rows of values read alike.
class ByteKey {
 public:
  template <class T, class... More>
  void add(const T& value, const More&... more) {
    one(value);
    (one(more), ...);
  }
  const std::string& bytes() const { return bytes_; }
  std::uint64_t hash() const { return fnv1a(bytes_); }

 private:
  template <class T>
  void one(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);  // no padding
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class Real, int rows>
  void one(const Eigen::Matrix<Real, rows, 1>& v) {
    for (const Real component : v) one(component);
  }
  template <class Real>
  void one(const Real4<Real>& v) {
    add(v.x, v.y, v.z, v.w);
  }
  template <class T, std::size_t size>
  void one(const std::array<T, size>& values) {
    for (const T& value : values) one(value);
  }
  template <class T, class Allocator>
  void one(const std::vector<T, Allocator>& list) {
    one(list.size());
    if constexpr (std::is_arithmetic_v<T>) {
      bytes_.append(reinterpret_cast<const char*>(list.data()), list.size() * sizeof(T));
    } else {
      for (const T& value : list) one(value);
    }
  }

  std::string bytes_;
};

}  // namespace palpate
