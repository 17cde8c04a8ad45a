#pragma once

#include "app/render/gl_object.h"

namespace palpate::app {

/// Colour and depth with four samples per pixel, in which the picture is drawn.
class MultisampleTarget {
 public:
  /// Binds it for drawing with the viewport over all of it; makes it anew when the size changed.
  void bind(int width, int height);

  /// Averages the samples of each pixel into the lower left corner of another framebuffer.
  void resolveInto(GLuint framebuffer) const;

 private:
  GlFramebuffer framebuffer_;
  GlRenderbuffer colour_, depth_;
  int width_ = 0, height_ = 0;
};

}  // namespace palpate::app
