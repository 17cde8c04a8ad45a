#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "realtime/command_queue.h"

namespace palpate {

/// All input of a run, tick by tick: enough to repeat it bit for bit. Only changes are
/// kept. Pauses are not: they don't move simulated time.
///
/// The file is text, one change per line, numbers in their shortest exact form:
///   palpate-recording 1
///   scene liver
///   model 0123456789abcdef
///   rate_hz 500
///   0 tool 0 0 0.1  1 0 0 0              position m, quaternion w x y z
///   12 pull 411 0.01 0 0.12              skin vertex, target m
///   15 release
///   20 friction 0.3
///   21 material 0 neo_hookean 1000 5e4 1060         mu Pa, K Pa, density kg/m^3
///   21 material 0 ogden 1500 5e4 1060 2  1000 2  500 -2    and terms: mu Pa, alpha
///   30 reset
///   end 500                              ticks of the run; missing: cut off
struct Recording {
  std::string scene;
  std::uint64_t model_hash = 0;      // modelHash
  double rate_hz = 0;
  std::int64_t ticks = 0;            // of the run
  std::vector<TimedRequest> changes; // ascending ticks
};

struct Model;

/// 64-bit FNV-1a over all that decides a run's result but its input: nodes, points,
/// masses, kernel, boundaries, skin, tool, materials, time step.
std::uint64_t modelHash(const Model& model);

/// Throws std::runtime_error when the file can't be written.
void writeRecording(const Recording& recording, const std::string& file);

/// Throws InputError naming file and line of what is damaged or missing.
Recording readRecording(const std::string& file);

/// Throws InputError unless the recording was made with this model and rate.
void checkRecordingFits(const Recording& recording, const Model& model, const std::string& file);

/// A track that moves the tool to poses[k] in tick k.
std::vector<TimedRequest> trackFromPoses(const std::vector<Pose>& poses);

}  // namespace palpate
