#include "mtled/certify/certify_command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "base/interrupt.h"
#include "base/number_text.h"
#include "base/parallel_for.h"
#include "contact/tool.h"
#include "io/certificate.h"
#include "io/find_asset.h"
#include "io/indent_script.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/scene_file.h"
#include "model/model_hash.h"
#include "mtled/run/converged_run.h"
#include "mtled/run/following_run.h"
#include "mtled/run/progress.h"
#include "step/resolution.h"

namespace palpate::tools {
namespace {

constexpr int row_count = 8, probe_count = 200;
constexpr double still_pressed = 0.05;  // of the largest force, at the end

/// Finer than the scene where the tools work: by half, or where the scene does not resolve one, until it is.
Fineness finenessFor(const Model& model) {
  constexpr double fine = 0.3;  // tool radii
  double touch = INFINITY;
  for (const ToolSetUp& tool : model.tools.tool) touch = std::min(touch, touchRadius(tool.shape));
  return {0.85, std::clamp(fine * touch / spacingAtTool(model), 0.25, 0.5), 1.35};
}

/// (tick_count) s
std::vector<double> times(const Model& model, const ToolTrajectory& way) {
  std::vector<double> time;
  for (std::size_t k = 0; k < way.size(); ++k)
    time.push_back(static_cast<double>(k + 1) / model.scene.dynamics.rate_hz);
  return time;
}

/// What counts of a tick, N: of all its forces together.
struct TickForces {
  double own = 0, truth = 0;         // sizes: of the run's forces, and of what the finer runs extrapolate to
  double difference = 0, lacks = 0;  // between these; of the finest run
};

std::vector<TickForces> tickForces(const ScriptedRun& run, const ConvergedRun& converged, double ratio,
                                   std::size_t ticks) {
  const double beyond = 1 / (ratio * ratio - 1);
  const std::size_t forces = run.force.size() / ticks;
  std::vector<TickForces> result;
  for (std::size_t k = 0; k < ticks; ++k) {
    TickForces sum;
    for (std::size_t f = forces * k; f < forces * (k + 1); ++f) {
      const Vec3 lacking = beyond * (converged.run.force[f] - converged.coarser.force[f]),
                 truth = converged.run.force[f] + lacking;
      sum.own += run.force[f].squaredNorm();
      sum.truth += truth.squaredNorm();
      sum.difference += (run.force[f] - truth).squaredNorm();
      sum.lacks += lacking.squaredNorm();
    }
    result.push_back({std::sqrt(sum.own), std::sqrt(sum.truth), std::sqrt(sum.difference), std::sqrt(sum.lacks)});
  }
  return result;
}

void printRows(const Certificate& certificate, bool by_time) {
  std::printf("%s     true force   scene\'s force   too large by   largest error   not known\n",
              by_time ? "  to the time of" : "  to a depth of");
  for (const Certificate::Row& r : certificate.row)
    std::printf("%13.2f %s %12.4f N %13.4f N %12.2f %% %13.2f %% %9.2f %%\n", by_time ? r.advance : 1e3 * r.advance,
                by_time ? "s " : "mm", r.force, r.scene_force, 100 * (r.scene_force / r.force - 1), 100 * r.error,
                100 * r.uncertainty);
}

}  // namespace

std::vector<double> advances(const Model& model, const ToolTrajectory& way) {
  const ToolSetUp& tool = model.tools.first();
  const Vec3 axis = tool.start.pose.orientation * -Vec3::UnitZ();
  std::vector<double> advance;
  for (const ToolPostures& tools : way)
    advance.push_back((tools[0].pose.position - tool.start.pose.position).dot(axis) - tool.first_contact_travel);
  return advance;
}

std::vector<Pose> certifiedPoses(const Model& model, const ToolTrajectory& way) {
  constexpr double step = 0.1, turn = 0.017;  // of the touching radius; rad
  const double radius = touchRadius(model.tools.first().shape);
  std::vector<Pose> poses;
  for (const ToolPostures& tools : way) {
    const Pose& at = tools[0].pose;
    if (poses.empty() || &tools == &way.back() || (at.position - poses.back().position).norm() > step * radius ||
        at.orientation.angularDistance(poses.back().orientation) > turn)
      poses.push_back(at);
  }
  return poses;
}

std::vector<Certificate::Row> certifiedRows(const std::vector<double>& advance, const ScriptedRun& run,
                                            const ConvergedRun& converged, double ratio, int count) {
  constexpr double least_force = 0.2, rounding = 1e-9;
  const double deepest = std::max(0.0, *std::max_element(advance.begin(), advance.end()));
  const std::vector<TickForces> forces = tickForces(run, converged, ratio, advance.size());
  std::vector<Certificate::Row> rows;
  double from = Certificate::first_from * deepest / count;
  for (int r = 1; r <= count; ++r) {
    Certificate::Row row;
    row.advance = deepest * r / count;
    std::vector<std::size_t> ticks;  // between this row and the one before
    double largest = 0, end = -INFINITY;
    for (std::size_t k = 0; k < advance.size(); ++k) {
      if (advance[k] <= from || advance[k] > row.advance * (1 + rounding)) continue;
      ticks.push_back(k);
      largest = std::max(largest, forces[k].truth);
    }
    from = row.advance * (1 + rounding);
    if (largest == 0) continue;
    row.uncertainty = converged.about.layer_error;
    for (const std::size_t k : ticks) {
      const TickForces& at = forces[k];
      if (at.truth < least_force * largest) continue;
      row.error = std::max(row.error, at.difference / at.truth);
      row.uncertainty = std::max(row.uncertainty, at.lacks / at.truth);
      if (advance[k] < end) continue;
      end = advance[k];
      row.force = at.truth;
      row.scene_force = at.own;
    }
    rows.push_back(row);
  }
  return rows;
}

int certifyCommand(const CertifyOptions& options) {
  const std::string file = findScene(options.scene);
  const Scene scene = readScene(file);
  const bool one_way = hasOneWay(scene);
  if (!one_way && !options.out.empty())
    throw InputError({file}, "a scene of several tools or jaws has no certificate", "leave --out away");
  const std::string out = options.out.empty() ? certificateFile(file) : options.out;
  for (const std::string& read : {file, options.tool_script.empty() ? "" : findToolScript(options.tool_script)})
    if (one_way && isSameFile(out, read))
      throw InputError({out}, "this file is read, and would be lost", "give another --out");
  if (one_way) checkWritable(out);
  const int threads = threadsOr(options.threads);
  auto line = std::make_unique<ProgressLine>("certify");
  ProgressLine& progress = *line;
  const auto show = [&](const std::string& what, double fraction) {
    if (interrupted()) throw std::runtime_error("interrupted; nothing is kept");
    progress.show(0.1 * fraction, what);
  };
  const ModelCache cache(options.use_cache ? ModelCache::userFolder() : "", {});
  const auto following = scene.discretization.follow ? loadFollowing(scene, show, cache) : nullptr;
  const Model model = following ? following->start()->model : loadModel(scene, show, cache);
  const ToolTrajectory way = scriptedTrajectory(model, namedScript(options.tool_script, scene.tools[0].shape.radius));
  const std::vector<Vec3> probes = surfaceProbes(model, probe_count);
  progress.show(0.1, "the scene as it is");
  ScriptedRun run;
  if (following) {
    PlaceShelf shelf(following->places());
    run = followTrajectory(following->places(), shelf, way, probes).run;
  } else {
    run = runTrajectory(model, way, probes, threads);
  }
  if (run.interrupted) throw std::runtime_error("interrupted; nothing is kept");
  if (!run.sound())
    throw std::runtime_error("the scene does not follow its tools to the end of the way; there is nothing to certify");
  const Fineness fineness = finenessFor(model);
  const ConvergedRun converged =
      convergedRun(model, way, probes, contactRegions(model, way), fineness, threads,
                   [&](double fraction, const std::string& what) { progress.show(0.15 + 0.85 * fraction, what); });

  Certificate certificate;
  certificate.model_hash = modelHash(model);
  certificate.script = options.tool_script;
  certificate.way = certifiedPoses(model, way);
  certificate.row =
      certifiedRows(one_way ? advances(model, way) : times(model, way), run, converged, fineness.coarser, row_count);
  const std::vector<TickForces> forces = tickForces(run, converged, fineness.coarser, way.size());
  double largest = 0;
  for (const TickForces& at : forces) largest = std::max(largest, at.truth);
  // Where the tools have let go, both skins are back at rest.
  certificate.displacement_error =
      forces.back().truth > still_pressed * largest ? errorOf(run, converged.run).displacement : NAN;
  if (one_way) writeCertificate(out, certificate);

  line.reset();
  if (!converged.about.layer_warning.empty()) warn("on the finest cloud, too: " + converged.about.layer_warning);
  std::printf("%s: %d nodes against %d and %d\n", scene.name.c_str(), model.nodeCount(), converged.about.coarser_nodes,
              converged.about.nodes);
  printRows(certificate, !one_way);
  if (std::isfinite(certificate.displacement_error))
    std::printf("displacement of the skin at the end: %.2f %% of the largest\n", 100 * certificate.displacement_error);
  std::printf("certificate  %s\n",
              one_way ? out.c_str() : "none: of several tools or jaws it would hold for their scripts alone");
  return 0;
}

}  // namespace palpate::tools
