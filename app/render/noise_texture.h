#pragma once

#include "app/render/gl_object.h"

namespace palpate::app {

/// A periodic cube of smooth gradient noise, the same on every run: alpha holds the value,
/// rgb its gradient, both with 0.5 for zero. What makes tissue look uneven and slightly bumpy.
class NoiseTexture {
 public:
  NoiseTexture();
  GLuint texture() const { return texture_; }

 private:
  GlTexture texture_;
};

}  // namespace palpate::app
