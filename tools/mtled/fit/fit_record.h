#pragma once

#include <string>
#include <vector>

#include "mtled/run/scripted_run.h"

namespace palpate::tools {

/// What came of one setting.
struct FitTry {
  std::string family;                       // FitFamily::name
  double spacing_factor = 1;                // times the given scene's spacing
  int nodes = 0, points = 0, substeps = 0;  // no nodes: the set-up refuses it
  RunCost cost;
  ScriptedRun run;  // without tick_us where it was read
};

/// All that a fit has tried, kept in a file after each, so that an interrupted fit goes on where it was.
class FitRecord {
 public:
  /// Begins a new one; nothing is written yet.
  FitRecord(std::string file, std::string identity) : file_(std::move(file)), identity_(std::move(identity)) {}

  /// Takes what the file has. Throws InputError where there is none, it is damaged or of another identity.
  void resume();

  /// Null where that was not tried yet.
  const FitTry* find(const std::string& family, double spacing_factor) const;

  /// Throws std::runtime_error where the file can't be written.
  void add(const FitTry& one);

 private:
  std::string file_, identity_;  // scene, way, rate, threads and program
  std::vector<FitTry> tries_;
};

}  // namespace palpate::tools
