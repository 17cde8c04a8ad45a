#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/scene_file.h"

namespace palpate::tools {

/// A line of a job file: a scene with changes, a tool's way, and what is to be kept.
///
///   {"id": "soft", "scene": "liver", "set": {"material[0].young": 2000}, "tool": "drag_across", "seconds": 2,
///    "field": "npz", "picture": true}
///
/// Only the scene is needed. Files are looked for beside the job file, then from the current folder. Without a tool
/// there is the indentation of an off-screen run, 4 s of it.
struct BatchJob {
  std::string id;     // of its folder; "job-<line>" where it has none
  std::string scene;  // file, or the name of one in assets/scenes
  std::vector<SceneChange> changes;
  std::string tool;               // script: a file, or the name of one in assets/tools; "": none
  std::optional<double> seconds;  // of physics time; else the script's length
  std::string field;              // the last state: "vtu" for ParaView, "npz" for numpy; "": none
  bool picture = false;           // of it
  std::string text;               // all of it, in one spelling: what results belong to

  /// Jobs that agree in it run on the same model.
  std::string modelKey() const;
};

/// Reads a job file: JSON Lines, empty ones left out. Throws InputError with file and line for what is no job, an
/// unknown member, or an id that came before.
std::vector<BatchJob> readBatchJobs(const std::string& path);

/// What became of a job; its line in results.jsonl tells nothing of when and where it was run.
struct BatchResult {
  std::string id, job;  // BatchJob::id, text
  bool done = false;
  std::string reason;  // why not
  std::int64_t ticks = 0;
  std::string state_hash;                                 // 16 hex digits, as in report.json
  double seconds = 0;                                     // physics time
  double peak_force = 0, last_force = 0, last_depth = 0;  // N, N, m
  double expected_error = 0;                              // of the largest force, as a share
  std::string doubt;                                      // the gravest, doubtName
};

std::string toLine(const BatchResult& result);

/// Throws InputError at `place` where it is none.
BatchResult resultFromLine(const std::string& line, const SourceLocation& place);

}  // namespace palpate::tools
