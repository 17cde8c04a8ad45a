#pragma once

#include <atomic>

#include "model/model.h"
#include "realtime/device/device_target.h"
#include "realtime/loop/tool_motion.h"

namespace palpate {

/// How stiffly the tissue answers from tick to tick along one direction, seen where a tool goes to and fro. In turning
/// with ways in rad, torques in N m.
class RattleWatch {
 public:
  /// @param way    m, that the tool went in a tick
  /// @param force  N, by how much the tissue's force on it changed
  /// @param most   N/m, no more is believed
  /// @return N/m; 0: it goes one way
  double see(const Vec3& way, const Vec3& force, double most, double tick_s);
  void forget() { *this = RattleWatch(); }

 private:
  Vec3 last_way_ = Vec3::Zero();
  int reversals_ = 0;     // in a row
  double stiffness_ = 0;  // N/m
};

/// The tool that hangs on a device by the coupling's spring and damper, and is pushed back by the tissue. It has no
/// mass: in each tick it goes where the forces on it balance,
///
///   Kc (x_dev - x) + Bc (v_dev - v) + F_tissue(x) = 0,
///
/// so that at rest the spring carries exactly what the tissue does. F_tissue is known for the tick before; how it
/// changes with the tool's way is not. A step as if it didn't would overshoot where the tissue is the stiffer spring,
/// so the way is damped by D, what the stiffest material of the body could answer a tick's way with:
///
///   x += (Kc (x_dev - x) + Bc v_dev + F_tissue) / (Kc + Bc / T + D)
///   D  = rho c pi R^2 / T + 2 R E / (1 - nu^2)     a wave that leaves the contact, and a flat punch (Sneddon 1965)
///
/// with c the speed of pressure waves along the contact's normal, of shear waves across it, where there is friction. A
/// ball that is deep in the tissue has it at its sides, too, and between coarse nodes more of it moves with the tool
/// than D knows of: the tool would go to and fro from tick to tick. What that shows the tissue to answer with is taken
/// for D then, and forgotten within seconds (RattleWatch). D dissipates, and vanishes within 20 ms in air, where the
/// tool is where the device is.
/// It turns by the same law, with the torque on it and a punch that is rocked:
///   D = R^2 (rho c pi R^2 / 4 T + (4/3) R E / (1 - nu^2))
/// Loop thread only, but for targets(). Real-time: no allocation, no lock, no throw. A recording keeps the poses that
/// this gives, so a replay needs no device. Test: realtime/device/coupled_tool_test.cpp
class CoupledTool final : public ToolMotion {
 public:
  /// @param model  must outlive this
  explicit CoupledTool(const Model& model);

  /// (device's thread) back, publish
  DeviceTargetSlot& targets() { return targets_; }

  Pose next(const State& state, const StepReport& last) override;
  /// Jaws follow the device's button from when it is first pressed on.
  double opening() const override { return opening_; }
  std::uint64_t poseSequence() const override { return sequence_; }
  /// The tissue was put back: a reset, an undo, a solution that was lost.
  void restart() override {
    hold_ = 0;
    opening_ = -1;
    put_backs_.fetch_add(1, std::memory_order_relaxed);
  }
  /// (any thread) How often.
  std::uint32_t putBacks() const { return put_backs_.load(std::memory_order_relaxed); }

  /// N/m, D above along the normal.
  double normalHold() const { return normal_hold_; }

 private:
  DeviceTargetSlot targets_{DeviceTarget{}};
  Quat turned(const DeviceTarget& target, const State& state, const StepReport& last);
  void remember(const State& state, const StepReport& last);
  void moveJaws(bool closes, double present);

  const double tick_s_;
  const double widest_;                        // m, as far as jaws open
  double opening_ = -1;                        // m, where jaws are to be; < 0: no button was pressed
  double normal_hold_ = 0, tangent_hold_ = 0;  // N/m
  double turning_hold_ = 0;                    // N m/rad
  double hold_ = 0;                            // share of them that is in force
  Vec3 normal_ = Vec3::Zero();                 // of the last contact
  Vec3 last_x_ = Vec3::Zero(), last_force_ = Vec3::Zero(), last_torque_ = Vec3::Zero();
  Quat last_q_ = Quat::Identity();
  RattleWatch along_watch_, across_watch_, turning_watch_;
  std::uint64_t sequence_ = 0;
  std::atomic<std::uint32_t> put_backs_{0};
};

}  // namespace palpate
