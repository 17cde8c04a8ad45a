#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <span>
#include <utility>

#include "api/border.h"
#include "api/handles.h"
#include "base/build_info.h"
#include "base/number_text.h"
#include "mechanics/materials/material_law.h"
#include "realtime/loop/thread_setup.h"

using namespace palpate;
using namespace palpate::api;

namespace {

/// A body whose places are made by a worker of its own.
std::unique_ptr<FollowingTissue> followingOf(const palpate_model& of, int threads) {
  if (!of.places) return nullptr;
  return std::make_unique<FollowingTissue>(of.places, threads, false);
}

/// What nobody takes from the loop need not be kept.
SimulationLoopOptions loopOptions(FollowingTissue* following) {
  SimulationLoopOptions options;
  options.follower = following != nullptr ? &following->follower : nullptr;
  options.force_capacity = 1;
  options.record_capacity = 1;
  options.undo = false;
  return options;
}

}  // namespace

palpate_simulation::palpate_simulation(const palpate_model& of, int threads)
    : identity(sourceIdentity()),
      model(of.model),
      following(followingOf(of, threads)),
      own_physics(following ? nullptr : std::make_unique<TissuePhysics>(*model, threads)),
      physics(following ? following->physics : *own_physics),
      loop(*model, physics, &physics.team(), loopOptions(following.get())),
      start(loop.memory()),
      materials(model->materials) {
  process = getpid();
  const FlushedDenormals here;  // setUpLoopThread leaves them flushed
  setUpLoopThread(&physics.team(), false);
}

namespace {

thread_local const palpate_simulation* in_call = nullptr;  // whose tick call the thread is in

#ifndef NDEBUG
/// How often the calling thread has given its core away of its own accord.
long waitCount() {
  rusage use{};
  getrusage(RUSAGE_THREAD, &use);
  return use.ru_nvcsw;
}
#endif

}  // namespace

bool palpate::api::isInTickCall(const palpate_simulation& simulation) { return in_call == &simulation; }

void TickCall::afterTick() {
  palpate_state state{};
  state.size = sizeof state;
  palpate_read(&of_, &state);
  struct InCall {
    explicit InCall(const palpate_simulation& of) : outer(std::exchange(in_call, &of)) {}
    ~InCall() { in_call = outer; }  // also where the call throws
    const palpate_simulation* const outer;
  };
  const InCall here(of_);
#ifndef NDEBUG
  const long waits = waitCount();
#endif
  call_(user_, &state);
#ifndef NDEBUG
  assert((!of_.running || waitCount() == waits) && "a call of palpate_on_tick has waited");
#endif
}

/// The loop takes it in the next tick; where none runs, now.
std::int32_t palpate::api::send(palpate_simulation& simulation, const Request& request) {
  if (isInTickCall(simulation)) return simulation.whyNot();
  if (!simulation.loop.commands().push(request))
    return refuse(PALPATE_REFUSED, "too much was asked for between two ticks, or the loop has not run for long");
  if (!simulation.running) simulation.loop.advanceHere(0);
  return PALPATE_OK;
}

namespace {

std::int32_t toolIsTaken() { return refuse(PALPATE_REFUSED, "a device has the tool; palpate_uncouple first"); }

std::int32_t ofTheParent() {
  return refuse(PALPATE_REFUSED, "a forked process has none of this simulation's threads; make a simulation in it");
}

void setHand(palpate_simulation& simulation, const Pose& pose, std::uint64_t sequence) {
  HandSlot& hand = simulation.loop.hand();
  hand.back() = {pose, sequence};
  hand.publish();
}

/// Whether scenes and programs give it: others follow from the scene's scheme.
bool isGiven(const Parameter& parameter) {
  const auto common = commonMaterialParameters();
  return std::none_of(common.begin(), common.end(),
                      [&](const CommonMaterialParameter& c) { return &c.parameter == &parameter && !c.is_key; });
}

}  // namespace

void palpate::api::setParameter(Material& material, const palpate_parameter& wanted) {
  if (wanted.name == nullptr || wanted.values == nullptr || wanted.count < 1)
    throw Refusal(PALPATE_BAD_ARGUMENT, "a parameter without name or values");
  const std::span<const double> values(wanted.values, static_cast<std::size_t>(wanted.count));
  const Parameter* found = nullptr;
  std::size_t room = 0;
  std::string names;
  forEachParameter(material, [&](const Parameter& p, std::span<double> present) {
    if (!isGiven(p)) return;
    names += (names.empty() ? "" : ", ") + std::string(p.name);
    if (std::string(wanted.name) == p.name) found = &p, room = present.size();
  });
  const std::string name = inQuotes(wanted.name);
  if (found == nullptr) throw Refusal(PALPATE_BAD_ARGUMENT, "the material has no " + name + "; it has " + names);
  if (room == 0) throw Refusal(PALPATE_BAD_ARGUMENT, "the scene gives the material no " + name + " to be changed");
  if (values.size() != room)
    throw Refusal(PALPATE_BAD_ARGUMENT, name + " takes " + std::to_string(room) + " values, as the scene gives it");
  for (const double value : values)
    if (!std::isfinite(value) || !found->range.contains(value))
      throw Refusal(PALPATE_BAD_ARGUMENT, name + " must be " + found->range.text());
  forEachParameter(material, [&](const Parameter& p, std::span<double> present) {
    if (&p == found) std::copy(values.begin(), values.end(), present.begin());
  });
}

void palpate::api::checkMaterial(const Material& material) {
  const MaterialLaw& law = material.lawDescription();
  std::optional<ParameterProblem> problem = law.check != nullptr ? law.check(material) : std::nullopt;
  if (!problem) problem = relaxationProblem(material);
  if (!problem) return;
  throw Refusal(PALPATE_BAD_ARGUMENT,
                std::string(problem->parameter) + ": " + problem->problem + "; " + problem->advice);
}

void palpate::api::checkMatter(const Material& material) {
  if (!isOfMatter(material))
    throw Refusal(PALPATE_BAD_ARGUMENT,
                  format("a shear modulus of %.3g Pa is that of no matter; give moduli in Pa", material.shear_modulus));
}

extern "C" {

int32_t palpate_create(const palpate_model* model, palpate_simulation** simulation, palpate_error* error) {
  if (simulation != nullptr) *simulation = nullptr;
  if (const std::int32_t code = nullAmong(error, {{model, "model"}, {simulation, "simulation"}})) return code;
  return guarded(error, [&] {
    *simulation = new palpate_simulation(*model, model->model->scene.dynamics.threads);
    return PALPATE_OK;
  });
}

void palpate_destroy(palpate_simulation* simulation) {
  if (simulation == nullptr || isInTickCall(*simulation)) return;  // a tick can't end what it is part of
  if (simulation->process == getpid()) delete simulation;          // else its threads are the parent's
}

int32_t palpate_step(palpate_simulation* simulation, int64_t n, const double* pose, palpate_state* state) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  if (n < 0) return refuse(PALPATE_BAD_ARGUMENT, "n is negative");
  if (pose != nullptr)
    if (const int32_t code = poseProblem(pose, "pose")) return code;
  if (state != nullptr && !isSize(state->size)) return badSize(state->size);
  if (const int32_t code = simulation->whyNot()) return code;
  if (pose != nullptr && simulation->coupling) return toolIsTaken();
  if (simulation->following && simulation->process != getpid()) return ofTheParent();
  return guarded(nullptr, [&] {
    if (pose != nullptr) setHand(*simulation, poseFrom(pose), ++simulation->step_sequence);
    simulation->loop.advanceHere(n);
    return state != nullptr ? palpate_read(simulation, state) : PALPATE_OK;
  });
}

int32_t palpate_start(palpate_simulation* simulation, uint32_t flags) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  if ((flags & ~static_cast<std::uint32_t>(PALPATE_ORDINARY_THREAD)) != 0)
    return refuse(PALPATE_BAD_ARGUMENT, "flags are %u, which none are", flags);
  if (const int32_t code = simulation->whyNot()) return code;
  if (simulation->process != getpid() && (simulation->following || simulation->physics.team().size() > 1))
    return ofTheParent();
  return guarded(nullptr, [&] {
    if (simulation->following) simulation->following->keepToClock();
    simulation->loop.setRealTime((flags & PALPATE_ORDINARY_THREAD) == 0);
    simulation->loop.start();
    simulation->running = true;
    return PALPATE_OK;
  });
}

int32_t palpate_stop(palpate_simulation* simulation) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  if (isInTickCall(*simulation)) return simulation->whyNot();  // it would wait for itself
  if (!simulation->running) return PALPATE_OK;                 // a loop that never ran would remember it
  return guarded(nullptr, [&] {
    simulation->loop.quit();
    simulation->loop.join();
    endRealTime(simulation->physics.team());  // the caller's thread steps with them now
    simulation->running = false;
    return PALPATE_OK;
  });
}

int32_t palpate_set_target(palpate_simulation* simulation, const double* pose, uint64_t sequence) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  if (const int32_t code = poseProblem(pose, "pose")) return code;
  if (simulation->coupling) return toolIsTaken();
  setHand(*simulation, poseFrom(pose), sequence);
  return PALPATE_OK;
}

int32_t palpate_read(const palpate_simulation* simulation, palpate_state* state) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  const ForceReading reading = simulation->loop.force();
  const ForceSample& s = reading.sample;
  palpate_state out{};
  out.doubt = numberOf(s.doubt);
  out.fresh = reading.fresh;
  out.frozen = s.frozen;
  out.contact_count = s.contact_count;
  out.loss_count = static_cast<std::int32_t>(s.loss_count);
  out.tick = s.tick;
  out.pose_sequence = s.pose_sequence;
  out.time_s = s.time_s;
  out.age_s = s.tick > 0 && s.wall_ns > 0 ? reading.age_s : 0;
  put(s.tick > 0 ? s.tool_pose : simulation->model->tools.first().start.pose, out.pose);
  put(s.force_raw, out.force);
  put(s.force_filtered, out.force_filtered);
  put(s.torque, out.torque);
  put(s.contact_normal, out.normal);
  out.stiffness = s.stiffness;
  out.depth_m = s.depth_m;
  out.advance_m = s.advance_m;
  out.work_J = s.work_J;
  out.expected_error = s.expected_error;
  return fill(state, out);
}

int32_t palpate_set_friction(palpate_simulation* simulation, double coefficient) {
  return palpate_set_tool_friction(simulation, 0, coefficient);
}

int32_t palpate_set_tool_friction(palpate_simulation* simulation, int32_t tool, double coefficient) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  if (const int32_t code = outside("tool", tool, 0, simulation->model->tools.toolCount())) return code;
  if (!(coefficient >= 0 && coefficient <= Request::most_friction))
    return refuse(PALPATE_BAD_ARGUMENT, "the coefficient is %g, not in 0 .. %g", coefficient, Request::most_friction);
  return guarded(nullptr, [&] { return send(*simulation, Request::setFriction(coefficient, tool)); });
}

int32_t palpate_on_tick(palpate_simulation* simulation, palpate_tick_call call, void* user) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  if (const int32_t code = simulation->whyNot()) return code;
  return guarded(nullptr, [&] {
    auto made = call != nullptr ? std::make_unique<TickCall>(*simulation, call, user) : nullptr;
    simulation->loop.setListener(made.get());
    simulation->tick_call = std::move(made);
    return PALPATE_OK;
  });
}

int32_t palpate_set_material(palpate_simulation* simulation, int32_t material, const palpate_parameter* parameters,
                             int32_t parameter_count, palpate_error* error) {
  if (const std::int32_t code = nullAmong(error, {{simulation, "simulation"}, {parameters, "parameters"}})) return code;
  if (material < 0 || material >= static_cast<int>(simulation->model->scene.materials.size()))
    return say(error, PALPATE_BAD_ARGUMENT, "there is no material of that number");
  if (parameter_count < 1) return say(error, PALPATE_BAD_ARGUMENT, "parameter_count is less than 1");
  return guarded(error, [&] {
    if (simulation->materials.size() != simulation->model->scene.materials.size())
      throw Refusal(PALPATE_REFUSED,
                    "the materials of a scene that mixes them can't be changed live; load another scene");
    Material& present = simulation->materials[static_cast<std::size_t>(material)];
    Material wanted = present;
    for (int k = 0; k < parameter_count; ++k) setParameter(wanted, parameters[k]);
    checkMaterial(wanted);
    if (wanted.density != present.density)
      throw Refusal(PALPATE_REFUSED,
                    "density can't be changed live, as the nodes' masses are made of it; load a scene "
                    "that has it");
    wanted.updateModuli();
    checkMatter(wanted);
    if (const double excess = simulation->physics.excessOf(material, wanted); excess > 0)
      throw Refusal(PALPATE_REFUSED, "the material is " + std::to_string(excess) +
                                         " times too stiff for the time step: of a modulus at most 1 / " +
                                         std::to_string(excess) +
                                         " of it, or load a scene that has it (a smaller dynamics.step_safety leaves "
                                         "more room)");
    const std::int32_t code = send(*simulation, Request::setMaterial(material, wanted));
    if (code == PALPATE_OK) present = wanted;
    return code;
  });
}

int32_t palpate_material_parameter(const palpate_simulation* simulation, int32_t material, int32_t index,
                                   palpate_parameter* parameter) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}, {parameter, "parameter"}})) return code;
  const std::vector<MaterialSpec>& of_scene = simulation->model->scene.materials;
  if (const int32_t code = outside("material", material, 0, static_cast<std::int32_t>(of_scene.size()))) return code;
  if (index < 0) return refuse(PALPATE_BAD_ARGUMENT, "index is negative");
  const auto m = static_cast<std::size_t>(material);
  const bool mixed = simulation->materials.size() != of_scene.size();  // then none can be set
  *parameter = {};
  int k = 0;
  forEachParameter(mixed ? of_scene[m].material : simulation->materials[m],
                   [&](const Parameter& p, std::span<const double> values) {
                     if (isGiven(p) && !values.empty() && k++ == index)
                       *parameter = {p.name, values.data(), static_cast<std::int32_t>(values.size())};
                   });
  return PALPATE_OK;
}

int32_t palpate_reset(palpate_simulation* simulation) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  if (isInTickCall(*simulation)) return simulation->whyNot();
  return guarded(nullptr, [&]() -> std::int32_t {
    if (simulation->running) return send(*simulation, Request::simple(Request::Kind::Reset));
    if (simulation->recorder)
      return refuse(PALPATE_REFUSED, "it is recorded, and its ticks would begin anew; palpate_record_stop first");
    simulation->physics.reset();
    simulation->loop.recall(simulation->start);
    simulation->step_sequence = 0;
    return PALPATE_OK;
  });
}

}  // extern "C"
