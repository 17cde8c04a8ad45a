#pragma once

#include <optional>

#include "app/render/framebuffer.h"
#include "app/render/interface.h"
#include "app/render/offscreen_context.h"
#include "app/render/picture.h"

struct ImDrawList;

namespace palpate::app {

/// A white sheet to draw lines, areas and text on without a window. Owns its OpenGL and
/// Dear ImGui contexts, which stay current: one canvas at a time, used by one thread.
class Canvas {
 public:
  /// Throws std::runtime_error that says what EGL lacks and what to install.
  Canvas();

  /// A fresh sheet of this size, px. Until end(), OpenGL draws onto it as well, below what
  /// the list holds. Coordinates of the list are px from the upper left corner.
  ImDrawList& begin(int width, int height);

  /// What was drawn.
  Picture end();

  const Theme& theme() const { return ui_.theme(); }

 private:
  OffscreenContext context_;
  Interface ui_;
  std::optional<Framebuffer> framebuffer_;
};

}  // namespace palpate::app
