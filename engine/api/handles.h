#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "api/border.h"
#include "api/palpate.h"
#include "discretization/surface/surface_tree.h"
#include "model/model.h"
#include "realtime/device/coupled_tool.h"
#include "realtime/device/device_coupling.h"
#include "realtime/loop/cloud_follower.h"
#include "realtime/loop/simulation_loop.h"

namespace palpate::api {

/// By PALPATE_MATERIAL, PALPATE_TOOL, PALPATE_REGION, PALPATE_RIGID.
using Names = std::array<std::vector<std::string>, 4>;
Names namesOf(const Model& model);

/// What hangs the tool on a device: the loop's end and the device's.
struct Coupling {
  Coupling(const Model& model, const DeviceSettings& settings) : tool(model), device(settings, model) {}
  CoupledTool tool;
  DeviceCoupling device;
};

/// The skin where these displacements have it.
struct DeformedSkin {
  AlignedVector<Float4> u;
  SurfaceTree tree;
};

/// Calls a function of the caller's after each tick.
class TickCall final : public TickListener {
 public:
  TickCall(palpate_simulation& of, palpate_tick_call call, void* user) : of_(of), call_(call), user_(user) {}
  void afterTick() override;

 private:
  palpate_simulation& of_;
  const palpate_tick_call call_;
  void* const user_;
};

/// Keeps what a loop tells of its input until it is written.
class Recorder {
 public:
  /// @param begin  what is recorded already
  explicit Recorder(std::vector<TimedRequest> begin);
  ~Recorder();

  SpscRing<TimedRequest>& ring() { return ring_; }  // the loop's to push
  /// So far; while nobody pushes.
  const std::vector<TimedRequest>& changes();

 private:
  void take();

  const int process_;  // that made it
  SpscRing<TimedRequest> ring_{1 << 14};
  std::mutex mutex_;  // of what follows; never the loop's
  std::vector<TimedRequest> changes_;
  std::atomic<bool> ended_{false};
  std::thread thread_;  // takes from the ring
};

/// A parameter's new values in a material. Throws Refusal where they can't be.
void setParameter(Material& material, const palpate_parameter& wanted);

/// Throws Refusal where the parameters of a material don't fit each other.
void checkMaterial(const Material& material);
/// Refuses what is softer than any matter.
void checkMatter(const Material& material);

/// Asks the loop for something: it is done in the next tick, or now where none runs.
std::int32_t send(palpate_simulation& simulation, const Request& request);

/// Whether the calling thread is in a TickCall of the simulation, which stands still meanwhile.
bool isInTickCall(const palpate_simulation& simulation);

}  // namespace palpate::api

/// What is behind the handles of palpate.h.
struct palpate_model {
  std::shared_ptr<const palpate::Model> model;  // where the cloud follows the tool, that of its first place
  palpate::api::Names names;
  std::shared_ptr<palpate::PlaceSource> places;  // null: the cloud stays
};

struct palpate_simulation {
  palpate_simulation(const palpate_model& of, int threads);

  std::string identity;  // of the sources: a library beside this one looks into this struct
  std::shared_ptr<const palpate::Model> model;
  std::unique_ptr<palpate::FollowingTissue> following;  // null: the cloud stays
  std::unique_ptr<palpate::TissuePhysics> own_physics;  // else null
  palpate::TissuePhysics& physics;
  std::unique_ptr<palpate::api::Coupling> coupling;   // null: a hand or program has the tool
  std::unique_ptr<palpate::api::TickCall> tick_call;  // null: nobody wants to know
  std::unique_ptr<palpate::api::Recorder> recorder;   // null: nothing is recorded
  palpate::SimulationLoop loop;
  palpate::RunMemory start;                  // of the loop, before its first tick
  std::vector<palpate::Material> materials;  // as last asked for
  palpate::LiveLoads loads;                  // likewise
  std::uint64_t step_sequence = 0;           // of the last pose given to palpate_step
  std::atomic<bool> running{false};
  std::unique_ptr<const palpate::api::DeformedSkin> skin;  // that the last question was asked of; the viewer's
  int process = 0;  // that made it: one that was forked off has a copy without physics threads

  /// That of the present state.
  const palpate::Model& present() const { return physics.place() ? physics.place()->place.model : *model; }
  std::shared_ptr<const palpate::Model> sharedPresent() const {
    const auto& place = physics.place();
    return place ? std::shared_ptr<const palpate::Model>(place, &place->place.model) : model;
  }
  /// Whether the calling thread may look at the state.
  bool standsStill() const { return !running || palpate::api::isInTickCall(*this); }
  static std::int32_t busy() { return palpate::api::refuse(PALPATE_BUSY, "%s", palpate_result_text(PALPATE_BUSY)); }
  /// Why it may not change the state or the loop: PALPATE_OK, PALPATE_BUSY or, in a tick call, PALPATE_REFUSED.
  std::int32_t whyNot() const {
    if (palpate::api::isInTickCall(*this))
      return palpate::api::refuse(PALPATE_REFUSED, "not from a call of palpate_on_tick");
    return running ? busy() : PALPATE_OK;
  }
};

struct palpate_points {
  /// How the nodes of a model carry the points.
  struct Rows {
    std::shared_ptr<const palpate::Model> of;
    palpate::ShapeTable own;                     // of given points
    const palpate::ShapeTable* shape = nullptr;  // own, or one of the model's
    std::vector<int> nearest;                    // (count) integration point
  };
  std::vector<palpate::Vec3> X;                 // (count) m
  std::shared_ptr<const palpate::Model> model;  // that they were made for
  std::shared_ptr<const Rows> rows;             // there
  bool have_volumes = false;                    // they are its integration points

  int count() const { return static_cast<int>(X.size()); }
  /// Those there, or where the cloud follows the tool at another place, whose last are kept (and the place with them).
  /// Any thread. Throws Refusal where nodes can't carry a point.
  std::shared_ptr<const Rows> rowsAt(const std::shared_ptr<const palpate::Model>& place) const;

 private:
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const Rows> last_;
};
