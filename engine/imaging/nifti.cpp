#include "imaging/nifti.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/input_error.h"
#include "base/number_text.h"
#include "imaging/gzip.h"
#include "imaging/nifti_header.h"

namespace palpate {
namespace {

using nifti::Header;

/// A type of voxels that can be read.
struct StoredType {
  int code, bytes;
  double (*value)(std::string_view bytes, std::size_t at, bool swapped);
};

template <class T>
double valueOf(std::string_view bytes, std::size_t at, bool swapped) {
  return static_cast<double>(nifti::numberAt<T>(bytes, at, swapped));
}

constexpr StoredType stored_types[] = {
    {2, 1, valueOf<std::uint8_t>},    {256, 1, valueOf<std::int8_t>},    {4, 2, valueOf<std::int16_t>},
    {512, 2, valueOf<std::uint16_t>}, {8, 4, valueOf<std::int32_t>},     {768, 4, valueOf<std::uint32_t>},
    {1024, 8, valueOf<std::int64_t>}, {1280, 8, valueOf<std::uint64_t>}, {16, 4, valueOf<float>},
    {64, 8, valueOf<double>},
};

[[noreturn]] void refuse(const std::string& name, const std::string& problem, const std::string& advice) {
  throw InputError({name}, problem, advice);
}

const StoredType& storedType(const Header& h, const std::string& name) {
  for (const StoredType& type : stored_types) {
    if (type.code != h.datatype) continue;
    if (type.bytes * 8 != h.bitpix)
      refuse(
          name,
          "the header says type " + std::to_string(h.datatype) + " but " + std::to_string(h.bitpix) + " bits a voxel",
          "the file is damaged: copy or convert it again");
    return type;
  }
  const bool colour = h.datatype == 128 || h.datatype == 2304;
  refuse(name, colour ? "this is a colour image" : "voxels of type " + std::to_string(h.datatype) + " can't be read",
         "give a scan with one number for each voxel");
}

/// The three sizes, checked one by one and together.
std::array<int, 3> sizeOf(const Header& h, const std::string& name) {
  if (h.dim[0] < 1 || h.dim[0] > 7)
    refuse(name, "the header says " + std::to_string(h.dim[0]) + " dimensions", "the file is damaged: copy it again");
  std::array<int, 3> size{1, 1, 1};
  std::size_t total = 1;
  for (std::size_t d = 1; d <= static_cast<std::size_t>(h.dim[0]); ++d) {
    const std::int64_t length = h.dim[d];
    if (length < 1)
      refuse(name, "dimension " + std::to_string(d) + " has a length of " + std::to_string(length),
             "the file is damaged: copy it again");
    if (d > 3) {
      if (length > 1)
        refuse(name, "this image has more than three dimensions (" + std::to_string(length) + " volumes)",
               "give one volume");
      continue;
    }
    if (static_cast<std::uint64_t>(length) > max_image_voxels / total)
      refuse(name, "the image has more than " + std::to_string(max_image_voxels) + " voxels",
             "crop it, or resample it more coarsely");
    total *= static_cast<std::size_t>(length);
    size[d - 1] = static_cast<int>(length);
  }
  return size;
}

/// m per unit of length.
double unitOf(const Header& h) {
  const int unit = h.units & 7;
  return unit == 1 ? 1.0 : unit == 3 ? 1e-6 : mm;
}

ImageGrid gridOfQform(const Header& h, const std::array<int, 3>& size, double unit) {
  const Vec3& v = h.quaternion;
  const double rest = 1 - v.squaredNorm();
  Quat q(rest > 0 ? std::sqrt(rest) : 0, v.x(), v.y(), v.z());
  q.normalize();  // rounding may leave b^2 + c^2 + d^2 above 1
  Vec3 edge(h.pixdim[1], h.pixdim[2], h.pixdim[3]);
  edge = edge.cwiseAbs();
  if (h.pixdim[0] < 0) edge.z() = -edge.z();  // qfac; 0 means 1
  return {size, unit * q.toRotationMatrix() * edge.asDiagonal(), unit * h.qoffset};
}

ImageGrid gridOfSform(const Header& h, const std::array<int, 3>& size, double unit) {
  return {size, unit * h.srow.leftCols<3>(), unit * h.srow.col(3)};
}

/// Whether the axes span space: no voxel is flat, and all numbers are finite and of a size that a scan can have.
bool isSound(const ImageGrid& grid) {
  const Vec3 edge = grid.spacing();
  return grid.axes.allFinite() && grid.origin.allFinite() && edge.minCoeff() > 1e-9 && edge.maxCoeff() < 1e3 &&
         grid.origin.norm() < 1e6 && grid.voxelVolume() > 1e-6 * edge.prod();
}

/// The largest distance between the same corner of two grids, m.
double cornerDistance(const ImageGrid& a, const ImageGrid& b) {
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 index = a.corner(corner);
    largest = std::max(largest, (a.worldOf(index) - b.worldOf(index)).norm());
  }
  return largest;
}

ImageGrid gridOf(const Header& h, const std::array<int, 3>& size, const std::string& name,
                 const NiftiOptions& options) {
  const double unit = unitOf(h);
  if (h.sform_code > 0) {
    const ImageGrid grid = gridOfSform(h, size, unit);
    if (!isSound(grid))
      refuse(name, "its sform is corrupt: the voxels would have no volume, or no place in space",
             "have it written anew by the program that made it");
    if (h.qform_code > 0 && options.warn) {
      const ImageGrid other = gridOfQform(h, size, unit);
      const double distance = isSound(other) ? cornerDistance(grid, other) : 0;
      if (distance > 0.1 * mm)
        options.warn(name + ": sform and qform put the image's corners up to " + format("%.3g", distance / mm) +
                     " mm apart; the sform is used");
    }
    return grid;
  }
  if (h.qform_code > 0) {
    const ImageGrid grid = gridOfQform(h, size, unit);
    if (!isSound(grid))
      refuse(name, "its qform is corrupt: the voxels would have no volume, or no place in space",
             "have it written anew by the program that made it");
    return grid;
  }
  if (!options.assume_ras)
    refuse(name, "the header does not say how the image lies in space (neither sform nor qform)",
           "find out which side is left, and set the sform; --assume-ras takes the axes as right, anterior, superior");
  const Vec3 edge(h.pixdim[1], h.pixdim[2], h.pixdim[3]);
  const ImageGrid grid(size, unit * Mat3(edge.cwiseAbs().asDiagonal()), Vec3::Zero());
  if (!isSound(grid)) refuse(name, "the header gives the voxels no size", "have it written anew");
  return grid;
}

/// Passes over the bytes before the voxels.
void skip(GzipReader& reader, std::size_t count, const std::string& name) {
  char buffer[4096];
  while (count != 0) {
    const std::size_t got = reader.read(buffer, std::min(count, sizeof buffer));
    if (got == 0) refuse(name, "the file ends before the voxels begin", "copy it again");
    count -= got;
  }
}

/// Reads the voxels in pieces, so that no more memory is taken than the image needs.
void readValues(GzipReader& reader, const Header& h, const StoredType& type, const std::string& name, Image& image,
                const NiftiOptions& options) {
  // No number, as some programs write it, and 0 say that nothing is scaled.
  if (std::isinf(h.slope) || std::isinf(h.intercept))
    refuse(name, "the header scales the voxels' values by infinity (scl_slope, scl_inter)",
           "have it written anew by the program that made it");
  const bool scaled = std::isfinite(h.slope) && h.slope != 0;
  const double slope = scaled ? h.slope : 1, intercept = scaled && std::isfinite(h.intercept) ? h.intercept : 0;
  const auto bytes = static_cast<std::size_t>(type.bytes);
  const std::size_t count = image.grid.voxelCount();
  image.value.reserve(count);
  std::string piece(std::min<std::size_t>(count * bytes, 1 << 20), '\0');
  std::size_t not_finite = 0;
  while (image.value.size() < count) {
    const std::size_t wanted = std::min(piece.size() / bytes, count - image.value.size()) * bytes;
    if (reader.read(piece.data(), wanted) != wanted)
      refuse(name,
             "the file is cut short: of " + std::to_string(count) + " voxels it has fewer than " +
                 std::to_string(image.value.size() + wanted / bytes),
             "copy it again");
    for (std::size_t at = 0; at < wanted; at += bytes) {
      const double value = slope * type.value(piece, at, h.swapped) + intercept;
      const bool finite = std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max());
      not_finite += finite ? 0 : 1;
      image.value.push_back(finite ? static_cast<float>(value) : 0.0F);
    }
  }
  char beyond = 0;
  reader.read(&beyond, 1);  // takes the end of the gzip data, too, whose checksum says whether all of it is right
  if (not_finite != 0 && options.warn)
    options.warn(name + ": " + std::to_string(not_finite) + " voxels are no finite number, and are taken for 0");
}

}  // namespace

Image imageFromNifti(std::string_view bytes, const std::string& name, const NiftiOptions& options) {
  try {
    GzipReader reader(bytes);
    std::string start(nifti::header_bytes_2, '\0');
    start.resize(reader.read(start.data(), start.size()));
    const Header h = nifti::readHeader(start, name);
    const std::array<int, 3> size = sizeOf(h, name);
    const StoredType& type = storedType(h, name);
    // Some writers leave the offset of a single file 0.
    const auto first = static_cast<double>(h.bytes + nifti::extension_bytes);
    const double offset = h.vox_offset == 0 ? first : h.vox_offset;
    Image image;
    image.grid = gridOf(h, size, name, options);
    const auto data = static_cast<double>(image.grid.voxelCount()) * type.bytes;
    if (!(offset >= static_cast<double>(h.bytes)) || offset != std::floor(offset) ||
        offset + data > static_cast<double>(reader.maxSize()))
      refuse(name,
             "the file is too short for " + std::to_string(image.grid.voxelCount()) + " voxels from byte " +
                 format("%.17g", offset) + " on",
             "it is cut short or damaged: copy it again");
    GzipReader again(bytes);
    skip(again, static_cast<std::size_t>(offset), name);
    readValues(again, h, type, name, image, options);
    return image;
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& error) {  // of the gzip reader
    throw InputError({name}, error.what(), "copy the file again");
  }
}

}  // namespace palpate
