#include "app/run/device_watch.h"

#include <cmath>

#include "base/number_text.h"
#include "realtime/device/device_coupling.h"

namespace palpate::app {

void DeviceWatch::update(const DeviceStatus& status, double seconds) {
  if (begin_ < 0) begin_ = seconds;
  if (status.connected != there_) {
    there_ = status.connected;
    if (there_) {
      last_pose_ = seconds;
      tell_(false, name_ + " is back");
    } else {
      ++losses_;
      tell_(true, name_ + " is gone; its force has faded, and it is looked for each second");
    }
  }
  watchPoses(status, seconds);
  watchRate(status, seconds);
  watchForce(status, seconds);
}

void DeviceWatch::watchPoses(const DeviceStatus& status, double seconds) {
  constexpr double first_wait = 2, silence = 0.5;  // s
  if (status.refused > 0 && !refused_told_) {
    refused_told_ = true;
    tell_(true,
          "a message came that is no new pose: other letters, size or numbers, or a sequence that does not count up");
  }
  if (status.poses != poses_) {
    if (poses_ == 0) tell_(false, "its handle has the tool");
    if (first_pose_ < 0) first_pose_ = seconds, counted_from_ = status.poses;
    if (silence_told_ && poses_ > 0) tell_(false, "poses come again");
    silence_told_ = false;
    poses_ = status.poses;
    last_pose_ = seconds;
  }
  if (silence_told_ || !there_) return;
  if (poses_ == 0 && seconds > begin_ + first_wait) {
    silence_told_ = true;
    tell_(true, format("no pose has come in %.0f s, and there is no force: is the program running that sends them to ",
                       first_wait) +
                    name_ + "?");
  } else if (poses_ > 0 && seconds > last_pose_ + silence) {
    silence_told_ = true;
    tell_(true, "no pose for half a second: there is no force, and the tool stays");
  }
}

void DeviceWatch::watchRate(const DeviceStatus& status, double seconds) {
  constexpr double looks_after = 2;  // s
  constexpr double well = 400;       // Hz: nearly as stiff as with 1000 where own_damping allows it
  if (rate_told_ || first_pose_ < 0 || seconds < first_pose_ + looks_after) return;
  if (seconds > last_pose_ + 0.1) {  // it has stopped: look again when poses come
    first_pose_ = -1;
    return;
  }
  rate_told_ = true;
  // The coupling's own period knows none of devices that are too slow.
  const double rate = static_cast<double>(status.poses - counted_from_) / (seconds - first_pose_);
  const double least = 1 / DeviceCoupling::slowest_period;
  if (rate < 0.95 * least)
    tell_(true,
          format("poses come %.0f times a second: too seldom, the force is none or comes and goes; at least %.0f, "
                 "better 1000",
                 rate, least));
  else if (rate < well)
    tell_(false, format("poses come %.0f times a second: tissue is felt softer than with 1000", rate));
}

void DeviceWatch::watchForce(const DeviceStatus& status, double seconds) {
  constexpr double lasting = 1, quiet = 5;  // s: a hand that slips by turns is told once
  if (status.lacking <= DeviceCoupling::felt_lacking) {
    lacking_since_ = -1;
    if (seconds > lacking_last_ + quiet) lacking_told_ = false;
    return;
  }
  if (lacking_since_ < 0) lacking_since_ = seconds;
  lacking_last_ = seconds;
  if (lacking_told_ || seconds < lacking_since_ + lasting) return;
  lacking_told_ = true;
  tell_(true, format("the hand feels %.0f %% less than it should: it had got energy that it did not pay for (a pause, "
                     "noise, a late line), and the tool has slipped; lift off for a second",
                     100 * status.lacking));
}

}  // namespace palpate::app
