#pragma once

#include <string>

namespace palpate::tools {

struct FrontierOptions {
  std::string scene;        // file, or the name of one in assets/scenes
  std::string out;          // folder; "": out/<scene's name>_frontier
  std::string tool_script;  // "": the built-in indentation
  std::string report;       // folder for a page with tables and the picture, or ""
  bool quick = false;       // fewer settings, a coarser reference
  bool resume = false;      // keep the settings that the folder's frontier.json has already
};

/// Runs a scene's tool script at every setting that a user can turn and compares each with a converged solution of
/// the same scene: what a microsecond buys. Leaves frontier.csv, frontier.json and frontier.png in the folder after
/// each setting.
/// @return 0 done, 1 interrupted (what is done is kept)
/// Throws InputError for unusable input, std::runtime_error where a file can't be written.
int frontierCommand(const FrontierOptions& options);

}  // namespace palpate::tools
