#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/key.h"
#include "io/tool_script.h"
#include "model/model.h"
#include "model/tools_at.h"

namespace palpate::tools {

/// The tools of a solution and the scripts that move them. Those that the scene's file has are there; without a script
/// they stand where they start.
class SolveTools {
 public:
  /// @param named  script of the first tool in place of the scene's own; "": that
  /// Throws InputError for a script that can't be used.
  SolveTools(const Scene& scene, const std::string& named);

  /// s, when the last of them has come to its end; 0 without scripts.
  double duration() const;
  bool moved() const;

  /// Where they are at a time, s.
  ToolsAt at(const Model& model, double time) const;

  /// Of what decides where they are.
  void addTo(ByteKey& key) const;

 private:
  bool several_, there_;
  std::vector<std::optional<ToolScript>> script_;  // (tool_count)
};

/// The columns' names of a tool in force.csv: "tool", "tool2", ...
std::string toolColumn(int tool);

}  // namespace palpate::tools
