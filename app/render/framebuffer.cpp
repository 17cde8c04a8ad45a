#include "app/render/framebuffer.h"

#include <string>

namespace palpate::app {

Framebuffer::Framebuffer(int width, int height) : width_(width), height_(height) {
  glBindRenderbuffer(GL_RENDERBUFFER, colour_);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
  glBindRenderbuffer(GL_RENDERBUFFER, 0);
  bind();
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
  requireComplete(("picture of " + std::to_string(width) + "x" + std::to_string(height) + " pixels").c_str());
}

void Framebuffer::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, width_, height_);
}

Picture Framebuffer::read() const {
  Picture picture{width_, height_, {}};
  const std::size_t row = 3 * static_cast<std::size_t>(width_);
  std::vector<std::uint8_t> lower_first(row * height_);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, lower_first.data());
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  picture.rgb.reserve(lower_first.size());
  for (int y = height_ - 1; y >= 0; --y)
    picture.rgb.insert(picture.rgb.end(), lower_first.begin() + y * row, lower_first.begin() + (y + 1) * row);
  return picture;
}

}  // namespace palpate::app
