#include "app/run/saved_files.h"

#include <algorithm>
#include <filesystem>

#include "app/run/result_folder.h"
#include "app/trainer/class_scores.h"
#include "io/output_file.h"
#include "io/vtu_file.h"
#include "model/solution_fields.h"
#include "realtime/recording/recording_file.h"

namespace palpate::app {

SavedFiles::SavedFiles(const std::string& scene) : folder_("out/" + std::filesystem::path(scene).stem().string()) {}

std::string SavedFiles::free(const std::string& name, const std::string& ending) const {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);  // what is wrong with it is told by who writes
  for (int k = 1;; ++k) {
    std::string path = folder_ + "/" + name + "-" + std::to_string(k) + ending;
    if (!std::filesystem::exists(path, error)) return path;
  }
}

std::string SavedFiles::picture(const Picture& picture) const {
  std::string path = free("picture", ".png");
  writePng(path, picture);
  return path;
}

std::string SavedFiles::forces(const std::deque<ForceSample>& samples) const {
  const std::string path = free("force", "");
  ResultFolder results(path);
  results.begin();
  for (const ForceSample& sample : samples) results.addForce(sample);
  results.finishForces();
  return results.forceFile();
}

std::string SavedFiles::presses(const PressCurves& presses) const {
  std::string path = free("presses", ".csv");
  writeWholeFile(path, presses.csv());
  return path;
}

std::string SavedFiles::score(const TaskScore& score, const SheetHead& head, const Picture& page) const {
  std::string path = free("score", ".json");
  writeScore(path, score, head, page);
  return path;
}

std::string SavedFiles::recording(const Recording& recording) const {
  std::string path = free("recording", ".rec");
  writeWholeFile(path, toText(recording));
  return path;
}

std::string SavedFiles::state(const Model& model, const Snapshot& snapshot) const {
  std::string path = free("state", ".vtu");
  writeStateVtu(path, model, snapshot);
  return path;
}

std::vector<std::string> scoreFiles(const std::string& json_file) {
  const std::filesystem::path file(json_file);
  const std::string stem = file.stem().string();
  return {file.filename().string(), stem + "-pressure.csv", stem + ".png"};
}

std::vector<std::string> writeScore(const std::string& json_file, const TaskScore& score, const SheetHead& head,
                                    const Picture& page) {
  namespace fs = std::filesystem;
  const fs::path file(json_file);
  const std::vector<std::string> names = scoreFiles(json_file);
  writeWholeFile(json_file, score.json(head, names[1]));
  writeWholeFile((file.parent_path() / names[1]).string(), score.pressureCsv());
  writePng((file.parent_path() / names[2]).string(), page);
  return names;
}

void removeScore(const std::string& json_file) {
  if (!traineeOf(json_file)) return;  // something else
  std::error_code error;
  for (const std::string& name : scoreFiles(json_file))
    std::filesystem::remove(std::filesystem::path(json_file).parent_path() / name, error);
}

void writeStateVtu(const std::string& path, const Model& model, const Snapshot& snapshot) {
  std::vector<Vec3> parameters;
  for (const Float4& one : snapshot.u) parameters.push_back(toVec3(one));
  const KernelMaterials in_force = makeKernelMaterials(model.kernel, snapshot.materials);
  const SolutionFields fields = solutionFields(model, parameters, {}, {}, &in_force);
  const std::vector<VtuField> at_nodes{vtuVectors("displacement_m", fields.displacement)};
  std::vector<VtuField> in_cells{{"J", fields.J}, {"pressure_Pa", fields.pressure}};
  if (std::none_of(snapshot.materials.begin(), snapshot.materials.end(),
                   [](const Material& m) { return m.relaxation_count > 0; }))
    in_cells.push_back({"von_Mises_Pa", fields.von_mises});
  writeVtu(path, model.X, model.cells, at_nodes, in_cells);
}

}  // namespace palpate::app
