#include "api/border.h"
#include "api/handles.h"
#include "realtime/loop/live_settings.h"

using namespace palpate;
using namespace palpate::api;

namespace {

/// What may be set beyond which no scene goes.
constexpr double max_gravity = 1000;  // m/s^2, a hundred times the earth's

bool isWithin(const double* x, double most) {
  return isPlace(x) && std::all_of(x, x + 3, [most](double v) { return std::abs(v) <= most; });
}

bool isVertex(const palpate_simulation* simulation, std::int32_t vertex) {
  return simulation != nullptr && vertex >= -1 && vertex < simulation->model->skin.vertexCount();
}

Vec3 vectorOf(const double* x) { return {x[0], x[1], x[2]}; }

/// Asks the loop for other loads, unless there is no room for them.
std::int32_t change(palpate_simulation& simulation, const Request& request) {
  return guarded(nullptr, [&]() -> std::int32_t {
    const Model& model = *simulation.model;
    LiveLoads wanted = simulation.loads;
    if (!changeLoads(request, model.skin.vertexCount(), static_cast<int>(model.boundary.motions.size()),
                     model.scene.dynamics.gravity, wanted))
      return PALPATE_REFUSED;
    const std::int32_t code = send(simulation, request);
    if (code == PALPATE_OK) simulation.loads = wanted;
    return code;
  });
}

}  // namespace

extern "C" {

int32_t palpate_set_gravity(palpate_simulation* simulation, const double* acceleration) {
  if (simulation == nullptr || !isWithin(acceleration, max_gravity)) return PALPATE_BAD_ARGUMENT;
  return change(*simulation, Request::setGravity(vectorOf(acceleration)));
}

int32_t palpate_set_force(palpate_simulation* simulation, int32_t vertex, const double* force) {
  if (!isVertex(simulation, vertex) || (force == nullptr ? vertex >= 0 : !isPlace(force))) return PALPATE_BAD_ARGUMENT;
  const Vec3 given = force == nullptr ? Vec3(Vec3::Zero()) : vectorOf(force);
  if (vertex < 0 && !given.isZero(0)) return PALPATE_BAD_ARGUMENT;  // no force on all
  return change(*simulation, Request::setForce(vertex, given));
}

int32_t palpate_pin(palpate_simulation* simulation, int32_t vertex, const double* place) {
  if (!isVertex(simulation, vertex) || (place != nullptr && (vertex < 0 || !isPlace(place))))
    return PALPATE_BAD_ARGUMENT;
  return change(*simulation, place != nullptr ? Request::pin(vertex, vectorOf(place)) : Request::unpin(vertex));
}

int32_t palpate_move_region(palpate_simulation* simulation, int32_t region, const double* shift) {
  if (simulation == nullptr || region < 0 || !isPlace(shift)) return PALPATE_BAD_ARGUMENT;
  if (region >= static_cast<std::int32_t>(simulation->model->boundary.motions.size())) return PALPATE_BAD_ARGUMENT;
  return change(*simulation, Request::moveRegion(region, vectorOf(shift)));
}

int32_t palpate_pull(palpate_simulation* simulation, int32_t vertex, const double* place) {
  if (!isVertex(simulation, vertex) || (vertex >= 0 && !isPlace(place))) return PALPATE_BAD_ARGUMENT;
  return guarded(nullptr, [&] {
    return send(*simulation,
                vertex < 0 ? Request::simple(Request::Kind::ReleasePull) : Request::pull(vertex, vectorOf(place)));
  });
}

}  // extern "C"
