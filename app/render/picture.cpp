#include "app/render/picture.h"

#include <png.h>

#include <cstring>
#include <stdexcept>

#include "base/input_error.h"
#include "io/output_file.h"

namespace palpate::app {
namespace {

png_image emptyImage() {
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  return image;
}

}  // namespace

Picture readPng(const std::string& file) {
  const auto refuse = [&](const char* reason) {
    return InputError({file, 0, 0}, std::string("no readable PNG (") + reason + ")", "give an 8-bit PNG file");
  };
  png_image image = emptyImage();
  if (!png_image_begin_read_from_file(&image, file.c_str())) throw refuse(image.message);
  image.format = PNG_FORMAT_RGB;
  Picture picture{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  picture.rgb.resize(PNG_IMAGE_SIZE(image));
  const png_color black{0, 0, 0};  // under what is transparent
  if (!png_image_finish_read(&image, &black, picture.rgb.data(), 0, nullptr)) throw refuse(image.message);
  return picture;
}

void writePng(const std::string& file, const Picture& picture) {
  png_image image = emptyImage();
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.rgb.data(), 0, nullptr))
    throw std::runtime_error(file + ": can't encode the picture (" + image.message + ")");
  bytes.resize(size);
  writeWholeFile(file, bytes);
}

}  // namespace palpate::app
