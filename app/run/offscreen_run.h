#pragma once

#include "app/run/run_checks.h"
#include "app/run/session.h"

namespace palpate::app {

/// Reads what the run is to be compared with, and throws InputError where that can't be used: before the set-up.
void checkReferences(const Options& options, const Scene& scene);

/// Runs a session to its end without a display and writes its results: pictures (at the very ticks that were asked
/// for), forces, report, manifest. Compares with references where the options name some.
/// @return the exit code (run_checks.h)
/// Throws InputError for a reference that can't be used, before the run.
int runOffscreen(Session& session);

/// manifest.json beside a session's results: what is given, and what the session knows itself.
void writeManifest(Session& session, Manifest manifest);

/// `palpate SCENE --check-lumps`: whether each lump is felt at the working depth, 0.8 tool radii. Returns the exit
/// code.
int checkLumps(const Options& options, Scene scene);

/// `palpate NEW.png --compare REFERENCE.png`: compares two pictures. Returns the exit code.
int comparePictures(const Options& options);

}  // namespace palpate::app
