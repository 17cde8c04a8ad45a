#include "realtime/recording/recording.h"

#include "base/input_error.h"
#include "base/number_text.h"
#include "model/model.h"
#include "model/model_hash.h"

namespace palpate {

void checkRate(const Recording& recording, double rate_hz, const std::string& file) {
  constexpr int kRateLine = 4;
  if (recording.rate_hz == rate_hz) return;
  throw InputError(
      {file, kRateLine},
      "recorded at " + shortest(recording.rate_hz) + " Hz, but the scene runs at " + shortest(rate_hz) + " Hz",
      "replay with --rate " + shortest(recording.rate_hz));
}

void checkRecordingFits(const Recording& recording, const Model& model, const std::string& file) {
  constexpr int kModelLine = 3;
  checkRate(recording, model.scene.dynamics.rate_hz, file);
  const std::uint64_t hash = modelHash(model);
  if (recording.model_hash != hash) {
    throw InputError({file, kModelLine},
                     "recorded with model " + hex16(recording.model_hash) + " (scene " + inQuotes(recording.scene) +
                         "), but this one is " + hex16(hash) + " (scene " + inQuotes(model.scene.name) + ")",
                     "replay with the scene, program, machine and PALPATE_KERNEL it was recorded with");
  }
}

std::vector<TimedRequest> trackFromPoses(const std::vector<Pose>& poses) {
  std::vector<TimedRequest> track;
  track.reserve(poses.size());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    track.push_back({static_cast<std::int64_t>(k), Request::moveTool(poses[k])});
  }
  return track;
}

}  // namespace palpate
