#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "app/render/colour_map.h"
#include "app/render/view.h"
#include "model/body.h"
#include "realtime/channels/snapshot.h"

namespace palpate::app {

/// Draws a model's snapshots with OpenGL 3.3 core, the same in a window and off-screen.
/// All calls, the destructor's included, belong to one thread with one current context.
class Renderer {
 public:
  /// Compiles the shaders and fills the constant buffers. `model` must outlive the renderer.
  /// @param shader_dir  folder of the GLSL files, e.g. findShaderDir()
  /// @param whole_vertex  of a cut body (CutBody), whose snapshots tell of the whole one's skin; else empty
  /// Throws std::runtime_error that names file and line where a shader can't be used,
  /// or says what the context lacks.
  Renderer(const Body& model, const std::string& shader_dir, std::span<const int> whole_vertex = {});
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// The next snapshots are of this body, which has the same skin, but other nodes (setup/place.h).
  /// It must outlive the last of them that is drawn.
  void goOnWith(const Body& model);

  /// Fills the framebuffer that is bound for drawing (the window's, or a Framebuffer),
  /// pixels (0, 0) to (width, height), with a whole, anti-aliased picture. Needs no depth
  /// buffer and no multisampling there. Leaves that framebuffer bound, and blending,
  /// tests, program, vertex array, buffers and textures as a fresh context has them.
  /// @return the values that the skin's colours stand for
  ColourScale draw(const Snapshot& snapshot, const View& view, int framebuffer_width, int framebuffer_height);

  /// The skin's vertices as last drawn (before: at rest), m   (skin vertex_count)
  const std::vector<Vec3f>& skinPositions() const;

  /// A sphere around the organ at rest, for Camera::frame.
  Vec3 centre() const;
  double radius() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// The folder of the shaders: $PALPATE_SHADER_DIR; else shaders/ of dataFolder(), which is that of an installed program
/// or library, else the source tree; else shaders/ beside the executable.
/// Throws std::runtime_error that lists where it looked.
std::string findShaderDir();

}  // namespace palpate::app
