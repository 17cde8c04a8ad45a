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
  double slope = 1;
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
    put(b, 112, static_cast<float>(contents.slope));
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
  put(b, 176, contents.slope);
  put(b, 344, std::int32_t{has_qform ? scanner_code : 0});
  put(b, 348, std::int32_t{scanner_code});
  putPlace<double>(b, grid, 104, 352, 400);
  put(b, 500, std::int32_t{unit_mm});
  put(b, 504, std::int32_t{contents.intent});
  return b;
}

/// The header and behind it a number for each voxel, or for each of several components, made on all cores.
/// @param valueAt  the number n, as T
template <class T, class ValueAt>
std::string fileOf(const std::string& header, std::size_t count, bool compressed, ValueAt valueAt) {
  const auto fill = [&](std::size_t begin, std::size_t bytes, char* to) {
    for (std::size_t at = 0; at < bytes; at += sizeof(T)) {
      const T value = valueAt((begin + at) / sizeof(T));
      std::memcpy(to + at, &value, sizeof value);
    }
  };
  if (compressed) return gzipped(header) + gzipped(count * sizeof(T), fill);
  std::string bytes = header;
  bytes.resize(header.size() + count * sizeof(T));
  constexpr std::size_t piece = std::size_t{1} << 18;
  parallelFor(
      static_cast<int>((count + piece - 1) / piece),
      [&](int first, int last) {
        const std::size_t begin = static_cast<std::size_t>(first) * piece,
                          end = std::min(count, static_cast<std::size_t>(last) * piece);
        if (begin < end)
          fill(begin * sizeof(T), (end - begin) * sizeof(T), bytes.data() + header.size() + begin * sizeof(T));
      },
      1);
  return bytes;
}

template <class T>
std::string wholeNumbers(const std::string& header, const Image& image, double slope, bool compressed) {
  const auto per_slope = static_cast<float>(1 / slope);
  return fileOf<T>(header, image.value.size(), compressed, [&](std::size_t v) {
    return static_cast<T>(std::clamp(std::nearbyint(per_slope * image.value[v]),
                                     static_cast<float>(std::numeric_limits<T>::min()),
                                     static_cast<float>(std::numeric_limits<T>::max())));
  });
}

}  // namespace

std::string niftiFrom(const Image& image, NiftiType type, bool compressed, double slope) {
  constexpr Contents of_type[] = {{2, 8, 1}, {4, 16, 1}, {16, 32, 1}};
  Contents contents = of_type[static_cast<int>(type)];
  if (type != NiftiType::Float32) contents.slope = slope;
  const std::string header = headerOf(image.grid, contents);
  if (type == NiftiType::UInt8) return wholeNumbers<std::uint8_t>(header, image, slope, compressed);
  if (type == NiftiType::Int16) return wholeNumbers<std::int16_t>(header, image, slope, compressed);
  return fileOf<float>(header, image.value.size(), compressed, [&](std::size_t v) { return image.value[v]; });
}

std::string niftiFrom(const VectorImage& field, bool compressed) {
  const float to_lps[3] = {-1e3F, -1e3F, 1e3F};  // of RAS in m, mm
  const std::size_t count = field.value.size();
  return fileOf<float>(headerOf(field.grid, {16, 32, 3, vector_intent}), 3 * count, compressed, [&](std::size_t n) {
    const std::size_t c = n < count ? 0 : n < 2 * count ? 1 : 2;  // divisions cost more than all else here
    return to_lps[c] * field.value[n - c * count][static_cast<Eigen::Index>(c)];
  });
}

}  // namespace palpate
