#pragma once

#include <string>

namespace palpate::tools {

struct ImportOptions {
  std::string file;       // a surface (surfaceFormats())
  std::string out;        // folder; "": out/<file's name>
  std::string unit;       // "mm", "cm" or "m"; "": guessed where the size leaves no doubt
  bool use_cache = true;  // keep the set-up, so that the scene opens at once
};

/// Makes an organ of what people have: a surface, repaired where it must be, or a scan. Leaves in the folder
/// surface.obj (m), scene.toml, which opens and holds its rate, organ.png and report.json, and says what it found and
/// did.
/// @return 0; throws InputError for what can't become an organ, std::runtime_error where it is interrupted or a file
/// can't be written
int importCommand(const ImportOptions& options);

}  // namespace palpate::tools
