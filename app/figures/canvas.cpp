#include "app/figures/canvas.h"

#include <epoxy/gl.h>
#include <imgui.h>

namespace palpate::app {

// Pictures are shown at about half their pixels, so that text is sharp on high-DPI screens.
constexpr float type_scale = 2;

Canvas::Canvas() : ui_(nullptr, type_scale) {}

ImDrawList& Canvas::begin(int width, int height) {
  if (!framebuffer_ || framebuffer_->width() != width || framebuffer_->height() != height)
    framebuffer_.emplace(width, height);
  framebuffer_->bind();
  glClearColor(1, 1, 1, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  glClearColor(0, 0, 0, 0);
  ui_.begin(width, height);
  return *ImGui::GetBackgroundDrawList();
}

Picture Canvas::end() {
  ui_.end();
  return framebuffer_->read();
}

}  // namespace palpate::app
