#include "mtled/run/converged_run.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "base/build_info.h"
#include "base/key.h"
#include "base/number_text.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/text_file.h"
#include "model/model_hash.h"
#include "mtled/report/vector_json.h"
#include "realtime/recording/recording.h"
#include "step/resolution.h"

namespace palpate::tools {
namespace {

constexpr double reference_safety = 0.4;

using Json = nlohmann::json;

}  // namespace

ConvergedRun convergedRun(const Model& present, const ToolTrajectory& way, const std::vector<Vec3>& probes,
                          const std::vector<ContactRegion>& places, const Fineness& fineness, int threads,
                          const std::function<void(double, const std::string&)>& watch) {
  ConvergedRun converged;
  for (const bool fine : {false, true}) {
    const auto done = [&](double share) {
      watch(fine ? 0.3 + 0.7 * share : 0.3 * share, fine ? "the reference" : "a coarser reference");
    };
    done(0);
    Scene scene = present.scene;
    const double factor = fine ? 1 : fineness.coarser;
    refineWhere(scene, places, factor * fineness.outside, factor * fineness.inside);
    scene.discretization.quadrature.cells_per_point = 1;
    scene.dynamics.time_step = 0;
    scene.dynamics.step_safety = std::min(scene.dynamics.step_safety, reference_safety);
    const Model model = loadModel(scene);
    ScriptedRun run = runTrajectory(model, way, probes, threads, false, done);
    if (run.interrupted) throw std::runtime_error("interrupted during the reference solution; nothing is kept");
    if (!run.sound())
      throw std::runtime_error(
          "the reference solution is not sound: the tool's way is beyond what the scene can follow");
    if (const double tremble = trembleOf(run, way); tremble > largest_tremble)
      throw std::runtime_error(format(
          "the reference solution is not sound: while the tool stands at the end of its way the force trembles by "
          "%.2g %%; a way that goes less deep (--tool), or a rounder tool, would do",
          100 * tremble));
    const double peak = run.peakForce();
    if (peak == 0) throw std::runtime_error("no tool touches the organ on this way, so there is no force to compare");
    if (!fine) {
      converged.coarser = std::move(run);
      converged.about.coarser_nodes = model.nodeCount();
      continue;
    }
    converged.about.nodes = model.nodeCount();
    converged.about.points = model.pointCount();
    converged.about.peak_force = peak;
    converged.about.layer_error = model.layer_error;
    converged.about.layer_warning = layerWarning(model);
    converged.run = std::move(run);
  }
  converged.about.convergence = errorOf(converged.coarser, converged.run);
  return converged;
}

void writeConvergedRun(const std::string& file, const ConvergedRun& c, const std::string& identity) {
  Json json = {{"identity", identity},
               {"layer_error", c.about.layer_error},
               {"loaded_force_distance", c.about.convergence.loaded},
               {"force_N", vectorsToJson(c.run.force)},
               {"probe_u_m", vectorsToJson(c.run.probe_u)}};
  eachReferenceField(c.about, [&](const char* name, const auto& value) { json[name] = value; });
  writeWholeFile(file, json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

bool readConvergedRun(const std::string& file, const std::string& identity, ConvergedRun& converged) {
  if (!std::filesystem::exists(file)) return false;
  try {
    const Json j = Json::parse(readWholeFile(file));
    if (j.at("identity") != identity) return false;
    ConvergedRun c;
    eachReferenceField(c.about, [&](const char* name, auto& value) { j.at(name).get_to(value); });
    c.about.layer_error = j.at("layer_error");
    c.about.convergence.loaded = j.at("loaded_force_distance");
    c.run.force = vectorsFromJson(j.at("force_N"));
    c.run.probe_u = vectorsFromJson(j.at("probe_u_m"));
    converged = std::move(c);
    return true;
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

std::string runIdentity(const Model& model, const ToolTrajectory& way, const std::vector<double>& numbers) {
  ByteKey key;
  key.add(modelHash(model), numbers, model.scene.dynamics.damping);
  for (const char c : sourceIdentity()) key.add(c);
  for (const ToolPostures& tools : way)
    for (const ToolPosture& tool : tools) key.add(tool.pose.position, tool.opening);
  return hex16(key.hash());
}

std::vector<Vec3> surfaceProbes(const Model& model, int count) {
  const auto& vertices = model.skin.surface.vertices;
  std::vector<Vec3> probes;
  const std::size_t stride = std::max<std::size_t>(1, vertices.size() / static_cast<std::size_t>(count));
  for (std::size_t v = 0; v < vertices.size(); v += stride) probes.push_back(vertices[v]);
  return probes;
}

}  // namespace palpate::tools
