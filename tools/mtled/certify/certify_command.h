#pragma once

#include <string>
#include <vector>

#include "io/certificate.h"
#include "mtled/run/converged_run.h"

namespace palpate::tools {

struct CertifyOptions {
  std::string scene;        // file, or the name of one in assets/scenes
  std::string tool_script;  // "": the scene's own, or the built-in indentation
  std::string out;          // "": beside the scene
  int threads = 0;          // 0: all cores
  bool use_cache = true;
};

/// Follows the scene's tool on its own cloud and on two finer ones, extrapolates, and writes the error of force and
/// displacement over depth beside the scene (io/certificate.h), where `palpate` finds it.
///
///   F* = F_f + (F_f - F_c) / (r^2 - 1),   error = |F - F*| / |F*|,   uncertainty = |F* - F_f| / |F*|
///
/// each the largest of the ticks from one depth to the next, with r the ratio of the two finer spacings: Richardson's
/// extrapolation of what converges with their square (Roache 1998). Where not even the finest sees all of a thin layer,
/// the uncertainty is no less than that makes it (thin_layers.h), and certify says so. A scene of several tools or jaws
/// has no certificate, as its force depends on more than a depth: its errors over the time of its scripts are printed.
/// @return 0 done, 1 interrupted or not sound
/// Throws InputError for unusable input, std::runtime_error where a solution or a file fails.
int certifyCommand(const CertifyOptions& options);

/// The rows of a certificate: the error of `run` against what the two finer runs extrapolate to, between some values of
/// `advance`; of several forces in a tick, that of all together.
/// @param advance  (tick_count) what the rows go by: advances() or time
/// @param ratio    of the two finer spacings, > 1
std::vector<Certificate::Row> certifiedRows(const std::vector<double>& advance, const ScriptedRun& run,
                                            const ConvergedRun& converged, double ratio, int count);

/// (tick_count) m, of the first tool's tip along its axis past first touch.
std::vector<double> advances(const Model& model, const ToolTrajectory& way);

/// The first tool's way, as a certificate keeps it: a posture wherever the tip went on by a tenth of the touching
/// radius (touchRadius), or turned by a degree.
std::vector<Pose> certifiedPoses(const Model& model, const ToolTrajectory& way);

}  // namespace palpate::tools
