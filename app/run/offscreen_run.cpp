#include "app/run/offscreen_run.h"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <optional>
#include <thread>

#include "app/render/framebuffer.h"
#include "app/render/offscreen_context.h"
#include "app/run/composition.h"
#include "base/interrupt.h"

namespace palpate::app {

namespace {

constexpr auto gather_every = std::chrono::milliseconds(2);  // far below what the loop's rings hold
constexpr double plain_width = 1280, plain_height = 800;     // px for which the panels are laid out at scale 1
constexpr int settling_frames = 3;                           // ImGui needs two to settle sizes, one to draw

Picture drawPicture(Renderer& renderer, Session& session, const Snapshot& snapshot) {
  const CanvasSize size{session.options().width, session.options().height, 1};
  const double scale = std::max(1.0, std::min(size.width / plain_width, size.height / plain_height));
  Interface ui(nullptr, static_cast<float>(scale));
  const Layout layout = layoutFor(size.width, size.height, ui.theme().scale, true);
  View view;
  view.camera = startCamera(session.model().scene, layout, size);
  PanelState panels;
  const Framebuffer framebuffer(size.width, size.height);
  for (int k = 0; k < settling_frames; ++k) {
    framebuffer.bind();
    ui.begin(size.width, size.height);
    drawComposition(renderer, ui, session, snapshot, view, panels, layout, size, 0);
  }
  return framebuffer.read();
}

}  // namespace

void runOffscreen(Session& session) {
  // First what may be missing, so that a long run is not for nothing.
  const OffscreenContext context;
  Renderer renderer(session.model(), findShaderDir());
  session.log().info("OpenGL: " + context.description());

  const auto snapshot_at = session.options().snapshot_at;
  std::optional<Snapshot> wanted;
  session.start();
  while (!session.finished() && !interrupted()) {
    session.gather();
    if (snapshot_at && !wanted && session.latest().force.time_s >= *snapshot_at) wanted = session.latest();
    std::this_thread::sleep_for(gather_every);
  }
  session.finish();
  if (interrupted()) session.log().info("interrupted: keeping what was done so far");

  ResultFolder& results = *session.results();
  results.writeReport(toJson(session.report()));
  results.writePicture(drawPicture(renderer, session, wanted ? *wanted : session.latest()));
  std::cout << "picture      " << results.pictureFile() << '\n';
  if (session.options().soak_minutes)
    std::cout << "soak         " << results.soakTextFile() << '\n';
  else
    std::cout << "force curve  " << results.forceFile() << '\n';
  std::cout << "report       " << results.reportFile() << std::endl;
}

}  // namespace palpate::app
