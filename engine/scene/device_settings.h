#pragma once

#include <array>

namespace palpate {

/// How a haptic device is coupled to the tool (realtime/device/device_coupling.h): the [device] table of a scene.
///
///   F = Kc (x_tool - x_dev) + Bc (v_tool - v_dev)     on the hand; |F| <= max_force, |dF/dt| <= max_force / rise_time
///
/// Kc is what the device can hold stably, not what the tissue is: the hand feels both springs in series. Turning is a
/// way at a lever: its spring is Kc lever^2, its damper Bc lever^2, its torque max_force lever at most.
struct DeviceSettings {
  double stiffness = 400;   // N/m, Kc at most: a long way to the device lowers it
  double damping = 0.2;     // N s/m, Bc
  double max_force = 3.3;   // N, of the vector
  double rise_time = 0.01;  // s, from nothing to max_force at the quickest
  double scale = 1;         // m of the scene for each m of the device
  double own_damping = 2;   // N s/m, of the device and the lightest hand that holds it: what bounds Kc
  double lever = 0.02;      // m, see above: about half the width of a grip
  bool locked = false;      // the tool keeps the orientation that it starts with, and there is no torque

  /// Common classes of devices, by the force that they can push with and the stiffness that they are made for.
  static constexpr std::array<const char*, 3> classes{"light", "medium", "strong"};
  static DeviceSettings of(int device_class) {
    DeviceSettings settings;
    if (device_class == 1) settings.stiffness = 3000, settings.damping = 0.5, settings.max_force = 8;
    if (device_class == 2) {
      settings.stiffness = 5000, settings.damping = 1, settings.max_force = 12;
      settings.own_damping = 3;
    }
    return settings;
  }
};

}  // namespace palpate
