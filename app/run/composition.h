#pragma once

#include <span>
#include <string>

#include "app/panels/layout.h"
#include "app/render/interface.h"
#include "app/render/organ_view.h"
#include "app/render/view.h"
#include "app/run/session.h"

namespace palpate::app {

/// A picture's size. ImGui counts in screen units, OpenGL in framebuffer pixels.
struct CanvasSize {
  int width = 0, height = 0;  // screen units
  float pixel_ratio = 1;      // framebuffer pixels per screen unit

  int pixelWidth() const { return static_cast<int>(static_cast<float>(width) * pixel_ratio + 0.5F); }
  int pixelHeight() const { return static_cast<int>(static_cast<float>(height) * pixel_ratio + 0.5F); }
};

/// The camera that the scene asks for, further away by as much as the panels take of the height.
Camera startCamera(const Model& model, const Layout& layout, const CanvasSize& size);

/// `camera`, moved aside so that its target stands in the middle of the part of the
/// picture that the panels leave free.
Camera centredIn(const Layout& layout, const Camera& camera, const CanvasSize& size);

/// Brings the whole organ into that part of the picture.
void frameOrgan(Camera& camera, const OrganView& organ, const Layout& layout, const CanvasSize& size);

/// What the panels show of the window beside the session.
struct Shown {
  double frames_per_second = 0;
  bool hand_on_skin = false, hand_presses = false;
  double widest_jaws_m = 0;
  std::span<const std::string> scenes{};
  std::optional<TimelineView> timeline{};
  const ForceHistory* past_forces = nullptr;  // up to the earlier moment that is looked at; null: to the present
  bool attracts = false;                      // the demo plays by itself
  bool timing = true;                         // what the clock says of this machine
};

/// Draws organ and panels into the framebuffer that is bound, between ui.begin() and
/// the buffers' swap: the same for window and off-screen run.
UserActions drawComposition(OrganView& organ, Interface& ui, const Session& session, const Snapshot& snapshot,
                            View& view, PanelState& panels, const Layout& layout, const CanvasSize& size,
                            const Shown& shown);

}  // namespace palpate::app
