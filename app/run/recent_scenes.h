#pragma once

#include <string>
#include <vector>

namespace palpate::app {

/// The scenes that were opened of late, newest first, kept in a file of the user's from one start to the next.
/// Where that can't be read or written there are none, and nothing is said.
class RecentScenes {
 public:
  static constexpr std::size_t most = 8;

  /// @param file  one path a line; empty: nothing is kept
  explicit RecentScenes(std::string file);

  const std::vector<std::string>& all() const { return scenes_; }
  void add(const std::string& scene);

  /// $XDG_CONFIG_HOME/palpate/recent_scenes, or ~/.config/...; empty where there is no home.
  static std::string userFile();

 private:
  std::string file_;
  std::vector<std::string> scenes_;
};

/// What the dialog offers: the names of the program's own scenes, then the recent ones that are none of them.
std::vector<std::string> scenesToOpen(const RecentScenes& recent);

}  // namespace palpate::app
