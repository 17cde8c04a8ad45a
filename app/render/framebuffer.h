#pragma once

#include "app/render/gl_object.h"
#include "app/render/picture.h"

namespace palpate::app {

/// A colour image to draw into where there is no window: 8 bits per channel, no depth
/// (the renderer brings its own). Belongs to the context that was current when it was made.
class Framebuffer {
 public:
  /// Throws std::runtime_error when the context can't make one of this size.
  Framebuffer(int width, int height);

  /// Makes it the target of drawing, with the viewport over all of it.
  void bind() const;

  /// What was drawn, upper row first.
  Picture read() const;

  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int width_, height_;
  GlFramebuffer framebuffer_;
  GlRenderbuffer colour_;
};

}  // namespace palpate::app
