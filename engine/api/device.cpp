#include "api/border.h"
#include "api/handles.h"
#include "api/palpate_device.h"
#include "io/scene_keys.h"
#include "realtime/device/device_signals.h"
#include "realtime/timing/fixed_step_loop.h"

using namespace palpate;
using namespace palpate::api;

namespace {

palpate_device_settings settingsFrom(const DeviceSettings& device) {
  palpate_device_settings s{};
  s.locked = device.locked;
  s.stiffness = device.stiffness;
  s.damping = device.damping;
  s.max_force = device.max_force;
  s.rise_time = device.rise_time;
  s.scale = device.scale;
  s.own_damping = device.own_damping;
  s.lever = device.lever;
  return s;
}

/// In the ranges that scenes have.
DeviceSettings deviceFrom(const palpate_device_settings& s) {
  const auto in_range = [](const char* name, double value) {
    for (const KeySpec& key : sceneKeys())
      if (std::string_view(key.table) == "device" && std::string_view(key.name) == name && !key.range.contains(value))
        throw Refusal(PALPATE_BAD_ARGUMENT, inQuotes(name) + " must be " + key.range.text());
    return value;
  };
  DeviceSettings device;
  if (s.locked != 0 && s.locked != 1) throw Refusal(PALPATE_BAD_ARGUMENT, "\"locked\" must be 0 or 1");
  device.locked = s.locked == 1;
  device.stiffness = in_range("stiffness", s.stiffness);
  device.damping = in_range("damping", s.damping);
  device.max_force = in_range("max_force", s.max_force);
  device.rise_time = in_range("rise_time", s.rise_time);
  device.scale = in_range("scale", s.scale);
  device.own_damping = in_range("own_damping", s.own_damping);
  device.lever = in_range("lever", s.lever);
  return device;
}

/// The device's pose, or none where it can't be one.
bool takePose(const palpate_device_pose& given, DevicePose& pose) {
  if (!isPose(given.pose)) return false;
  pose.sequence = given.sequence;
  pose.felt = given.felt;
  pose.sent_ns = given.sent_ns;
  pose.pose = poseFrom(given.pose);
  pose.has_velocity = given.has_velocity != 0;
  if (pose.has_velocity) pose.velocity = Vec3(given.velocity[0], given.velocity[1], given.velocity[2]);
  return isSane(pose);
}

std::int32_t notCoupled() { return refuse(PALPATE_REFUSED, "the tool hangs on no device; palpate_couple first"); }

}  // namespace

extern "C" {

int32_t palpate_scene_device(const palpate_model* model, palpate_device_settings* settings) {
  if (const int32_t code = nullAmong({{model, "model"}})) return code;
  return fill(settings, settingsFrom(model->model->scene.device));
}

int32_t palpate_couple(palpate_simulation* simulation, const palpate_device_settings* settings, palpate_error* error) {
  if (const std::int32_t code = nullAmong(error, {{simulation, "simulation"}})) return code;
  if (const int32_t code = simulation->whyNot()) return say(error, code, palpate_last_error());
  return guarded(error, [&] {
    const Model& model = *simulation->model;
    const DeviceSettings wanted = settings != nullptr ? deviceFrom(given(settings)) : model.scene.device;
    auto made = std::make_unique<Coupling>(model, wanted);
    simulation->loop.setDevice(&made->tool);
    simulation->coupling = std::move(made);
    return PALPATE_OK;
  });
}

int32_t palpate_uncouple(palpate_simulation* simulation) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  if (const int32_t code = simulation->whyNot()) return code;
  simulation->loop.setDevice(nullptr);
  simulation->coupling.reset();
  return PALPATE_OK;
}

int32_t palpate_exchange(palpate_simulation* simulation, int64_t now_ns, const palpate_device_pose* pose,
                         palpate_wrench* wrench) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}, {wrench, "wrench"}})) return code;
  if (!isSize(wrench->size)) return badSize(wrench->size);
  if (pose != nullptr && !isSize(pose->size)) return badSize(pose->size);
  if (now_ns < 0) return refuse(PALPATE_BAD_ARGUMENT, "now_ns is negative");
  if (!simulation->coupling) return notCoupled();
  Coupling& coupling = *simulation->coupling;
  DevicePose news;
  const bool usable = pose == nullptr || takePose(given(pose), news);
  // The sample first: else it could be younger than now.
  const ForceSample sample = simulation->loop.force().sample;
  const std::int64_t now = now_ns > 0 ? now_ns : MonotonicClock().now();
  const DeviceWrench answer =
      coupling.device.update(now, pose != nullptr && usable ? &news : nullptr, sample, coupling.tool.putBacks());
  coupling.tool.targets().back() = coupling.device.target();
  coupling.tool.targets().publish();
  palpate_wrench out{};
  out.touching = answer.touching;
  out.sequence = answer.sequence;
  out.answers = answer.answers;
  put(answer.force, out.force);
  put(answer.torque, out.torque);
  fill(wrench, out);
  return usable ? PALPATE_OK : refuse(PALPATE_BAD_ARGUMENT, "the handle's pose can't be one: the wrench is without it");
}

int32_t palpate_read_coupling(const palpate_simulation* simulation, palpate_coupling_state* state) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  if (!simulation->coupling) return notCoupled();
  const DeviceReport report = simulation->coupling->device.report();
  palpate_coupling_state out{};
  out.engaged = report.engaged;
  out.poses = report.poses;
  out.silences = report.silences;
  out.fades = report.fades;
  out.stiffness = report.stiffness;
  out.delay_s = report.delay_s;
  out.energy_J = report.energy_J;
  out.lowest_energy_J = report.lowest_energy_J;
  out.damped_J = report.damped_J;
  out.peak_force = report.peak_force;
  out.peak_torque = report.peak_torque;
  out.slipped_m = report.slipped_m;
  return fill(state, out);
}

}  // extern "C"
