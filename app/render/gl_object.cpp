#include "app/render/gl_object.h"

#include <stdexcept>
#include <string>

namespace palpate::app {

void requireComplete(const char* what) {
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    throw std::runtime_error(std::string("OpenGL can't draw into the ") + what + " (framebuffer status " +
                             std::to_string(status) + ")");
}

}  // namespace palpate::app
