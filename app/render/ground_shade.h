#pragma once

#include "app/render/gl_object.h"
#include "app/render/shader_program.h"
#include "app/render/shadow_map.h"

namespace palpate::app {

/// How much light the organ and the tool take from the ground: red, of the key light (their
/// shadow, thrown along it onto the ground); green, of the room (what stands low above it).
/// Blurred, so it needs few texels and gives wide, smooth penumbras.
class GroundShade {
 public:
  explicit GroundShade(const std::string& shader_dir);

  /// @param ground  middle of the ground below the organ, m
  /// @param radius  of the organ, m
  void draw(const Vec3& key, const Vec3& ground, double radius, const DrawCasters& casters);

  GLuint texture() const { return shade_; }

 private:
  ShaderProgram cast_, blur_;
  GLint clip_from_local_, taken_, reach_, direction_, spread_;
  GlFramebuffer framebuffer_, scratch_framebuffer_;
  GlTexture shade_, scratch_;
  GlVertexArray no_vertices_;
};

}  // namespace palpate::app
