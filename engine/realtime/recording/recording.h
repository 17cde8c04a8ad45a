#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "realtime/channels/command_queue.h"

namespace palpate {

/// All input of a run, tick by tick: enough to repeat it bit for bit. Only changes are
/// kept. Pauses are not: they don't move simulated time. Its file: recording_file.h.
struct Recording {
  std::string scene;
  std::uint64_t model_hash = 0;  // modelHash
  double rate_hz = 0;
  std::int64_t ticks = 0;             // of the run
  std::vector<TimedRequest> changes;  // ascending ticks
  std::vector<int> line = {};         // (change_count) of the file that it was read from, or empty
};

struct Model;

/// Throws InputError unless the recording was made at this rate. Needs no model.
void checkRate(const Recording& recording, double rate_hz, const std::string& file);

/// Throws InputError unless the recording was made with this model and rate, and has nothing that can't be asked of it.
void checkRecordingFits(const Recording& recording, const Model& model, const std::string& file);

}  // namespace palpate
