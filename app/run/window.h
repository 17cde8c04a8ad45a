#pragma once

#include <functional>
#include <string>

#include "app/panels/log.h"
#include "app/run/options.h"
#include "scene/scene.h"

namespace palpate::app {

class Session;
class Viewer;

/// Called after each picture of a session, on the main thread: sees what a user would see.
using FrameWatch = std::function<void(Session&, Viewer&)>;

/// Shows sessions in a window until the user quits or a run ends: the first made of `options` and `scene`, with the
/// set-up's progress in the window, then whatever the user opens. Writes results where the options ask for them.
/// @return why the last run counts as failed though its files are kept; empty: it does not
/// Throws what the making of the first session throws, std::runtime_error without a display.
std::string runWindow(const Options& options, const Scene& scene, Log& log, const FrameWatch& watch = {});

}  // namespace palpate::app
