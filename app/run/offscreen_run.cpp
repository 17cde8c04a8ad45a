#include "app/run/offscreen_run.h"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <optional>
#include <thread>

#include "app/render/animation.h"
#include "app/render/framebuffer.h"
#include "app/render/offscreen_context.h"
#include "app/run/composition.h"
#include "app/run/run_checks.h"
#include "app/run/run_export.h"
#include "app/run/saved_files.h"
#include "app/trainer/feel_check.h"
#include "app/trainer/score_page.h"
#include "base/interrupt.h"
#include "base/key.h"
#include "base/number_text.h"
#include "contact/tools/tool_list.h"
#include "io/find_asset.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/text_file.h"
#include "model/model_hash.h"
#include "step/trust.h"

namespace palpate::app {

namespace {

constexpr auto gather_every = std::chrono::milliseconds(2);  // far below what the loop's rings hold
constexpr double plain_width = 1280, plain_height = 800;     // px for which the panels are laid out at scale 1
constexpr double animation_end_seconds = 2.5;                // that the last picture stays
constexpr double close_radii = 14;                           // of the tool, that --close looks from
constexpr int settling_frames = 3;                           // ImGui needs two to settle sizes, one to draw

Picture drawPicture(OrganView& organ, Session& session, const Snapshot& snapshot) {
  const Options& options = session.options();
  const CanvasSize size{options.width, options.height, 1};
  const double scale = std::max(1.0, std::min(size.width / plain_width, size.height / plain_height));
  Interface ui(nullptr, static_cast<float>(scale));
  PanelState panels;
  panels.panels_shown = options.picture.panels;
  panels.engineer = options.picture.timing;
  const Layout layout = layoutFor(size.width, size.height, ui.theme().scale, panels.panels_shown);
  View view;
  view.camera = startCamera(session.model(), layout, size);
  applyChoice(options.picture, view);
  if (options.picture.close) {
    view.camera.target = snapshot.toolPose().position;
    view.camera.distance =
        options.picture.distance_m.value_or(close_radii * session.model().scene.tools[0].shape.radius);
  }
  if (options.picture.cut)
    cutThroughTool(view.section, snapshot.toolPose(), view.camera, organ.centre(), organ.radius());
  Shown shown;
  shown.timing = options.picture.timing;
  const Framebuffer framebuffer(size.width, size.height);
  for (int k = 0; k < settling_frames; ++k) {
    framebuffer.bind();
    ui.begin(size.width, size.height);
    drawComposition(organ, ui, session, snapshot, view, panels, layout, size, shown);
  }
  return framebuffer.read();
}

Picture drawScorePage(OrganView& organ, Session& session, const SheetHead& head) {
  Interface ui(nullptr, 1);
  ui.begin(session.options().width, session.options().height);  // the fonts are ready after a frame
  ui.end();
  return scorePage(ui.theme(), session.model(), organ, *session.task(), head);
}

/// The references that the run is held to, read before it begins.
struct References {
  std::optional<Picture> picture;
  std::optional<Baseline> baseline;
};

/// The report that a run of the scene will have, but for its values.
RunReport blankReport(const Scene& scene) {
  RunReport report;
  const std::vector<ToolSpec>& tools = scene.tools;
  if (scene.discretization.follow) report.follow.emplace();
  if (tools.size() > 1 || tools[0].jaws()) report.tools.resize(tools.size());
  if (scene.organs.size() > 1)
    for (const OrganSpec& organ : scene.organs) report.organs.push_back({organ.name, Vec3::Zero()});
  for (const BoundarySpec& boundary : scene.boundaries) report.regions.push_back({boundary.name, {}});
  for (const RigidSpec& body : scene.rigid) report.rigid.push_back({body.name, Vec3::Zero(), 0, {}});
  return report;
}

References readReferences(const Options& options, const Scene& scene) {
  if (!options.offscreen) return {};
  References references;
  if (!options.compare.empty()) references.picture = readPng(options.compare);
  if (!options.expect.empty()) references.baseline.emplace(options.expect, toJson(blankReport(scene)));
  return references;
}

/// Runs to the end; where the options name times, `take` gets each of these ticks, at which the loop waits.
template <class Take>
void runAndTake(Session& session, const Take& take) {
  const std::vector<double>& times = session.options().snapshot_at;
  std::size_t taken = 0;
  session.start();
  while (!session.finished() && !interrupted()) {
    session.gather();
    if (taken < times.size() && session.latest().status.paused) {
      const std::int64_t tick = session.latest().status.ticks;
      take(times[taken++], session.latest());
      session.send(Request::simple(Request::Kind::Resume));
      while (session.latest().status.ticks == tick && !session.finished() && !interrupted()) {
        std::this_thread::sleep_for(gather_every);
        session.gather();
      }
      continue;
    }
    std::this_thread::sleep_for(gather_every);
  }
  session.finish();
  const double end = session.latest().force.time_s + 0.5 / session.model().scene.dynamics.rate_hz;
  for (; taken < times.size() && times[taken] <= end; ++taken) take(times[taken], session.latest());  // the last tick's
}

int exitCodeOf(Session& session, const References& references, const Picture& last, const std::string& report) {
  const Options& options = session.options();
  Log& log = session.log();
  int code = exit_code::done;
  if (references.picture) {
    const std::string image = session.results()->fileNamed("difference.png");
    const auto verdict = [&](const std::string& where) {
      return pictureDifference(*references.picture, last, options.tolerance, where);
    };
    std::string problem;
    if (!session.attempt([&] { problem = verdict(image); })) problem = verdict("");
    if (!problem.empty()) {
      log.error(problem);
      code = exit_code::differs;
    }
  }
  if (references.baseline)
    for (const std::string& line : references.baseline->differences(report)) {
      log.error(line);
      code = exit_code::differs;
    }
  const RunReport ended = session.report();
  if (ended.doubt == Doubt::Resolution)    // no tick of it was worth a line of its own
    log.warning(ended.expected_error == 1  // RunTrust's word for it
                    ? "the tool never touched for long enough to tell how far off its force is: hold it for a second"
                    : format("the force is expected to be off by some %.0f %%: ", 100 * ended.expected_error) +
                          doubtText(ended.doubt));
  if (options.strict && ended.doubt != Doubt::None) code = exit_code::doubted;
  if (session.report().frozen) code = exit_code::frozen;
  if (interrupted()) code = exit_code::interrupted;
  return code;
}

}  // namespace

void writeManifest(Session& session, Manifest manifest) {
  const Options& options = session.options();
  manifest.scene_file = findScene(options.scene);
  manifest.scene_hash = session.sceneHash();
  manifest.model_hash = hex16(modelHash(session.model()));
  manifest.command = options.command;
  manifest.files.insert(manifest.files.end(), {"force.csv", "report.json"});
  writeWholeFile(session.results()->fileNamed("manifest.json"), toJson(manifest));
}

void checkReferences(const Options& options, const Scene& scene) { readReferences(options, scene); }

int runOffscreen(Session& session) {
  // First what may be missing, so that a long run is not for nothing.
  const References references = readReferences(session.options(), session.model().scene);
  const OffscreenContext context;
  OrganView organ(session.model());
  session.log().info("OpenGL: " + context.description());

  const Options& options = session.options();
  ResultFolder& results = *session.results();
  Manifest manifest;
  manifest.opengl = context.description();
  manifest.width = options.width;
  manifest.height = options.height;
  Picture last;
  const auto written = [&](const char* what, const std::string& file) {
    std::cout << format("%-13s", what) << file << '\n';
  };
  const auto keep = [&](const std::string& stem, const Snapshot& snapshot) {
    last = drawPicture(organ, session, snapshot);
    manifest.picture_times_s.push_back(snapshot.force.time_s);
    session.attempt([&] {
      writePng(results.fileNamed(stem + ".png"), last);
      manifest.files.push_back(stem + ".png");
      written("picture", results.fileNamed(stem + ".png"));
    });
    if (!options.dump_fields) return;
    if (session.searching()) return session.log().info(stem + ": no fields, which would show the lumps");
    session.attempt([&] {
      writeStateVtu(results.fileNamed(stem + ".vtu"), modelOf(snapshot, session.model()), snapshot);
      manifest.files.push_back(stem + ".vtu");
      written("fields", results.fileNamed(stem + ".vtu"));
    });
  };
  std::optional<RunExport> exported;
  if (!options.export_file.empty()) exported.emplace(options.export_file, session.model());
  bool export_goes_on = exported.has_value();
  const bool one = options.snapshot_at.size() <= 1;
  std::vector<Picture> animation;
  runAndTake(session, [&](double time, const Snapshot& snapshot) {
    if (exported) {
      export_goes_on = export_goes_on && session.attempt([&] { exported->add(snapshot); });
      return;
    }
    if (!options.animation.empty()) {
      animation.push_back(drawPicture(organ, session, snapshot));
      return;
    }
    keep(one ? "snapshot" : format("snapshot_%gs", time), snapshot);
  });
  if (interrupted()) session.log().info("interrupted: keeping what was done so far");
  if (session.revealed())
    session.attempt([&] {
      const SheetHead head = session.sheetHead(options.trainee_name);
      for (const std::string& name :
           writeScore(results.fileNamed("score.json"), *session.task(), head, drawScorePage(organ, session, head)))
        manifest.files.push_back(name);
      const TaskScore::Sheet sheet = session.task()->sheet();
      written("score", format("%s: %d found, %d missed, %d false", results.fileNamed("score.json").c_str(), sheet.hits,
                              sheet.misses, sheet.false_alarms) +
                           (sheet.mean_error_mm ? format(", %.1f mm off", *sheet.mean_error_mm) : ""));
    });
  if (!options.animation.empty()) {
    // What was hidden is shown at last, unless there was no end.
    if (options.replay.empty() && !interrupted()) session.giveUpSearch();
    animation.push_back(drawPicture(organ, session, session.latest()));
    session.attempt([&] {
      writeAnimation(options.animation, animation, 1 / animation_rate, animation_end_seconds);
      written("animation", options.animation);
    });
  }
  if (manifest.picture_times_s.empty()) keep("snapshot", session.latest());  // with the lumps, once the answers are in

  const std::string report = toJson(session.report());
  const bool reported = session.attempt([&] { results.writeReport(report); });
  session.attempt([&] { writeManifest(session, manifest); });
  if (exported)
    session.attempt([&] {
      exported->write();
      written("export", options.export_file);
    });
  if (options.soak_minutes)
    written("soak", results.soakTextFile());
  else if (results.keepsForces())
    written("force curve", results.forceFile());
  if (reported) written("report", results.reportFile());
  std::cout << std::flush;
  return exitCodeOf(session, references, last, report);
}

int checkLumps(const Options& options, Scene scene) {
  Log log;
  const LoadedModel loaded = scene.places.contains("lumps.count") && !scene.places.contains("lumps.layout")
                                 ? loadedModelOf(options, scene, log)
                                 : loadAsItIs(options, scene, log);
  const double depth = workingDepth(scene);
  const std::vector<Lump> lumps = lumpsOf(*loaded.model);
  if (const auto nowhere = outsideLump(*loaded.model))
    throw InputError(nowhere->place, nowhere->problem, nowhere->advice);
  const std::vector<LumpFeel> feels = feelLumps(loaded.body(), depth);
  bool felt = true, sure = true;
  std::cout << format("pressed %.1f mm deep by a %s of %.1f mm\n", 1e3 * depth,
                      toolType(scene.tools[0].shape.kind).title, 1e3 * scene.tools[0].shape.radius);
  for (std::size_t k = 0; k < lumps.size(); ++k) {
    const LumpFeel& feel = feels[k];
    const bool clear = feel.ratio() >= least_feel;
    if (feel.isSure())
      felt &= clear;
    else
      sure = false;
    const std::string wrong = misplaced(lumps[k]);
    std::cout << format(
        "lump %d: radius %.1f mm, %s, %.1f times as stiff: %.0f N/m above it, %.0f beside it, ratio %.2f +- %.2f%s\n",
        static_cast<int>(k) + 1, 1e3 * lumps[k].radius,
        wrong.empty() ? format("top %.1f mm deep", 1e3 * lumps[k].top).c_str() : wrong.c_str(), lumps[k].stiffness,
        feel.above_N_per_m, feel.beside_N_per_m, feel.ratio(), feel.error * feel.ratio(),
        !feel.isSure() ? ": not sure"
        : clear        ? ""
                       : ": can't be felt");
  }
  if (!felt)
    std::cerr << format(
        "palpate: a lump is felt less than %.2f times as stiff as the tissue beside it; make it larger, "
        "stiffer or less deep\n",
        least_feel);
  else if (!sure)
    std::cerr << format(
        "palpate: whether a lump is felt %.2f times as stiff as the tissue beside it depends on the nodes; make it "
        "larger, stiffer or less deep, or the nodes finer\n",
        least_feel);
  return !felt ? exit_code::differs : !sure ? exit_code::doubted : exit_code::done;
}

int comparePictures(const Options& options) {
  const std::string problem =
      pictureDifference(readPng(options.compare), readPng(options.scene), options.tolerance, "");
  std::cout << (problem.empty() ? "the pictures look the same" : problem) << std::endl;
  return problem.empty() ? exit_code::done : exit_code::differs;
}

}  // namespace palpate::app
