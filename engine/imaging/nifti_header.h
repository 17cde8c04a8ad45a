#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "base/types.h"

namespace palpate::nifti {

/// What both versions of the header say, as far as it matters here.
struct Header {
  bool swapped = false;               // the file's byte order is not this machine's
  std::array<std::int64_t, 8> dim{};  // count of dimensions, then their lengths
  int datatype = 0, bitpix = 0;
  std::array<double, 8> pixdim{};  // qfac, then the voxels' edges
  double vox_offset = 0, slope = 0, intercept = 0;
  int units = 0;
  int qform_code = 0, sform_code = 0;
  Vec3 quaternion = Vec3::Zero();  // b, c, d
  Vec3 qoffset = Vec3::Zero();
  Eigen::Matrix<double, 3, 4> srow = Eigen::Matrix<double, 3, 4>::Zero();
  std::size_t bytes = 348;  // of the header itself
};

constexpr std::size_t header_bytes_1 = 348, header_bytes_2 = 540, extension_bytes = 4;

/// A number at a place of some bytes. @pre it lies within them
template <class T>
T numberAt(std::string_view bytes, std::size_t at, bool swapped) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes.data() + at, sizeof(T));
  if (swapped)
    for (std::size_t b = 0; b < sizeof(T) / 2; ++b) std::swap(raw[b], raw[sizeof(T) - 1 - b]);
  return std::bit_cast<T>(raw);
}

/// Reads the header from the file's first bytes. Throws InputError.
/// @param bytes  header_bytes_2 of them, or fewer where the file is shorter
Header readHeader(std::string_view bytes, const std::string& name);

}  // namespace palpate::nifti
