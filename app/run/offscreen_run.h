#pragma once

#include "app/run/session.h"

namespace palpate::app {

/// Runs a session without a display to its end (or to SIGINT), then leaves snapshot.png,
/// force.csv and report.json in its result folder and prints where they are.
/// Throws std::runtime_error where there is no OpenGL at all or a file can't be written.
void runOffscreen(Session& session);

}  // namespace palpate::app
