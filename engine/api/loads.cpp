#include "api/border.h"
#include "api/handles.h"
#include "realtime/loop/live_settings.h"

using namespace palpate;
using namespace palpate::api;

namespace {

/// What is wrong unless it is a vertex, or -1.
std::int32_t vertexProblem(const palpate_simulation* simulation, std::int32_t vertex) {
  if (const std::int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  return outside("vertex", vertex, -1, simulation->model->skin.vertexCount());
}

Vec3 vectorOf(const double* x) { return {x[0], x[1], x[2]}; }

/// Asks the loop for other loads, unless there is no room for them.
std::int32_t change(palpate_simulation& simulation, const Request& request) {
  return guarded(nullptr, [&]() -> std::int32_t {
    const Model& model = *simulation.model;
    LiveLoads wanted = simulation.loads;
    if (!changeLoads(request, model.skin.vertexCount(), static_cast<int>(model.boundary.motions.size()),
                     model.scene.dynamics.gravity, wanted))
      return refuse(PALPATE_REFUSED,
                    "there is no room for it: at most 64 vertices have forces, as many are pinned, and the first 16 "
                    "regions are moved");
    const std::int32_t code = send(simulation, request);
    if (code == PALPATE_OK) simulation.loads = wanted;
    return code;
  });
}

}  // namespace

extern "C" {

int32_t palpate_set_gravity(palpate_simulation* simulation, const double* acceleration) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  if (const int32_t code = placeProblem(acceleration, "acceleration")) return code;
  if (vectorOf(acceleration).cwiseAbs().maxCoeff() > Request::most_gravity)
    return refuse(PALPATE_BAD_ARGUMENT, "acceleration has a component beyond %g m/s^2", Request::most_gravity);
  return change(*simulation, Request::setGravity(vectorOf(acceleration)));
}

int32_t palpate_set_force(palpate_simulation* simulation, int32_t vertex, const double* force) {
  if (const int32_t code = vertexProblem(simulation, vertex)) return code;
  if (force != nullptr || vertex >= 0)
    if (const int32_t code = placeProblem(force, "force")) return code;
  const Vec3 given = force == nullptr ? Vec3(Vec3::Zero()) : vectorOf(force);
  if (vertex < 0 && !given.isZero(0))
    return refuse(PALPATE_BAD_ARGUMENT, "vertex is -1, which ends all forces, and force is not 0");
  return change(*simulation, Request::setForce(vertex, given));
}

int32_t palpate_pin(palpate_simulation* simulation, int32_t vertex, const double* place) {
  if (const int32_t code = vertexProblem(simulation, vertex)) return code;
  if (place != nullptr && vertex < 0) return refuse(PALPATE_BAD_ARGUMENT, "vertex is -1, which ends all pins");
  if (place != nullptr)
    if (const int32_t code = placeProblem(place, "place")) return code;
  return change(*simulation, place != nullptr ? Request::pin(vertex, vectorOf(place)) : Request::unpin(vertex));
}

int32_t palpate_move_region(palpate_simulation* simulation, int32_t region, const double* shift) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  const auto regions = static_cast<std::int32_t>(simulation->model->boundary.motions.size());
  if (const int32_t code = outside("region", region, 0, regions)) return code;
  if (const int32_t code = placeProblem(shift, "shift")) return code;
  return change(*simulation, Request::moveRegion(region, vectorOf(shift)));
}

int32_t palpate_pull(palpate_simulation* simulation, int32_t vertex, const double* place) {
  if (const int32_t code = vertexProblem(simulation, vertex)) return code;
  if (vertex >= 0)
    if (const int32_t code = placeProblem(place, "place")) return code;
  return guarded(nullptr, [&] {
    return send(*simulation,
                vertex < 0 ? Request::simple(Request::Kind::ReleasePull) : Request::pull(vertex, vectorOf(place)));
  });
}

}  // extern "C"
