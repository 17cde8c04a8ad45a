#pragma once

#include <optional>
#include <vector>

#include "realtime/channels/command_queue.h"
#include "realtime/loop/physics.h"

namespace palpate {

/// Friction, materials and loads, as they were asked for while the loop runs. Holds only what was asked; what is in
/// force is the physics' own.
/// Loop thread only. Real-time: no allocation, no lock, no throw; but not the constructor.
class LiveSettings {
 public:
  enum class Outcome {
    Ignored,  // nonsense, or what it is already
    Refused,  // the material is too stiff for the time step
    Changed,
  };
  struct Answer {
    Outcome outcome = Outcome::Ignored;
    double excess = 0;  // where refused: the factor (> 1) by which the material is too stiff
    // Where a load changed: whether that began (1) or ended (0) what is beside the scene's, or only went on.
    std::optional<double> acts = {};
  };

  /// The physics must outlive this. What `model` was loaded with is what loaded() brings back.
  LiveSettings(const Model& model, Physics& physics);

  /// Takes a SetFriction, SetMaterial or what changes LiveLoads to the physics; it counts from the next tick on.
  Answer apply(const Request& request);

  /// The physics has a state from elsewhere.
  void recall() { friction_ = physics_.state().live.friction; }

  /// The requests that bring back what was loaded: a script or replay that starts over must find it.
  const std::vector<Request>& loaded() const { return loaded_; }

 private:
  Answer setFriction(int tool, double coefficient);
  Answer setMaterial(int index, const Material& material);
  Answer setLoad(const Request& request);

  Physics& physics_;
  const int tool_count_, material_count_, vertex_count_, boundary_count_;
  const Vec3 gravity_;  // m/s^2, the scene's
  const std::vector<Request> loaded_;
  std::array<double, max_tools> friction_;  // (tool_count) the last that were asked for
};

/// What makes of the loaded settings those in force, in the order in which it has to be asked for.
std::vector<Request> settingsInForce(const Model& model, const LiveParameters& live);

/// `loads` with what a request changes of them. @param gravity  m/s^2, the scene's
/// @return false where it can't be: no such place, no room, or no request of LiveLoads
bool changeLoads(const Request& request, int vertex_count, int boundary_count, const Vec3& gravity, LiveLoads& loads);

}  // namespace palpate
