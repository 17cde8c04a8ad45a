#include "app/image/palpate_image.h"

#include <unistd.h>

#include <atomic>
#include <memory>
#include <optional>

#include "api/border.h"
#include "api/handles.h"
#include "app/render/framebuffer.h"
#include "app/render/offscreen_context.h"
#include "app/render/renderer.h"
#include "base/build_info.h"

using namespace palpate;
using namespace palpate::api;

namespace {

constexpr std::int32_t max_side = 8192;  // px; what OpenGL 3.3 drivers can draw into

/// What a thread keeps between its pictures.
class Painter {
 public:
  explicit Painter(std::shared_ptr<const Model> model)
      : model_(std::move(model)), renderer_(*model_, app::findShaderDir()) {}

  const Model* model() const { return model_.get(); }

  app::Picture draw(const Snapshot& snapshot, const app::Camera& camera, int width, int height) {
    if (!target_ || target_->width() != width || target_->height() != height) {
      target_.reset();
      target_.emplace(width, height);
    }
    target_->bind();
    app::View view;
    view.camera = camera;
    renderer_.draw(snapshot, view, width, height);
    return target_->read();
  }

 private:
  std::shared_ptr<const Model> model_;
  app::OffscreenContext context_;
  app::Renderer renderer_;
  std::optional<app::Framebuffer> target_;
};

thread_local std::unique_ptr<Painter> painter;
std::atomic<int> drawing_process{0};  // that drew first

/// OpenGL does not survive a fork: its threads and its line to the driver are the parent's.
void checkProcess() {
  int first = 0;
  if (!drawing_process.compare_exchange_strong(first, getpid()) && first != getpid())
    throw Refusal(PALPATE_REFUSED,
                  "this process was forked off one that has drawn already: draw in a process that was "
                  "started anew (Python: multiprocessing's \"spawn\"), or fork before the first picture");
}

/// The handle is another library's: its struct is known only where both have the same sources.
void checkTwin(const palpate_simulation& simulation) {
  if (simulation.identity != sourceIdentity())
    throw Refusal(PALPATE_REFUSED, "libpalpate_image is of another version than libpalpate; install both together");
}

app::Camera cameraFrom(const palpate_camera& c) {
  app::Camera camera;
  camera.target = {c.target[0], c.target[1], c.target[2]};
  camera.distance = c.distance;
  camera.azimuth_deg = c.azimuth_deg;
  camera.elevation_deg = c.elevation_deg;
  camera.fov_deg = c.fov_deg;
  const bool usable = camera.target.allFinite() && std::isfinite(c.azimuth_deg) && std::abs(c.elevation_deg) <= 90 &&
                      c.distance > 0 && c.distance < 1e6 && c.fov_deg > 0 && c.fov_deg < 180;
  if (!usable)
    throw Refusal(PALPATE_BAD_ARGUMENT,
                  "the camera must be finite, its distance 0 .. 1e6 m, its elevation -90 .. 90, its fov 0 .. 180");
  return camera;
}

}  // namespace

extern "C" {

int32_t palpate_scene_camera(const palpate_simulation* simulation, palpate_camera* camera) {
  if (simulation == nullptr) return PALPATE_BAD_ARGUMENT;
  const app::Camera c = app::Camera::of(*simulation->model);
  palpate_camera out{};
  put(c.target, out.target);
  out.distance = c.distance;
  out.azimuth_deg = c.azimuth_deg;
  out.elevation_deg = c.elevation_deg;
  out.fov_deg = c.fov_deg;
  return fill(camera, out);
}

int32_t palpate_image(palpate_simulation* simulation, const palpate_camera* camera, uint8_t* rgba, int32_t width,
                      int32_t height, palpate_error* error) {
  if (simulation == nullptr || rgba == nullptr || width < 1 || height < 1 || width > max_side || height > max_side)
    return say(error, PALPATE_BAD_ARGUMENT, "simulation or rgba is NULL, or the size is not in 1 .. 8192");
  return guarded(error, [&] {
    checkTwin(*simulation);
    checkProcess();
    const app::Camera wanted = camera != nullptr ? cameraFrom(given(camera)) : app::Camera::of(*simulation->model);
    if (!painter || painter->model() != simulation->model.get()) {
      painter.reset();  // before another context is made
      painter = std::make_unique<Painter>(simulation->model);
    }
    const app::Picture picture = painter->draw(simulation->loop.snapshots().latest(), wanted, width, height);
    const std::uint8_t* rgb = picture.rgb.data();
    for (std::int64_t p = 0; p < std::int64_t{width} * height; ++p, rgb += 3, rgba += 4) {
      std::copy_n(rgb, 3, rgba);
      rgba[3] = 255;
    }
    return PALPATE_OK;
  });
}

}  // extern "C"
