#pragma once

#include <bit>
#include <cstddef>
#include <cstring>
#include <string_view>

namespace palpate {

/// Numbers as they lie in a file's bytes, in either order.
class ByteReader {
 public:
  ByteReader(std::string_view bytes, std::size_t at, bool big_endian)
      : bytes_(bytes), at_(at), swap_(big_endian != (std::endian::native == std::endian::big)) {}

  std::size_t at() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }
  void skip(std::size_t count) { at_ += count < left() ? count : left(); }

  /// False, and nothing is read, where fewer bytes are left.
  template <class T>
  bool read(T& value) {
    if (left() < sizeof(T)) return false;
    char raw[sizeof(T)];
    for (std::size_t i = 0; i < sizeof(T); ++i) raw[i] = bytes_[at_ + (swap_ ? sizeof(T) - 1 - i : i)];
    std::memcpy(&value, raw, sizeof(T));
    at_ += sizeof(T);
    return true;
  }

 private:
  std::string_view bytes_;
  std::size_t at_;
  bool swap_;
};

/// The kinds of number that PLY and VTK files have.
enum class NumberKind { None, Int8, UInt8, Int16, UInt16, Int32, UInt32, Int64, Float32, Float64 };

constexpr std::size_t bytesOf(NumberKind kind) {
  switch (kind) {
    case NumberKind::Int8:
    case NumberKind::UInt8:
      return 1;
    case NumberKind::Int16:
    case NumberKind::UInt16:
      return 2;
    case NumberKind::Int32:
    case NumberKind::UInt32:
    case NumberKind::Float32:
      return 4;
    case NumberKind::Int64:
    case NumberKind::Float64:
      return 8;
    case NumberKind::None:
      break;
  }
  return 0;
}

/// One number of this kind; false at the end of the bytes.
inline bool readNumber(ByteReader& reader, NumberKind kind, double& value) {
  const auto as = [&](auto raw) {
    if (!reader.read(raw)) return false;
    value = static_cast<double>(raw);
    return true;
  };
  switch (kind) {
    case NumberKind::Int8:
      return as(static_cast<signed char>(0));
    case NumberKind::UInt8:
      return as(static_cast<unsigned char>(0));
    case NumberKind::Int16:
      return as(short{0});
    case NumberKind::UInt16:
      return as(static_cast<unsigned short>(0));
    case NumberKind::Int32:
      return as(0);
    case NumberKind::UInt32:
      return as(0U);
    case NumberKind::Int64:
      return as(0LL);
    case NumberKind::Float32:
      return as(0.0F);
    case NumberKind::Float64:
      return as(0.0);
    case NumberKind::None:
      break;
  }
  return false;
}

/// A vertex index that was read as a number: -1 where it is none.
inline int asIndex(double value) {
  return value >= 0 && value < 2147483647.0 && value == static_cast<double>(static_cast<int>(value))
             ? static_cast<int>(value)
             : -1;
}

}  // namespace palpate
