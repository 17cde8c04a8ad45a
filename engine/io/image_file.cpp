#include "io/image_file.h"

#include <cstdint>

#include "io/output_file.h"
#include "io/text_file.h"

namespace palpate {
namespace {

constexpr std::uintmax_t max_image_bytes = std::uintmax_t{8} << 30;  // all voxels that an image may have, as doubles

bool isCompressed(const std::string& path) { return path.ends_with(".gz"); }

}  // namespace

Image readImage(const std::string& path, const NiftiOptions& options, const SourceLocation& asked_from) {
  return imageFromNifti(readWholeFile(path, asked_from, max_image_bytes), path, options);
}

void writeImage(const std::string& path, const Image& image, NiftiType type, double slope) {
  writeWholeFile(path, niftiFrom(image, type, isCompressed(path), slope));
}

void writeImage(const std::string& path, const Mask& mask) {
  Image image;
  image.grid = mask.grid;
  image.value.assign(mask.value.begin(), mask.value.end());
  writeImage(path, image, NiftiType::UInt8);
}

void writeImage(const std::string& path, const VectorImage& field) {
  writeWholeFile(path, niftiFrom(field, isCompressed(path)));
}

}  // namespace palpate
