#pragma once

#include <string>

namespace palpate::app {

/// An OpenGL 3.3 core context without window or X server, through EGL; software
/// rendering (llvmpipe) is enough. Current on the thread that made it until destroyed.
/// Draw into a Framebuffer: there is no default one.
class OffscreenContext {
 public:
  /// Throws std::runtime_error that says what EGL lacks and what to install.
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

  /// Renderer and version as the driver names them, for reports.
  std::string description() const;

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;
};

}  // namespace palpate::app
