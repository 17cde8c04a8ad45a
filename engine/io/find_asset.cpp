#include "io/find_asset.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/nearest_word.h"

namespace palpate {
namespace {

/// The file that `name` means: itself, or that of this name in the folder. @param what  "scene file", for the message
std::string findInput(const std::string& what, const std::string& name, const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (fs::exists(name, ignored) && !fs::is_directory(name, ignored)) return name;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  if (std::find(names.begin(), names.end(), name) != names.end()) return (fs::path(folder) / (name + ".toml")).string();
  if (fs::exists(name, ignored)) return name;  // a folder: the reader says so
  const std::string nearest = nearestWord(fs::path(name).stem().string(), names);
  throw InputError({}, "there is no " + what + " " + inQuotes(name),
                   (nearest.empty() ? "" : "did you mean " + nearest + "? ") + "name a file" +
                       (names.empty() ? "" : ", or one of " + listed(names, "and")));
}

}  // namespace

std::string assetFolder(const std::string& name) { return dataFolder() + "/assets/" + name; }

std::string findScene(const std::string& scene, const std::string& folder) {
  return findInput("scene file", scene, folder);
}

std::string findToolScript(const std::string& script, const std::string& folder) {
  return findInput("tool script", script, folder);
}

}  // namespace palpate
