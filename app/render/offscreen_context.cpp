#include "app/render/offscreen_context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "base/number_text.h"

namespace palpate::app {
namespace {

bool has(const char* extensions, const char* name) {
  // Names are separated by blanks and may be parts of others.
  const std::size_t length = std::strlen(name);
  for (const char* p = extensions; p && (p = std::strstr(p, name)); p += length)
    if ((p == extensions || p[-1] == ' ') && (p[length] == ' ' || p[length] == '\0')) return true;
  return false;
}

std::runtime_error failure(const std::string& what) {
  const std::string code = format("0x%x", static_cast<unsigned>(eglGetError()));
  return std::runtime_error("off-screen drawing: " + what + " (EGL error " + code +
                            "); install Mesa's software renderer: apt install libegl1 libegl-mesa0 libgl1-mesa-dri");
}

/// A display that needs no window system where the platform offers one, else the default display.
EGLDisplay openDisplay() {
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (has(client, "EGL_EXT_platform_base") && has(client, "EGL_MESA_platform_surfaceless")) {
    const EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr)) return display;
  }
  if (has(client, "EGL_EXT_platform_base") && has(client, "EGL_EXT_platform_device") &&
      has(client, "EGL_EXT_device_enumeration")) {
    EGLDeviceEXT device{};
    EGLint count = 0;
    if (eglQueryDevicesEXT(1, &device, &count) && count == 1) {
      const EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr);
      if (display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr)) return display;
    }
  }
  const EGLDisplay display = eglGetDisplay(EGL_DEFAULT_DISPLAY);
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr))
    throw failure("EGL opens no display, neither surfaceless nor a device nor the default one");
  return display;
}

EGLContext makeContext(EGLDisplay display) {
  if (!has(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context"))
    throw failure("EGL lacks EGL_KHR_surfaceless_context");
  if (!eglBindAPI(EGL_OPENGL_API)) throw failure("EGL offers no desktop OpenGL");
  constexpr EGLint config_wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint config_count = 0;
  if (!eglChooseConfig(display, config_wanted, &config, 1, &config_count) || config_count == 0)
    throw failure("EGL has no configuration for OpenGL");
  constexpr EGLint wanted[] = {
      EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
      EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, wanted);
  if (context == EGL_NO_CONTEXT) throw failure("the driver makes no OpenGL 3.3 core context");
  if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
    const std::runtime_error error = failure("the context can't be made current without a surface");
    eglDestroyContext(display, context);
    throw error;
  }
  return context;
}

}  // namespace

// The display is the process's: other contexts may share it, so it is never terminated.
OffscreenContext::OffscreenContext() : display_(openDisplay()), context_(makeContext(display_)) {}

OffscreenContext::~OffscreenContext() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
}

std::string OffscreenContext::description() const {
  const auto text = [](GLenum name) { return reinterpret_cast<const char*>(glGetString(name)); };
  return std::string(text(GL_RENDERER)) + ", OpenGL " + text(GL_VERSION);
}

}  // namespace palpate::app
