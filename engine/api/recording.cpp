#include <unistd.h>

#include <chrono>
#include <utility>

#include "api/border.h"
#include "api/handles.h"
#include "io/output_file.h"
#include "model/model_hash.h"
#include "realtime/loop/live_settings.h"
#include "realtime/recording/recording_file.h"

using namespace palpate;
using namespace palpate::api;

Recorder::Recorder(std::vector<TimedRequest> begin) : process_(getpid()), changes_(std::move(begin)) {
  thread_ = std::thread([this] {
    while (!ended_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      take();
    }
  });
}

Recorder::~Recorder() {
  ended_ = true;
  if (process_ == getpid())
    thread_.join();
  else
    thread_.detach();  // a forked process has a copy without the thread
}

void Recorder::take() {
  const std::lock_guard lock(mutex_);
  for (TimedRequest change; ring_.pop(change);) changes_.push_back(change);
}

const std::vector<TimedRequest>& Recorder::changes() {
  take();
  return changes_;
}

extern "C" {

int32_t palpate_record_start(palpate_simulation* simulation, palpate_error* error) {
  if (const std::int32_t code = nullAmong(error, {{simulation, "simulation"}})) return code;
  if (const int32_t code = simulation->whyNot()) return say(error, code, palpate_last_error());
  return guarded(error, [&] {
    if (simulation->recorder) throw Refusal(PALPATE_REFUSED, "it is recorded already; palpate_record_stop first");
    if (simulation->loop.memory().tick != 0 || simulation->physics.state().step != 0)
      throw Refusal(PALPATE_REFUSED, "a recording begins at rest, before the first tick; palpate_reset first");
    std::vector<TimedRequest> begin;
    for (const Request& setting : settingsInForce(simulation->present(), simulation->physics.state().live))
      begin.push_back({0, setting});
    simulation->recorder = std::make_unique<Recorder>(std::move(begin));
    simulation->loop.record(&simulation->recorder->ring());
    return PALPATE_OK;
  });
}

int32_t palpate_record_stop(palpate_simulation* simulation, const char* file, palpate_error* error) {
  if (const std::int32_t code = nullAmong(error, {{simulation, "simulation"}})) return code;
  if (const int32_t code = simulation->whyNot()) return say(error, code, palpate_last_error());
  return guarded(error, [&] {
    if (!simulation->recorder) throw Refusal(PALPATE_REFUSED, "it is not recorded; palpate_record_start first");
    if (file != nullptr) {
      const Scene& scene = simulation->model->scene;
      for (const std::string& read : scene.files)
        if (isSameFile(file, read)) throw Refusal(PALPATE_REFUSED, "the scene reads " + read + "; name another file");
      if (isSameFile(file, scene.place.file))
        throw Refusal(PALPATE_REFUSED, scene.place.file + " is the scene's own file; name another one");
      if (const std::int64_t lost = simulation->loop.lostChanges(); lost > 0)
        throw Refusal(
            PALPATE_FAILED,
            std::to_string(lost) + " changes of input found no room, so that nothing can be repeated; give NULL");
      Recording recording;
      recording.scene = simulation->model->scene.name;
      recording.model_hash = modelHash(*simulation->model);
      recording.rate_hz = simulation->model->scene.dynamics.rate_hz;
      recording.ticks = simulation->loop.memory().tick;
      recording.changes = simulation->recorder->changes();
      writeWholeFile(file, toText(recording), "name another file");
    }
    simulation->loop.record(nullptr);
    simulation->recorder.reset();
    return PALPATE_OK;
  });
}

}  // extern "C"
