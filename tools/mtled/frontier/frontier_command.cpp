#include "mtled/frontier/frontier_command.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "base/build_info.h"
#include "base/interrupt.h"
#include "base/parallel_for.h"
#include "io/find_asset.h"
#include "io/indent_script.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/scene_file.h"
#include "io/text_file.h"
#include "mtled/frontier/frontier_page.h"
#include "mtled/frontier/frontier_result.h"
#include "mtled/frontier/frontier_settings.h"
#include "mtled/run/converged_run.h"
#include "mtled/run/progress.h"

namespace palpate::tools {
namespace {

constexpr int probe_count = 400;

std::string whyNot(const ScriptedRun& run) {
  if (run.flags & (kNotFinite | kBlowUp)) return "blew up after " + std::to_string(run.force.size()) + " ticks";
  return "points turned inside out";
}

/// @param present  the scene as it is; it is turned here
FrontierRow measure(const FrontierSetting& setting, const Model& present, const ToolTrajectory& way,
                    const std::vector<Vec3>& probes, const ScriptedRun& reference) {
  FrontierRow row;
  row.group = setting.group;
  row.name = setting.name;
  row.error = {NAN, NAN};
  row.cost = {NAN, NAN, NAN};
  row.realtime_factor = NAN;
  Scene scene = present.scene;
  setting.turn(scene);
  row.threads = setting.threads > 0 ? setting.threads : scene.dynamics.threads;
  try {
    const Model model = loadModel(scene);
    row.nodes = model.nodeCount();
    row.points = model.pointCount();
    row.substeps = model.substeps_per_tick;
    row.dt = model.dt;
    row.setup_seconds = model.setup_seconds;
    const ScriptedRun run = runTrajectory(model, way, probes, row.threads, setting.in_double);
    if (run.interrupted) return row;
    row.min_J = run.min_J;
    row.cost = costOf(run, scene.dynamics.rate_hz);
    row.realtime_factor = 1000 / row.cost.us_per_ms;
    row.peak_force = run.peakForce();
    if (run.sound())
      row.error = errorOf(run, reference);
    else
      row.trouble = whyNot(run);
  } catch (const InputError& error) {
    row.trouble = error.what();  // a setting that this scene can't have
  } catch (const std::runtime_error&) {
    if (!interrupted()) throw;
  }
  return row;
}

std::string commandOf(const FrontierOptions& options) {
  std::string command = "build/release/tools/mtled frontier " + options.scene;
  if (!options.tool_script.empty()) command += " --tool " + options.tool_script;
  if (options.quick) command += " --quick";
  return command + " --report " + options.report;
}

}  // namespace

int frontierCommand(const FrontierOptions& options) {
  const Scene scene = uniformScene(readScene(findScene(options.scene)));
  const std::optional<ToolScript> script = namedScript(options.tool_script, scene.tools[0].shape.radius);
  const std::string folder = options.out.empty() ? "out/" + scene.name + "_frontier" : options.out;
  makeFolder(folder);
  if (!options.report.empty()) makeFolder(options.report);
  const int cores = threadsOr(0);
  const Fineness fineness = options.quick ? Fineness{0.9, 0.5, 1.35} : Fineness{0.75, 0.4, 1.35};

  ProgressLine progress("frontier");
  progress.show(0, "set-up");
  const Model present = loadModel(scene, {}, ModelCache(), warn);
  const ToolTrajectory way = scriptedTrajectory(present, script);
  const auto probes = surfaceProbes(present, probe_count);
  const std::vector<ContactRegion> places = contactRegions(present, way);
  const auto settings = frontierSettings(scene, places, options.quick, cores);

  Frontier frontier;
  frontier.scene = scene.name;
  frontier.way = options.tool_script.empty() ? "built-in indentation" : options.tool_script;
  frontier.build = buildInfo();
  frontier.identity = runIdentity(present, way, {fineness.outside, fineness.inside});
  frontier.rate_hz = scene.dynamics.rate_hz;
  std::vector<FrontierRow> earlier;
  if (options.resume) {
    const std::string file = folder + "/frontier.json";
    const std::string text = std::filesystem::exists(file) ? readWholeFile(file) : "";
    if (text.empty()) throw InputError({file}, "there is nothing to resume", "start without --resume");
    const Frontier before = frontierFromJson(text);
    if (before.identity != frontier.identity)
      throw InputError({file}, "this is of another scene, way, program or --quick", "start without --resume");
    earlier = before.rows;
  }

  const double share = 0.4;  // of the time, for the reference
  ConvergedRun converged;
  const std::string reference_file = folder + "/reference.json";
  if (!options.resume || !readConvergedRun(reference_file, frontier.identity, converged)) {
    converged = convergedRun(present, way, probes, places, fineness, cores,
                             [&](double fraction, const std::string& what) { progress.show(share * fraction, what); });
    writeConvergedRun(reference_file, converged, frontier.identity);
  }
  frontier.reference = converged.about;

  bool stopped = false;
  for (std::size_t k = 0; k < settings.size() && !stopped; ++k) {
    progress.show(share + (1 - share) * static_cast<double>(k) / static_cast<double>(settings.size()),
                  settings[k].name);
    const auto done =
        std::find_if(earlier.begin(), earlier.end(), [&](const FrontierRow& r) { return r.name == settings[k].name; });
    FrontierRow row = done != earlier.end() ? *done : measure(settings[k], present, way, probes, converged.run);
    stopped = interrupted();
    if (stopped) break;
    frontier.rows.push_back(std::move(row));
    writeWholeFile(folder + "/frontier.csv", csvOf(frontier));
    writeWholeFile(folder + "/frontier.json", jsonOf(frontier));
  }
  std::string picture = "none: no setting was measured";
  if (!frontier.rows.empty()) {
    picture = writePicture(folder + "/frontier.png", frontierFigure(frontier));
    if (!options.report.empty()) writeFrontierPage(options.report, commandOf(options), frontier);
  }
  progress.show(1, "done");
  printFrontier(std::cout, frontier);
  std::cout << "table        " << folder << "/frontier.csv\nresults      " << folder << "/frontier.json\npicture      "
            << picture << std::endl;
  if (stopped) std::cerr << "mtled: interrupted; --resume goes on with the next setting\n";
  return stopped ? 1 : 0;
}

}  // namespace palpate::tools
