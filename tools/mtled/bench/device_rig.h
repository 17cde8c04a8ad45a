#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/model.h"
#include "realtime/device/simulated_device.h"

namespace palpate::tools {

/// A simulated device in a simulated hand on a body.
struct DeviceTrial {
  int device_class = 0;  // DeviceSettings::classes
  bool firm = false;     // the hand's grip; else light
  double delay_s = 0;    // of the device's way, there and back at most
  HandMotion::Kind motion = HandMotion::Kind::Press;
  double seconds = 6.6;  // simulated; Press: the device is silent for 0.2 s in the rest of its second time, if it comes
  std::uint64_t seed = 1;
  std::optional<SimulatedDeviceSettings> device{};  // another than the class's, with its own delays
  std::optional<HandModel> hand{};                  // another than light and firm
  double deeper = 0;                                // m, that this hand wants to be beneath where others press
  double rock = 0;                                  // rad, to both sides, once a second
  int dropouts = 0, stalls = 0;                     // of the poses, of the loop: one each half second from 1.5 s on
  double lasting = 0.02;                            // s, each of them
};

/// What the hand went through.
struct DeviceResult {
  double peak_force = 0;       // N, from the coupling
  double limit_cycle = 0;      // largest line of the force's spectrum above 20 Hz over the peak force
  double limit_cycle_hz = 0;   // where it is
  double lowest_energy_J = 0;  // of the passivity observer
  double damped_J = 0;         // by the passivity controller
  double given_J = 0;          // the most that the motors had given to the handle in all, at any time
  double dropout_J = 0;        // the most that they gave in the half second from before a dropout or stall
  double pull = 0;             // N, the most that they pulled it towards the tissue
  double peak_torque = 0;      // N m
  double static_error = -1;    // |force at the handle - force on the tool| over the latter, at rest; -1: not measured
  double static_force = 0;     // N, on the tool, at rest
  double tissue_stiffness = 0, felt_stiffness = 0;  // N/m, force over depth at rest: of the tool, of the handle
  double coupling_stiffness = 0;                    // N/m, in force at the end
  double silence_ms = -1;                           // from the last pose to a force of zero; -1: not measured
  double blow = 0;                                  // largest force in the 50 ms after the silence over that before
  double drag = 0;           // N s/m: what the handle feels beyond the tissue's force, against its velocity, in contact
  double latency_ticks = 0;  // the longest time from a pose's arrival to the force that answers it, in ticks
  bool frozen = false;
};

/// Runs device, coupling and loop in lockstep, in simulated time: the loop's ticks take 0.8 of their period, the
/// device's thread looks every millisecond. No clock is read; the same trial gives the same bits.
DeviceResult runDeviceTrial(const Model& model, const DeviceTrial& trial);

/// The largest line above `from_hz` of a force's spectrum, its component along its mean, with a Hann window: amplitude,
/// N, and frequency.
std::pair<double, double> spectralPeak(const std::vector<Vec3>& force, double rate_hz, double from_hz);

/// A scene as bench and tests use it: coarse, one thread. @param body  liver, gel, inclusion, or slab: of 50 kPa
Model deviceBody(const std::string& body);

}  // namespace palpate::tools
