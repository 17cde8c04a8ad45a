#include "app/run/run_files.h"

#include <filesystem>
#include <vector>

#include "app/trainer/class_scores.h"
#include "base/input_error.h"
#include "base/number_text.h"
#include "io/find_asset.h"
#include "io/output_file.h"

namespace palpate::app {
namespace {

/// A file, and what says that it is read or written.
struct NamedFile {
  std::string path, by;
};

std::vector<NamedFile> inputsOf(const Options& options, const Scene& scene) {
  std::vector<NamedFile> files{{findScene(options.scene), "the scene"},
                               {options.replay, "--replay"},
                               {options.compare, "--compare"},
                               {options.expect, "--expect"}};
  if (!options.tool_script.empty()) files.push_back({findToolScript(options.tool_script), "--tool"});
  for (const std::string& file : scene.files) files.push_back({file, "the scene"});
  return files;
}

/// What options name.
std::vector<NamedFile> outputsOf(const Options& options) {
  return {{options.record, "--record"}, {options.export_file, "--export"}, {options.animation, "--animation"}};
}

std::vector<NamedFile> resultsIn(const Options& options, const std::string& folder) {
  std::vector<NamedFile> files;
  std::vector<std::string> names{"force.csv",    "report.json",    "manifest.json",
                                 "snapshot.png", "difference.png", "score.json"};
  for (const double time : options.snapshot_at) names.push_back(format("snapshot_%gs.png", time));
  for (const std::string& name : names) files.push_back({(std::filesystem::path(folder) / name).string(), "--out"});
  return files;
}

void checkApart(const std::vector<NamedFile>& inputs, const std::vector<NamedFile>& outputs) {
  for (auto output = outputs.begin(); output != outputs.end(); ++output) {
    for (const NamedFile& input : inputs)
      if (isSameFile(output->path, input.path))
        throw InputError({output->path}, output->by + " would overwrite it, and " + input.by + " reads it",
                         "name another one with " + output->by);
    for (auto other = outputs.begin(); other != output; ++other)
      if (isSameFile(output->path, other->path))
        throw InputError({output->path}, "both " + other->by + " and " + output->by + " would write it",
                         "name another one with " + other->by);
  }
}

/// Keeps the score sheet of another trainee, which an earlier run left in the folder.
void checkScore(const Options& options, const std::string& folder) {
  const std::string sheet = (std::filesystem::path(folder) / "score.json").string();
  const std::optional<std::string> trainee = traineeOf(sheet);
  if (!trainee || *trainee == options.trainee_name) return;
  throw InputError({sheet},
                   "the score sheet of " + (trainee->empty() ? "somebody without a name" : *trainee) + " lies there",
                   "name another folder with --out");
}

}  // namespace

std::optional<ResultFolder> openResults(const Options& options, const Scene& scene) {
  const std::string named = "out/" + std::filesystem::path(options.scene).stem().string();
  const std::string folder = options.out.empty() ? named + (options.soak_minutes ? "-soak" : "") : options.out;
  const bool keeps = options.offscreen || options.soak_minutes || !options.out.empty();
  const std::vector<NamedFile> outputs = outputsOf(options);
  std::vector<NamedFile> all = outputs;
  if (keeps)
    for (NamedFile& file : resultsIn(options, folder)) all.push_back(std::move(file));
  checkApart(inputsOf(options, scene), all);

  // First what lies elsewhere, so that nothing is left where it can't be written.
  const auto check = [&](bool in_folder) {
    const auto folderOf = [](const std::filesystem::path& path) { return (path / "").lexically_normal(); };
    for (const NamedFile& file : outputs)
      if (!file.path.empty() &&
          (folderOf(std::filesystem::path(file.path).parent_path()) == folderOf(folder)) == in_folder)
        checkWritable(file.path, "choose another file with " + file.by);
  };
  check(false);
  std::optional<ResultFolder> results;
  // A soak's force curve would grow by 150 MB an hour and tell nothing that its report doesn't.
  if (keeps) {
    checkScore(options, folder);
    results.emplace(folder, !options.soak_minutes);
  }
  check(true);
  return results;
}

}  // namespace palpate::app
