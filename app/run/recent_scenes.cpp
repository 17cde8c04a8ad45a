#include "app/run/recent_scenes.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "io/find_asset.h"

namespace palpate::app {

namespace fs = std::filesystem;

RecentScenes::RecentScenes(std::string file) : file_(std::move(file)) {
  std::ifstream lines(file_);
  for (std::string line; scenes_.size() < most && std::getline(lines, line);)
    if (!line.empty()) scenes_.push_back(line);
}

void RecentScenes::add(const std::string& scene) {
  std::error_code error;
  const std::string path = fs::exists(scene, error) ? fs::absolute(scene, error).string() : scene;
  std::erase(scenes_, path);
  scenes_.insert(scenes_.begin(), path);
  if (scenes_.size() > most) scenes_.resize(most);
  if (file_.empty()) return;
  fs::create_directories(fs::path(file_).parent_path(), error);
  std::ofstream out(file_, std::ios::trunc);
  for (const std::string& one : scenes_) out << one << '\n';
}

std::string RecentScenes::userFile() {
  if (const char* config = std::getenv("XDG_CONFIG_HOME"); config != nullptr && *config != '\0')
    return std::string(config) + "/palpate/recent_scenes";
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0')
    return std::string(home) + "/.config/palpate/recent_scenes";
  return {};
}

std::vector<std::string> scenesToOpen(const RecentScenes& recent) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(assetFolder("scenes"), error))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  const std::size_t own = names.size();
  for (const std::string& scene : recent.all())
    if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(own), scene) ==
        names.begin() + static_cast<std::ptrdiff_t>(own))
      names.push_back(scene);
  return names;
}

}  // namespace palpate::app
