#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/parallel_for.h"
#include "imaging/gzip.h"
#include "imaging/nifti.h"
#include "imaging/nifti_header.h"

namespace palpate {
namespace {

constexpr int scanner_code = 1, unit_mm = 2, vector_intent = 1007;

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// What a header says beside where the voxels are.
struct Contents {
  int datatype, bitpix, components;
  int intent = 0;
};

/// The qform's quaternion and qfac; false where the axes are not at right angles.
bool quaternionOf(const ImageGrid& grid, Vec3& bcd, double& qfac) {
  Mat3 R = grid.axes;
  for (int a = 0; a < 3; ++a) R.col(a).normalize();
  if (!(R.transpose() * R).isIdentity(1e-5)) return false;
  qfac = R.determinant() < 0 ? -1 : 1;
  R.col(2) *= qfac;
  Quat q(R);
  if (q.w() < 0) q.coeffs() = -q.coeffs();  // the header leaves w out, which is positive then
  bcd = q.vec();
  return true;
}

/// Writes what stands in both versions, T being the type of their real numbers.
template <class T>
void putPlace(std::string& b, const ImageGrid& grid, std::size_t pixdim, std::size_t quaternion, std::size_t srow) {
  Vec3 bcd = Vec3::Zero();
  double qfac = 1;
  quaternionOf(grid, bcd, qfac);
  put(b, pixdim, static_cast<T>(qfac));
  for (std::size_t a = 0; a < 3; ++a) {
    const auto c = static_cast<Eigen::Index>(a);
    put(b, pixdim + (a + 1) * sizeof(T), static_cast<T>(grid.spacing()[c] / mm));
    put(b, quaternion + a * sizeof(T), static_cast<T>(bcd[c]));
    put(b, quaternion + (a + 3) * sizeof(T), static_cast<T>(grid.origin[c] / mm));
    for (std::size_t k = 0; k < 3; ++k)
      put(b, srow + (4 * a + k) * sizeof(T), static_cast<T>(grid.axes(c, static_cast<Eigen::Index>(k)) / mm));
    put(b, srow + (4 * a + 3) * sizeof(T), static_cast<T>(grid.origin[c] / mm));
  }
  for (std::size_t a = 4; a < 8; ++a) put(b, pixdim + a * sizeof(T), static_cast<T>(1));
}

std::array<std::int64_t, 8> dimsOf(const ImageGrid& grid, int components) {
  return {components > 1 ? 5 : 3, grid.size[0], grid.size[1], grid.size[2], 1, components, 1, 1};
}

std::string headerOf(const ImageGrid& grid, const Contents& contents) {
  Vec3 bcd;
  double qfac = 1;
  const bool has_qform = quaternionOf(grid, bcd, qfac);
  const auto dim = dimsOf(grid, contents.components);
  if (*std::max_element(grid.size.begin(), grid.size.end()) <= 32767) {
    std::string b(nifti::header_bytes_1 + nifti::extension_bytes, '\0');
    put(b, 0, std::int32_t{348});
    for (std::size_t d = 0; d < 8; ++d) put(b, 40 + 2 * d, static_cast<std::int16_t>(dim[d]));
    put(b, 68, static_cast<std::int16_t>(contents.intent));
    put(b, 70, static_cast<std::int16_t>(contents.datatype));
    put(b, 72, static_cast<std::int16_t>(contents.bitpix));
    put(b, 108, static_cast<float>(b.size()));
    put(b, 112, 1.0F);
    b[123] = unit_mm;
    put(b, 252, static_cast<std::int16_t>(has_qform ? scanner_code : 0));
    put(b, 254, std::int16_t{scanner_code});
    putPlace<float>(b, grid, 76, 256, 280);
    std::memcpy(b.data() + 344, "n+1", 4);
    return b;
  }
  std::string b(nifti::header_bytes_2 + nifti::extension_bytes, '\0');
  put(b, 0, std::int32_t{540});
  std::memcpy(b.data() + 4, "n+2\0\r\n\032\n", 8);
  put(b, 12, static_cast<std::int16_t>(contents.datatype));
  put(b, 14, static_cast<std::int16_t>(contents.bitpix));
  for (std::size_t d = 0; d < 8; ++d) put(b, 16 + 8 * d, dim[d]);
  put(b, 168, static_cast<std::int64_t>(b.size()));
  put(b, 176, 1.0);
  put(b, 344, std::int32_t{has_qform ? scanner_code : 0});
  put(b, 348, std::int32_t{scanner_code});
  putPlace<double>(b, grid, 104, 352, 400);
  put(b, 500, std::int32_t{unit_mm});
  put(b, 504, std::int32_t{contents.intent});
  return b;
}

/// Appends a number for each voxel, on all cores.
template <class T, class ValueAt>
void appendValues(std::string& bytes, std::size_t count, ValueAt valueAt) {
  const std::size_t begin = bytes.size();
  bytes.resize(begin + count * sizeof(T));
  constexpr std::size_t piece = 1 << 16;
  parallelFor(
      static_cast<int>((count + piece - 1) / piece),
      [&](int first, int last) {
        const std::size_t end = std::min(count, static_cast<std::size_t>(last) * piece);
        for (std::size_t v = static_cast<std::size_t>(first) * piece; v < end; ++v)
          put(bytes, begin + v * sizeof(T), static_cast<T>(valueAt(v)));
      },
      1);
}

template <class T>
void appendWhole(std::string& bytes, const Image& image) {
  appendValues<T>(bytes, image.value.size(), [&](std::size_t v) {
    return std::clamp(std::nearbyint(image.value[v]), static_cast<float>(std::numeric_limits<T>::min()),
                      static_cast<float>(std::numeric_limits<T>::max()));
  });
}

}  // namespace

std::string niftiFrom(const Image& image, NiftiType type, bool compressed) {
  constexpr Contents contents[] = {{2, 8, 1}, {4, 16, 1}, {16, 32, 1}};
  std::string bytes = headerOf(image.grid, contents[static_cast<int>(type)]);
  if (type == NiftiType::UInt8)
    appendWhole<std::uint8_t>(bytes, image);
  else if (type == NiftiType::Int16)
    appendWhole<std::int16_t>(bytes, image);
  else
    appendValues<float>(bytes, image.value.size(), [&](std::size_t v) { return image.value[v]; });
  return compressed ? gzipped(bytes) : bytes;
}

std::string niftiFrom(const VectorImage& field, bool compressed) {
  std::string bytes = headerOf(field.grid, {16, 32, 3, vector_intent});
  const float to_lps[3] = {-1e3F, -1e3F, 1e3F};  // of RAS in m, mm
  for (int c = 0; c < 3; ++c)
    appendValues<float>(bytes, field.value.size(), [&](std::size_t v) { return to_lps[c] * field.value[v][c]; });
  return compressed ? gzipped(bytes) : bytes;
}

}  // namespace palpate
