#include "app/run/run_export.h"

#include <filesystem>

#include "app/render/rigid_mesh.h"
#include "app/render/solid_mesh.h"
#include "app/run/saved_files.h"
#include "base/number_text.h"
#include "discretization/surface/surface_geometry.h"
#include "step/tool_bodies.h"

namespace palpate::app {

namespace {

const Vec3 tool_colour(0.55, 0.57, 0.6), rigid_colour(0.35, 0.36, 0.38);

bool isSeries(const std::string& path) { return path.ends_with(".pvd"); }

TriangleSurface surfaceOf(const SolidMesh& mesh) {
  TriangleSurface surface;
  for (const SolidVertex& vertex : mesh.vertices) surface.vertices.push_back(vertex.position.cast<double>());
  for (std::size_t k = 0; k + 2 < mesh.indices.size(); k += 3) {
    const std::uint32_t a = mesh.indices[k], b = mesh.indices[k + 1], c = mesh.indices[k + 2];
    const Vec3f &A = mesh.vertices[a].position, &B = mesh.vertices[b].position, &C = mesh.vertices[c].position;
    if (A == B || B == C || C == A) continue;  // at the poles of what was turned
    surface.triangles.push_back({static_cast<int>(a), static_cast<int>(b), static_cast<int>(c)});
  }
  return surface;
}

/// The folder of a series' moments, as it stands in the series.
std::string folderName(const std::string& path) { return std::filesystem::path(path).stem().string(); }

}  // namespace

std::string exportProblem(const std::string& path) {
  for (const char* ending : {".gltf", ".glb", ".pvd"})
    if (path.ends_with(ending) && std::filesystem::path(path).stem() != ending) return "";
  return "--export: '" + path +
         "' ends in none of .gltf, .glb (films and viewers) and .pvd (ParaView: a .vtu for each moment)";
}

bool exportsInside(const std::string& path) { return isSeries(path); }

RunExport::RunExport(std::string path, const Model& model) : path_(std::move(path)), model_(model) {
  if (isSeries(path_)) {
    const std::filesystem::path folder = std::filesystem::path(path_).parent_path() / folderName(path_);
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw std::runtime_error("can't make the folder " + folder.string() + ": " + error.message());
    return;
  }
  run_.surface.name = "tissue";
  run_.surface.rest = model.skin.surface;
  run_.surface.colour = model.scene.organs[0].colour;
  run_.curves = {{"doubted", {}}};
  for (std::size_t t = 0; t < model.tools.tool.size(); ++t)
    for (const char* axis : {"_x", "_y", "_z"})
      run_.curves.push_back({(t == 0 ? "" : format("tool%zu_", t + 1)) + std::string("force_N") + axis, {}});
  for (const RigidBody& body : model.rigid.body)
    for (const char* axis : {"_x", "_y", "_z"}) run_.curves.push_back({body.name + "_force_N" + axis, {}});
  for (const ToolBody& body : model.tools.body) {
    const char* finger = body.side > 0 ? ", right finger" : body.side < 0 ? ", left finger" : "";
    run_.bodies.push_back({"tool " + std::to_string(body.tool + 1) + finger,
                           surfaceOf(toolMesh(body.shape, body.tool == 0 || !model.tools.tool[body.tool].path.empty())),
                           tool_colour,
                           {}});
  }
  const Box3 box = boundingBox(model.skin.surface);
  for (std::size_t r = 0; r < model.rigid.body.size(); ++r)
    if (!model.rigid.body[r].encloses)
      run_.bodies.push_back({model.rigid.body[r].name,
                             surfaceOf(rigidMesh(model.scene.rigid[r], box.center(), 0.5 * box.diagonal().norm())),
                             rigid_colour,
                             {}});
  // The first moment is rest, before any tick.
  run_.time_s = {0};
  run_.surface.frames.emplace_back();
  for (const Vec3& X : run_.surface.rest.vertices) run_.surface.frames[0].push_back(X.cast<float>());
  for (auto& [name, values] : run_.curves) values.push_back(0);
  addPoses(nullptr);
}

/// @param snapshot  null: where they start
void RunExport::addPoses(const Snapshot* snapshot) {
  auto drawn = run_.bodies.begin();
  for (const ToolBody& body : model_.tools.body) {
    ToolPosture posture = model_.tools.tool[body.tool].start;
    if (snapshot != nullptr) posture = snapshot->tools.posture(body.tool);
    drawn++->poses.push_back(bodyPose(body, posture));
  }
  const double time = snapshot != nullptr ? static_cast<double>(snapshot->tick) / model_.scene.dynamics.rate_hz : 0;
  for (const RigidBody& body : model_.rigid.body)
    if (!body.encloses) drawn++->poses.push_back(body.at(time));
}

void RunExport::add(const Snapshot& snapshot) {
  const double time = snapshot.force.time_s;
  if (isSeries(path_)) {
    if (!series_.empty() && time <= series_.back().time) return;
    const std::string file =
        format("%s/%s_%04zu.vtu", folderName(path_).c_str(), folderName(path_).c_str(), series_.size());
    writeStateVtu((std::filesystem::path(path_).parent_path() / file).string(), modelOf(snapshot, model_), snapshot);
    series_.push_back({time, file});
    return;
  }
  if (time <= run_.time_s.back()) return;
  run_.time_s.push_back(time);
  std::vector<Vec3f>& x = run_.surface.frames.emplace_back();
  const SkinModel& skin = modelOf(snapshot, model_).skin;
  for (int v = 0; v < skin.vertexCount(); ++v) x.push_back(skinPosition(skin, v, snapshot.u.data()).cast<float>());
  auto curve = run_.curves.begin();
  curve++->second.push_back(snapshot.force.doubt == Doubt::None ? 0 : 1);
  for (std::size_t t = 0; t < model_.tools.tool.size(); ++t)
    for (const double force : snapshot.tools.tool[t].force) curve++->second.push_back(force);
  for (std::size_t r = 0; r < model_.rigid.body.size(); ++r)
    for (const float force : snapshot.force.rigid_force[r]) curve++->second.push_back(static_cast<double>(force));
  addPoses(&snapshot);
}

void RunExport::write() const {
  if (isSeries(path_)) return writePvd(path_, series_);
  writeGltf(path_, run_);
}

}  // namespace palpate::app
