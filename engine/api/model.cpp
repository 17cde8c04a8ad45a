#include <algorithm>
#include <filesystem>
#include <limits>

#include "api/border.h"
#include "api/handles.h"
#include "base/build_info.h"
#include "base/free_memory.h"
#include "io/find_asset.h"
#include "io/indent_script.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "model/model_hash.h"
#include "step/trust.h"

using namespace palpate;
using namespace palpate::api;

namespace {

std::vector<SceneChange> changesOf(const palpate_options& options) {
  if (options.set_count < 0 || (options.set == nullptr && options.set_count > 0))
    throw Refusal(PALPATE_BAD_ARGUMENT, "options.set is NULL, or options.set_count negative");
  std::vector<SceneChange> changes;
  for (int k = 0; k < options.set_count; ++k) {
    if (options.set[k] == nullptr)
      throw Refusal(PALPATE_BAD_ARGUMENT, "options.set[" + std::to_string(k) + "] is NULL");
    changes.push_back(changeFrom(options.set[k]));
  }
  return changes;
}

/// With the options' rate and threads.
Scene withOptions(Scene scene, const palpate_options& options) {
  if (options.rate_hz != 0) {
    if (!(options.rate_hz >= 100 && options.rate_hz <= 2000))
      throw Refusal(PALPATE_BAD_ARGUMENT, "options.rate_hz is not in 100 .. 2000 Hz");
    overrideRate(scene, options.rate_hz);
  }
  if (options.threads < 0 || options.threads > max_threads)
    throw Refusal(PALPATE_BAD_ARGUMENT, "options.threads is not in 0 .. " + std::to_string(max_threads));
  if (options.threads > 0) scene.dynamics.threads = options.threads;
  return scene;
}

/// "": none is wanted. Throws Refusal where it is no folder and can't be made one.
std::string cacheFolder(const palpate_options& options) {
  const std::string folder = options.cache_folder != nullptr ? options.cache_folder : "";
  if (folder.empty()) return folder;
  std::error_code problem, none;
  std::filesystem::create_directories(folder, problem);
  if (!std::filesystem::is_directory(folder, none))
    throw Refusal(PALPATE_BAD_ARGUMENT, "options.cache_folder " + inQuotes(folder) +
                                            " can't be made: " + (problem ? problem.message() : "it is a file"));
  return folder;
}

/// @param read  (changes): the scene
template <class Read>
std::int32_t load(Read read, const palpate_options* options, palpate_model** model, palpate_error* error) {
  *model = nullptr;
  return guarded(error, [&] {
    const palpate_options asked = given(options);
    const ModelCache cache(cacheFolder(asked));
    const Progress progress = [&asked](const std::string& what, double fraction) {
      if (asked.progress != nullptr && asked.progress(asked.user, what.c_str(), fraction) != 0)
        throw Refusal(PALPATE_REFUSED, "given up while the model was made, as options.progress wanted");
    };
    auto handle = std::make_unique<palpate_model>();
    const Scene scene = withOptions(read(changesOf(asked)), asked);
    if (scene.discretization.follow) {
      handle->places = loadFollowing(scene, progress, cache);
      handle->model = {handle->places->start(), &handle->places->start()->model};
    } else {
      handle->model = std::make_shared<const Model>(loadModel(scene, progress, cache));
    }
    handle->names = namesOf(*handle->model);
    *model = handle.release();
    giveFreeMemoryBack();
    return PALPATE_OK;
  });
}

}  // namespace

/// Calls each(trajectory, tick) for the first `capacity` ticks of a script.
template <class Each>
static int32_t walk(const palpate_model* model, const char* script, const double* into, int64_t capacity,
                    int64_t* count, palpate_error* error, Each each) {
  if (const std::int32_t code = nullAmong(error, {{model, "model"}, {count, "count"}})) return code;
  if (capacity < 0) return say(error, PALPATE_BAD_ARGUMENT, "capacity is negative");
  if (into == nullptr && capacity > 0)
    return say(error, PALPATE_BAD_ARGUMENT, "there is a capacity, but no room for it");
  return guarded(error, [&] {
    const Model& m = *model->model;
    const ToolScript motion =
        script == nullptr || *script == '\0' ? indentScript(m) : *namedScript(script, m.scene.tools[0].shape.radius);
    ScriptTrajectory trajectory = trajectoryOf(motion, m);
    *count = trajectory.ticks();
    for (std::int64_t k = 0; k < std::min(capacity, *count); ++k) each(trajectory, k);
    return PALPATE_OK;
  });
}

extern "C" {

const char* palpate_version(void) {
  static const std::string version = programVersion();
  return version.c_str();
}

const char* palpate_build(void) {
  static const std::string build = buildInfo();
  return build.c_str();
}

const char* palpate_result_text(int32_t code) {
  switch (code) {
    case PALPATE_OK:
      return "done";
    case PALPATE_BAD_ARGUMENT:
      return "an argument is NULL, not finite, out of range or of an unknown size";
    case PALPATE_BAD_INPUT:
      return "a scene or script can't be used";
    case PALPATE_REFUSED:
      return "not possible; nothing has changed";
    case PALPATE_BUSY:
      return "not while the simulation runs on its own thread; stop it first";
    case PALPATE_FAILED:
      return "the system could not do it";
    default:
      return "unknown outcome";
  }
}

const char* palpate_doubt_text(int32_t doubt) {
  for (int d = 0; d <= static_cast<int>(Doubt::Lost); ++d)
    if (numberOf(static_cast<Doubt>(d)) == doubt) return doubtText(static_cast<Doubt>(d));
  return "";
}

int32_t palpate_load(const char* scene, const palpate_options* options, palpate_model** model, palpate_error* error) {
  if (model != nullptr) *model = nullptr;
  if (const std::int32_t code = nullAmong(error, {{scene, "scene"}, {model, "model"}})) return code;
  return load([&](const auto& changes) { return readScene(findScene(scene), changes); }, options, model, error);
}

int32_t palpate_load_text(const char* text, const char* folder, const char* name, const palpate_options* options,
                          palpate_model** model, palpate_error* error) {
  if (model != nullptr) *model = nullptr;
  if (const std::int32_t code = nullAmong(error, {{text, "text"}, {model, "model"}})) return code;
  return load(
      [&](const auto& changes) {
        const auto or_else = [](const char* given, const char* fallback) {
          return given != nullptr ? given : fallback;
        };
        return readScene(SceneText{text, or_else(folder, ""), or_else(name, "scene text")}, changes);
      },
      options, model, error);
}

void palpate_model_destroy(palpate_model* model) {
  delete model;
  giveFreeMemoryBack();
}

int32_t palpate_describe(const palpate_model* model, palpate_model_info* info) {
  if (const int32_t code = nullAmong({{model, "model"}})) return code;
  const Model& m = *model->model;
  palpate_model_info out{};
  out.node_count = m.nodeCount();
  out.point_count = m.pointCount();
  out.skin_vertex_count = m.skin.vertexCount();
  out.skin_triangle_count = static_cast<std::int32_t>(m.skin.surface.triangles.size());
  out.material_count = static_cast<std::int32_t>(m.scene.materials.size()) /* not their mixtures */;
  out.rate_hz = m.scene.dynamics.rate_hz;
  put(m.tools.first().start.pose, out.tool_start);
  out.tool_radius = m.scene.tools[0].shape.radius;
  out.first_contact_travel = m.tools.first().first_contact_travel;
  return guarded(nullptr, [&] {
    out.hash = modelHash(m);
    return fill(info, out);
  });
}

int32_t palpate_skin_triangles(const palpate_model* model, int32_t* corners, int32_t triangle_count) {
  if (const int32_t code = nullAmong({{model, "model"}, {corners, "corners"}})) return code;
  const auto& triangles = model->model->skin.surface.triangles;
  if (const int32_t code = otherThan("triangle_count", triangle_count, triangles.size())) return code;
  for (const auto& triangle : triangles)
    for (const int corner : triangle) *corners++ = corner;
  return PALPATE_OK;
}

int32_t palpate_script(const palpate_model* model, const char* script, double* poses, int64_t capacity, int64_t* count,
                       palpate_error* error) {
  return walk(model, script, poses, capacity, count, error,
              [&](ScriptTrajectory& trajectory, std::int64_t k) { put(trajectory.next(), poses + 7 * k); });
}

int32_t palpate_script_openings(const palpate_model* model, const char* script, double* openings, int64_t capacity,
                                int64_t* count, palpate_error* error) {
  const int32_t code =
      walk(model, script, openings, capacity, count, error, [&](ScriptTrajectory& trajectory, std::int64_t k) {
        trajectory.next();
        openings[k] = std::max(trajectory.opening(), 0.0);
      });
  if (code == PALPATE_OK && !model->model->tools.first().jaws) *count = 0;
  return code;
}

}  // extern "C"
