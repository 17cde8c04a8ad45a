#include "mtled/certify/certify_command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "base/interrupt.h"
#include "base/number_text.h"
#include "base/parallel_for.h"
#include "io/certificate.h"
#include "io/find_asset.h"
#include "io/indent_script.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "model/model_hash.h"
#include "mtled/run/converged_run.h"
#include "mtled/run/following_run.h"
#include "mtled/run/progress.h"
#include "step/resolution.h"

namespace palpate::tools {
namespace {

constexpr int row_count = 8, probe_count = 200;

/// Finer than the scene where the tool works: by half, or where the scene does not resolve its tool, until that is.
Fineness finenessFor(const Model& model) {
  constexpr double fine = 0.3;  // tool radii
  return {0.85, std::clamp(fine * touchRadius(model.scene.tools[0].shape) / spacingAtTool(model), 0.25, 0.5), 1.35};
}

ToolTrajectory wayOf(const Model& model, const std::string& name) {
  const std::optional<ToolScript> script = namedScript(name, model.scene.tools[0].shape.radius);
  return script ? scriptPoses(*script, model) : indentationTrajectory(model);
}

/// Of the tip along its axis past first touch, m.
double advanceOf(const Model& model, const Pose& pose) {
  const Vec3 axis = model.tools.first().start.pose.orientation * -Vec3::UnitZ();
  return (pose.position - model.tools.first().start.pose.position).dot(axis) - model.tools.first().first_contact_travel;
}

}  // namespace

std::vector<Certificate::Row> certifiedRows(const Model& model, const ToolTrajectory& way, const ScriptedRun& run,
                                            const ConvergedRun& converged, double ratio, int count) {
  double deepest = 0;
  for (const Pose& pose : way) deepest = std::max(deepest, advanceOf(model, pose));
  const double beyond = 1 / (ratio * ratio - 1);
  std::vector<Certificate::Row> rows;
  for (int r = 1; r <= count; ++r) {
    Certificate::Row row;
    row.advance = deepest * r / count;
    double error = 0, unknown = 0;
    int ticks = 0;
    for (std::size_t k = 0; k < way.size(); ++k) {
      const double advance = advanceOf(model, way[k]);
      if (advance > row.advance * (1 + 1e-9)) continue;
      const Vec3 lacking = beyond * (converged.run.force[k] - converged.coarser.force[k]),
                 truth = converged.run.force[k] + lacking;
      if (truth.isZero(0) && run.force[k].isZero(0)) continue;
      row.force = std::max(row.force, truth.norm());
      error += (run.force[k] - truth).squaredNorm();
      unknown += lacking.squaredNorm();
      ++ticks;
    }
    if (ticks == 0 || row.force == 0) continue;
    row.error = std::sqrt(error / ticks) / row.force;
    row.uncertainty = std::max(std::sqrt(unknown / ticks) / row.force, converged.about.layer_error);
    rows.push_back(row);
  }
  return rows;
}

int certifyCommand(const CertifyOptions& options) {
  const std::string file = findScene(options.scene);
  const Scene scene = readScene(file);
  checkOneWay(scene, "certify");
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
  const ToolTrajectory way = wayOf(model, options.tool_script);
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
    throw std::runtime_error("the scene does not follow its tool to the end of the way; there is nothing to certify");
  const Fineness fineness = finenessFor(model);
  const ConvergedRun converged =
      convergedRun(model, way, probes, contactRegion(model, way), fineness, threads,
                   [&](double fraction, const std::string& what) { progress.show(0.15 + 0.85 * fraction, what); });

  Certificate certificate;
  certificate.model_hash = modelHash(model);
  certificate.script = options.tool_script;
  certificate.row = certifiedRows(model, way, run, converged, fineness.coarser, row_count);
  certificate.displacement_error = errorOf(run, converged.run).displacement;
  const std::string out = options.out.empty() ? certificateFile(file) : options.out;
  writeCertificate(out, certificate);

  line.reset();
  if (!converged.about.layer_warning.empty()) warn("on the finest cloud, too: " + converged.about.layer_warning);
  std::printf("%s: %d nodes against %d and %d\n  to a depth of   largest force   its error   not known\n",
              scene.name.c_str(), model.nodeCount(), converged.about.coarser_nodes, converged.about.nodes);
  for (const Certificate::Row& r : certificate.row)
    std::printf("%13.2f mm %13.4f N %10.2f %% %10.2f %%\n", 1e3 * r.advance, r.force, 100 * r.error,
                100 * r.uncertainty);
  std::printf("displacement of the skin at the end: %.2f %% of the largest\ncertificate  %s\n",
              100 * certificate.displacement_error, out.c_str());
  return 0;
}

}  // namespace palpate::tools
