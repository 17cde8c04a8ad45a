#pragma once

#include "app/run/session.h"

namespace palpate::app {

/// Throws std::runtime_error that names --offscreen where there is no display.
void requireDisplay();

/// Runs a session in a window until the user quits, the run ends or SIGINT comes; then
/// writes what was asked for. The session's loop never waits for the window.
/// Throws std::runtime_error that names --offscreen where no window with OpenGL 3.3
/// can be made, and as ResultFolder does.
void runWindow(Session& session);

}  // namespace palpate::app
