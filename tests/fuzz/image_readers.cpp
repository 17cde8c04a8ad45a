#include <algorithm>
#include <cmath>

#include "fuzz/reader.h"
#include "imaging/gzip.h"
#include "imaging/nifti.h"

namespace palpate::fuzz {

namespace {

Image smallImage() {
  Mat3 axes;
  axes << -1e-3, 1e-4, 0, 0, 2e-3, 3e-4, 0, 0, 1.5e-3;
  Image image(ImageGrid({4, 3, 2}, axes, Vec3(0.1, -0.02, 0.03)));
  for (std::size_t v = 0; v < image.value.size(); ++v) image.value[v] = static_cast<float>(v) - 7.5F;
  return image;
}

std::vector<std::string> niftiSeeds() {
  const Image image = smallImage();
  std::string swapped = niftiFrom(image, NiftiType::UInt8, false);  // a header of the other byte order
  const auto turn = [&](std::size_t at, std::size_t size) { std::reverse(&swapped[at], &swapped[at] + size); };
  turn(0, 4);
  for (std::size_t at = 40; at < 56; at += 2) turn(at, 2);
  for (const std::size_t at : {68U, 70U, 72U, 252U, 254U}) turn(at, 2);
  for (std::size_t at = 76; at < 120; at += 4) turn(at, 4);
  for (std::size_t at = 256; at < 328; at += 4) turn(at, 4);
  return {niftiFrom(image, NiftiType::Float32, false), niftiFrom(image, NiftiType::Int16, true), swapped,
          niftiFrom(Image(ImageGrid({1, 40000, 1}, Mat3::Identity() * 1e-3, Vec3::Zero())), NiftiType::UInt8, true)};
}

/// What was read lies somewhere, has the values that it says, and can be written and read again.
void readNiftiFrom(const std::string& bytes) {
  NiftiOptions options;
  options.warn = [](const std::string& text) { hold(!text.empty(), "a warning that says nothing"); };
  const Image image = imageFromNifti(bytes, "input.nii", options);
  const std::size_t count = image.grid.voxelCount();
  hold(count > 0 && image.value.size() == count, "voxels and size differ");
  hold(image.value.capacity() <= count + 16, "more memory than the image needs");
  hold(count <= GzipReader(bytes).maxSize(), "more voxels than the bytes can hold");
  hold(image.grid.axes.allFinite() && image.grid.inverse.allFinite() && image.grid.origin.allFinite(),
       "an image that lies nowhere");
  for (const float value : image.value) hold(std::isfinite(value), "a voxel that is no number");
  if (count > 4096) return;  // writing and reading costs more than the first reading
  const Image again = imageFromNifti(niftiFrom(image, NiftiType::Float32, count % 2 == 0), "again.nii", options);
  hold(again.grid.size == image.grid.size && again.value == image.value, "written and read it is another image");
}

}  // namespace

const Reader nifti_reader = {"nifti", niftiSeeds, readNiftiFrom};

}  // namespace palpate::fuzz
