#pragma once

#include <epoxy/gl.h>

#include <utility>

namespace palpate::app {

/// Owns one OpenGL name; `Kind` makes and deletes it. Movable, not copyable.
template <class Kind>
class GlObject {
 public:
  GlObject() : name_(Kind::make()) {}
  ~GlObject() {
    if (name_ != 0) Kind::drop(name_);
  }
  GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  operator GLuint() const { return name_; }

 private:
  GLuint name_;
};

// epoxy's entry points are macros over function pointers that are resolved at the first call,
// so they can't be template arguments.
#define PALPATE_GL_KIND(Kind, Make, Drop)             \
  struct Kind {                                       \
    static GLuint make() {                            \
      GLuint name = 0;                                \
      Make(1, &name);                                 \
      return name;                                    \
    }                                                 \
    static void drop(GLuint name) { Drop(1, &name); } \
  };
PALPATE_GL_KIND(BufferKind, glGenBuffers, glDeleteBuffers)
PALPATE_GL_KIND(VertexArrayKind, glGenVertexArrays, glDeleteVertexArrays)
PALPATE_GL_KIND(TextureKind, glGenTextures, glDeleteTextures)
PALPATE_GL_KIND(RenderbufferKind, glGenRenderbuffers, glDeleteRenderbuffers)
PALPATE_GL_KIND(FramebufferKind, glGenFramebuffers, glDeleteFramebuffers)
#undef PALPATE_GL_KIND

using GlBuffer = GlObject<BufferKind>;
using GlVertexArray = GlObject<VertexArrayKind>;
using GlTexture = GlObject<TextureKind>;
using GlRenderbuffer = GlObject<RenderbufferKind>;
using GlFramebuffer = GlObject<FramebufferKind>;

/// Throws std::runtime_error unless what is bound to GL_FRAMEBUFFER can be drawn into.
void requireComplete(const char* what);

}  // namespace palpate::app
