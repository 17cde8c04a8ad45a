#include "app/run/composition.h"

#include "app/render/pick.h"
#include "step/node_passes.h"

namespace palpate::app {

namespace {
constexpr double mark_radius = 0.003;  // m, of the ball that shows a mark
}

Camera startCamera(const Model& model, const Layout& layout, const CanvasSize& size) {
  Camera camera = Camera::of(model);
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

void frameOrgan(Camera& camera, const OrganView& organ, const Layout& layout, const CanvasSize& size) {
  // The free part sees a share of the picture's height: a sphere that much larger,
  // framed in a picture of the free part's shape, then fits into it.
  const double share = static_cast<double>(layout.view.height) / size.height;
  camera.frame(organ.centre(), organ.radius() / share, static_cast<int>(layout.view.width),
               static_cast<int>(layout.view.height));
}

UserActions drawComposition(OrganView& organ, Interface& ui, const Session& session, const Snapshot& snapshot,
                            View& view, PanelState& panels, const Layout& layout, const CanvasSize& size,
                            const Shown& shown) {
  View drawn = view;
  drawn.camera = centredIn(layout, view.camera, size);
  const bool past = shown.timeline && shown.timeline->past;
  if (past) drawn.pulled_vertex = -1;
  const TaskScore* task = session.task();
  if (session.searching()) drawn.shutInside();
  if (drawn.ghost || drawn.section.on) drawn.balls = ballsInside(modelOf(snapshot, session.model()), snapshot.u);
  if (task != nullptr)
    for (const LumpMark& mark : task->marks()) drawn.balls.push_back({mark.place, mark_radius});
  if (task != nullptr) drawn.skin_values = &task->pressureMap();
  drawn.pixel_ratio = size.pixel_ratio * ui.theme().scale;
  const ColourScale scale = organ.draw(snapshot, drawn, size.pixelWidth(), size.pixelHeight());

  PanelData data = session.panelData(snapshot);
  data.colour_scale = scale;
  data.frames_per_second = shown.frames_per_second;
  if (drawn.pulled_vertex >= 0) {  // by the skin as it was just drawn
    const Model& model = modelOf(snapshot, session.model());
    const Vec3 skin = organ.skinPositions()[static_cast<std::size_t>(drawn.pulled_vertex)].cast<double>();
    data.pull_N = pullForce(model, drawn.pulled_vertex, drawn.pull_target - skin, model.inverse_mass.data(),
                            Integrator(model.dt, model.scene.dynamics.damping).alpha)
                      .norm();
  }
  if (!session.options().offscreen) {
    const Eigen::Vector2d corner(layout.view.x, layout.view.y), room(layout.view.width, layout.view.height);
    const double ratio = size.pixel_ratio;
    data.out_of_view =
        !isSeen(session.model().skin.surface, organ.skinPositions(), drawn.camera,
                Eigen::AlignedBox2d(ratio * corner, ratio * (corner + room)), size.pixelWidth(), size.pixelHeight());
  }
  data.attracts = shown.attracts;
  data.hand_on_skin = shown.hand_on_skin;
  data.hand_presses = shown.hand_presses;
  data.widest_jaws_m = shown.widest_jaws_m;
  data.scenes = shown.scenes;
  data.timeless = !shown.timing;
  data.timeline = shown.timeline;
  if (past) {  // all of that moment
    data.notice.reset();
    data.past_forces = shown.past_forces;
    data.presses = nullptr;
  }
  UserActions asked = drawPanels(ui.theme(), data, layout, panels, view);
  ui.end();
  return asked;
}

}  // namespace palpate::app
