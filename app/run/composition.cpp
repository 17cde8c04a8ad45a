#include "app/run/composition.h"

namespace palpate::app {

Camera startCamera(const Scene& scene, const Layout& layout, const CanvasSize& size) {
  Camera camera = Camera::fromScene(scene);
  camera.distance *= static_cast<double>(size.height) / static_cast<double>(layout.view.height);
  return camera;
}

Camera centredIn(const Layout& layout, const Camera& camera, const CanvasSize& size) {
  const double aside = layout.view.x + 0.5 * layout.view.width - 0.5 * size.width;
  const double down = layout.view.y + 0.5 * layout.view.height - 0.5 * size.height;
  Camera shifted = camera;
  shifted.pan(aside * size.pixel_ratio, down * size.pixel_ratio, size.pixelHeight());
  return shifted;
}

void frameOrgan(Camera& camera, const Renderer& renderer, const Layout& layout, const CanvasSize& size) {
  // The free part sees a share of the picture's height: a sphere that much larger,
  // framed in a picture of the free part's shape, then fits into it.
  const double share = static_cast<double>(layout.view.height) / size.height;
  camera.frame(renderer.centre(), renderer.radius() / share, static_cast<int>(layout.view.width),
               static_cast<int>(layout.view.height));
}

PanelRequests drawComposition(Renderer& renderer, Interface& ui, const Session& session, const Snapshot& snapshot,
                              View& view, PanelState& panels, const Layout& layout, const CanvasSize& size,
                              double frames_per_second) {
  View drawn = view;
  drawn.camera = centredIn(layout, view.camera, size);
  drawn.pixel_ratio = size.pixel_ratio * ui.theme().scale;
  const ColourScale scale = renderer.draw(snapshot, drawn, size.pixelWidth(), size.pixelHeight());

  PanelData data = session.panelData(snapshot);
  data.colour_scale = scale;
  data.frames_per_second = frames_per_second;
  const PanelRequests requests = drawPanels(ui.theme(), data, layout, panels, view);
  ui.end();
  return requests;
}

}  // namespace palpate::app
