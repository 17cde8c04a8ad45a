// The search for a scene's lumps: what was felt and said, in its order, and what the sheet says beside the score.
#include <ctime>

#include "app/run/session.h"
#include "base/number_text.h"
#include "base/printable_text.h"
#include "contact/tools/tool_list.h"
#include "model/model_hash.h"

namespace palpate::app {

void Session::beginSearch() {
  task_.emplace(model_, lumpsOf(model_));
  conditions_ = {};
}

void Session::say(const Request& said) {
  if (searching() && driver() != ToolDriver::Replay) send(said);
}

/// Samples and events come by different ways; what an event brings about counts before the sample of its tick.
void Session::followSearch() {
  for (const ForceSample& sample : felt_) {
    while (!said_.empty() && said_.front().tick < sample.tick) {
      takeSaid(said_.front());
      said_.pop_front();
    }
    if (searching()) task_->add(sample);
    felt_until_ = sample.tick;
  }
  felt_.clear();
  while (!said_.empty() && (ended_ || said_.front().tick <= felt_until_)) {
    takeSaid(said_.front());
    said_.pop_front();
  }
}

void Session::takeSaid(const LogEvent& event) {
  using Kind = LogEvent::Kind;
  if (!searching()) return;
  switch (event.kind) {
    case Kind::Marked:
      task_->mark(event.position, event.index, event.time_s);
      break;
    case Kind::Unmarked:
      task_->unmark();
      break;
    case Kind::Submitted:
      revealed_ = true;
      revealed_by_recording_ = event.index == 1;
      break;
    case Kind::FrictionSet:
    case Kind::MaterialSet:
      conditions_.changes.push_back(logText(event));
      break;
    case Kind::Undone:
      if (event.value > 0) ++conditions_.undos;
      task_->breakPath();
      break;
    case Kind::Reset:
      if (event.index == 1 && track_driver_ == ToolDriver::Replay) return beginSearch();  // with its marks
      ++conditions_.resets;
      task_->breakPath();
      break;
    default:
      if (event.isRestore()) task_->breakPath();
      break;
  }
}

/// Once it has pressed everywhere; its recording then has what it says, too.
void Session::submitForTrainee() {
  const std::int64_t end = loop_->summary().ticks;
  const auto recorded = [&](const Request& said) {
    if (recording_) recording_->changes.push_back({end, said});
  };
  for (const Vec3& place : trainee_->marks()) {
    constexpr int hardness = 2;  // it feels where, not how hard
    recorded(Request::mark(place, hardness));
    task_->mark(place, hardness, static_cast<double>(end) / scene_.dynamics.rate_hz);
  }
  recorded(Request::simple(Request::Kind::Submit));
  revealed_ = true;
}

Conditions Session::conditions() const {
  Conditions conditions = conditions_;
  if (trainee_)
    conditions.moved_by = "a trainee by rule";
  else if (device_)
    conditions.moved_by = "the device " + device_->name();
  else if (track_driver_ != ToolDriver::User)
    conditions.moved_by = (replay_ ? "the recording " : "the script ") + script_ +
                          (track_over_ && !revealed_by_recording_ ? ", then by hand" : "");
  const ToolShape& tool = scene_.tools[0].shape;
  conditions.probe = format("%s, radius %.3g mm", toolType(tool.kind).title, 1e3 * tool.radius);
  conditions.probe_of_scene = !options_.tool_choice;
  conditions.friction = scene_.tools[0].friction;
  conditions.rate_hz = scene_.dynamics.rate_hz;
  conditions.rate_of_scene = !options_.rate_hz;
  conditions.answers_seen = options_.answers_seen;
  return conditions;
}

SheetHead Session::sheetHead(const std::string& trainee) const {
  SheetHead head;
  head.scene = scene_.name;
  head.trainee = printable(trainee);
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  char date[32] = "";
  if (localtime_r(&now, &local) != nullptr) std::strftime(date, sizeof date, "%Y-%m-%d %H:%M", &local);
  head.date = date;
  head.scene_hash = scene_hash_;
  head.model_hash = hex16(modelHash(model_));
  head.lump_draw = scene_.lump_draw;
  head.conditions = conditions();
  return head;
}

}  // namespace palpate::app
