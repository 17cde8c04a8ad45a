// How a run ends, and what is kept of it.
#include <algorithm>
#include <optional>
#include <stdexcept>

#include "app/run/session.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "io/output_file.h"
#include "model/model_hash.h"
#include "step/resolution.h"

namespace palpate::app {

void Session::finish() {
  if (ended_) return;
  ended_ = true;
  if (device_) finishDevice();
  loop_->quit();
  loop_->join();
  gather();
  if (trainee_ && searching() && !interrupted()) submitForTrainee();
  if (task_ && searching() && task_->begun() && interrupted())
    log_.warning("interrupted before the search was submitted: there is no score sheet");
  finishFollowing();
  const RunSummary& summary = loop_->summary();
  if (summary.lost_force_samples > 0)
    log_.warning(format("%lld force samples were lost: the main thread was kept from running",
                        static_cast<long long>(summary.lost_force_samples)));
  if (results_) attempt([&] { results_->finishForces(); });
  if (soak_)
    attempt([&] {
      const std::string broken = soak_->finish(*loop_, *results_, interrupted());
      if (!broken.empty()) fail("the soak failed: " + broken);
    });
  if (recording_) {
    recording_->ticks = summary.ticks;
    attempt([&] {
      if (summary.lost_records > 0)
        throw std::runtime_error(options_.record + " was not written: " + std::to_string(summary.lost_records) +
                                 " changes were lost, the run can't be repeated from it");
      writeWholeFile(options_.record, toText(*recording_));
      log_.info("recording: " + options_.record);
    });
  }
  if (summary.frozen && options_.offscreen && failure_.empty()) failure_ = "the run ended frozen: " + frozen_reason_;
}

bool Session::attempt(const std::function<void()>& output) {
  try {
    output();
    return true;
  } catch (const std::exception& error) {
    fail(error.what());
    return false;
  }
}

void Session::fail(const std::string& reason) { failure_ += (failure_.empty() ? "" : "\n") + reason; }

Recording Session::recordingSoFar() {
  const std::int64_t ticks = latest().status.ticks;  // all that came before it was taken with it
  Recording recording{scene_.name, modelHash(model_), scene_.dynamics.rate_hz, ticks, {}};
  if (changes_.overflowed())
    throw std::runtime_error("the run is too long to be kept as a recording; start it with --record");
  if (changes_lost_) throw std::runtime_error("changes of the run were lost; start it with --record");
  if (ticks == 0) throw std::runtime_error("the run has not begun yet");
  if (!recording_) {
    recording.changes = changes_.before(ticks);
    return recording;
  }
  for (const TimedRequest& change : recording_->changes)
    if (change.tick < ticks || (change.tick == ticks && change.request.isSaid())) recording.changes.push_back(change);
  return recording;
}

/// How the cloud followed the tool.
void Session::finishFollowing() {
  const std::optional<FollowTotals>& follow = loop_->summary().follow;
  if (!follow || !loaded_.following) return;
  const PlaceWorker& worker = loaded_.following->worker;
  const auto ticks = static_cast<double>(std::max<std::int64_t>(1, loop_->summary().ticks));
  const std::string swaps =
      follow->swaps > 0
          ? format("%lld swaps of %.0f us at most, the force jumped by %.2g N at most, by %.2f %% of it at most, ",
                   asLongLong(follow->swaps), follow->longest_swap_us, follow->largest_jump_N,
                   100 * follow->largest_jump_share)
          : "no swap, ";
  const std::string made = worker.madeCount() > 0 ? format("; %d places made or read, %.2f s each", worker.madeCount(),
                                                           worker.madeSeconds() / worker.madeCount())
                                                  : "";
  log_.info(
      "the cloud followed the tool: " + swaps +
      format("%.1f %% of the ticks on a place that was late", 100 * static_cast<double>(follow->late_ticks) / ticks) +
      made);
  if (const std::string failure = worker.failure(); !failure.empty())
    log_.warning("a place could not be made: " + failure);
}

/// The handle gets its last force, zero; the log what the device did.
void Session::finishDevice() {
  device_->stop();
  const DeviceReport report = device_->report();
  log_.info(
      format("device: %lld poses, peak force %.2f N, %.0f N/m, %.1f ms there and back, lowest observed energy "
             "%.2f mJ, %.2f mJ damped",
             asLongLong(report.poses), report.peak_force, report.stiffness, 1e3 * report.delay_s,
             1e3 * report.lowest_energy_J, 1e3 * report.damped_J));
  if (const int losses = device_watch_->losses(); losses > 0)
    log_.warning(format("device: %s was gone %d times", device_->name().c_str(), losses));
  if (report.lacking_s > 0.5)
    log_.warning(
        format("device: for %.1f s the hand felt less than it should, by a fifth or more: the tool had slipped, "
               "at the end by %.1f mm",
               report.lacking_s, 1e3 * report.slipped_m));
  if (report.silences > 0 || report.fades > 0 || device_->refusedCount() > 0)
    log_.warning(format("device: silent %lld times, force faded %lld times, %lld messages refused",
                        asLongLong(report.silences), asLongLong(report.fades), asLongLong(device_->refusedCount())));
}

RunReport Session::report() {
  RunSummary summary = loop_->summary();
  const Model& model = physics_->place() ? physics_->place()->place.model : model_;
  addLast(model, physics_->state(), latest().report, latest().time_s, summary.trust);
  RunReport report = makeRunReport(model_, summary, loop_->statistics(), physics_->team().size(),
                                   volumeChange(modelOf(latest(), model_), latest().u.data()));
  for (std::size_t b = 0; b < model_.scene.boundaries.size(); ++b)
    report.regions.push_back({model_.scene.boundaries[b].name, physics_->reactions()[b]});
  if (device_ && ended_) {
    const DeviceReport device = device_->report();
    report.device = {device.poses,           device.silences,  device.fades,    device_->refusedCount(),
                     device.lowest_energy_J, device.slipped_m, device.lacking_s};
  }
  return report;
}

double volumeChange(const Model& model, const Float4* u) {
  const ShapeTable& shape = model.point_shape;
  double volume = 0, change = 0;
  for (int q = 0; q < model.pointCount(); ++q) {
    Mat3 F = Mat3::Identity();
    for (int k = shape.begin[static_cast<std::size_t>(q)]; k < shape.begin[static_cast<std::size_t>(q) + 1]; ++k) {
      const auto e = static_cast<std::size_t>(k);
      F += toVec3(u[shape.node[e]]) * shape.gradN[e].transpose();
    }
    const double V = model.point_volume[static_cast<std::size_t>(q)];
    volume += V;
    change += V * (F.determinant() - 1);
  }
  return volume > 0 ? change / volume : 0;
}

}  // namespace palpate::app
