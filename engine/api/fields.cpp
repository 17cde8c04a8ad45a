#include <numeric>

#include "api/border.h"
#include "api/handles.h"
#include "model/solution_fields.h"
#include "scene/scene_messages.h"
#include "setup/body_points.h"

using namespace palpate;
using namespace palpate::api;

namespace {

constexpr std::int32_t max_points = 10'000'000;

[[noreturn]] void refusePoint(const palpate_points& points, std::size_t k, const char* why) {
  throw Refusal(PALPATE_BAD_ARGUMENT, "point " + std::to_string(k) + " at " + coordinates(points.X[k]) + why);
}

/// Refuses the first that the body does not have.
void check(const palpate_points& points) {
  const SurfaceTree skin(points.model->skin.surface);
  const double tolerance = 0.05 * points.model->scene.discretization.spacing;  // flat faces stand for round ones
  for (std::size_t k = 0; k < points.X.size(); ++k)
    if (skin.signedDistance(points.X[k]) > tolerance) refusePoint(points, k, " is not in the body");
}

/// Of any points of the body.
std::shared_ptr<const palpate_points::Rows> makeRows(const palpate_points& points,
                                                     const std::shared_ptr<const Model>& model) {
  auto rows = std::make_shared<palpate_points::Rows>();
  rows->of = model;
  const std::vector<int> body = bodiesAt(*model, points.X);
  rows->own = shapeAt(*model, points.X, body);
  rows->shape = &rows->own;
  rows->nearest = nearestPoints(*model, points.X, body);
  return rows;
}

/// What is wrong unless the points are the simulation's, and the caller's memory is for all of them.
std::int32_t misfit(const palpate_points* points, const palpate_simulation* simulation, std::int32_t count) {
  if (const std::int32_t code = nullAmong({{simulation, "simulation"}, {points, "points"}})) return code;
  if (points->model != simulation->model) return refuse(PALPATE_BAD_ARGUMENT, "the points are another model's");
  return otherThan("count", count, static_cast<std::size_t>(points->count()));
}

template <class Values>
void putField(const palpate_points::Rows& rows, const Values& values, double factor, double* out) {
  const auto value = [&](int i) { return toVec3(values[static_cast<std::size_t>(i)]); };
  for (std::size_t k = 0; k + 1 < rows.shape->begin.size(); ++k)
    put(factor * fieldAt(*rows.shape, k, value), out + 3 * k);
}

}  // namespace

std::shared_ptr<const palpate_points::Rows> palpate_points::rowsAt(const std::shared_ptr<const Model>& place) const {
  if (place == model) return rows;
  const std::lock_guard lock(mutex_);
  if (!last_ || last_->of != place) last_ = makeRows(*this, place);
  return last_;
}

extern "C" {

int32_t palpate_points_create(const palpate_model* model, const double* X, int32_t count, palpate_points** points,
                              palpate_error* error) {
  if (points != nullptr) *points = nullptr;
  if (const std::int32_t code = sayToo(error, outside("count", count, 1, max_points + 1))) return code;
  if (const std::int32_t code = nullAmong(error, {{model, "model"}, {X, "X"}, {points, "points"}})) return code;
  return guarded(error, [&] {
    auto made = std::make_unique<palpate_points>();
    made->model = model->model;
    for (std::int32_t k = 0; k < count; ++k) {
      made->X.emplace_back(X + 3 * static_cast<std::size_t>(k));
      if (!made->X.back().allFinite())
        throw Refusal(PALPATE_BAD_ARGUMENT, "point " + std::to_string(k) + " is not finite");
    }
    check(*made);
    made->rows = makeRows(*made, made->model);
    *points = made.release();
    return PALPATE_OK;
  });
}

int32_t palpate_points_of(const palpate_model* model, int32_t kind, palpate_points** points, palpate_error* error) {
  if (points != nullptr) *points = nullptr;
  if (const std::int32_t code = nullAmong(error, {{model, "model"}, {points, "points"}})) return code;
  if (kind != PALPATE_NODES && kind != PALPATE_INTEGRATION_POINTS)
    return say(error, PALPATE_BAD_ARGUMENT, ("there is no kind " + std::to_string(kind)).c_str());
  return guarded(error, [&] {
    auto made = std::make_unique<palpate_points>();
    made->model = model->model;
    const Model& m = *made->model;
    auto rows = std::make_shared<palpate_points::Rows>();
    rows->of = made->model;
    if (kind == PALPATE_NODES) {
      made->X = m.X;
      rows->shape = &m.node_shape;
      std::vector<int> body;
      for (int i = 0; i < m.nodeCount(); ++i) body.push_back(m.bodyOfNode(i));
      rows->nearest = nearestPoints(m, m.X, body);
    } else {
      made->X = m.point_X;
      made->have_volumes = true;
      rows->shape = &m.point_shape;
      rows->nearest.resize(m.point_X.size());
      std::iota(rows->nearest.begin(), rows->nearest.end(), 0);
    }
    made->rows = std::move(rows);
    *points = made.release();
    return PALPATE_OK;
  });
}

void palpate_points_destroy(palpate_points* points) { delete points; }

int32_t palpate_points_rest(const palpate_points* points, double* X, double* volume, int32_t count) {
  if (const int32_t code = nullAmong({{points, "points"}})) return code;
  if (const int32_t code = otherThan("count", count, static_cast<std::size_t>(points->count()))) return code;
  const Model& model = *points->model;
  if (volume != nullptr && !points->have_volumes)
    return refuse(PALPATE_BAD_ARGUMENT, "only integration points have volumes; give NULL");
  for (std::size_t k = 0; X != nullptr && k < points->X.size(); ++k) put(points->X[k], X + 3 * k);
  if (volume != nullptr) std::copy(model.point_volume.begin(), model.point_volume.end(), volume);
  return PALPATE_OK;
}

int32_t palpate_displacements(palpate_simulation* simulation, const palpate_points* points, double* u, int32_t count) {
  if (const int32_t code = nullAmong({{u, "u"}})) return code;
  if (const int32_t code = misfit(points, simulation, count)) return code;
  return guarded(nullptr, [&] {
    const Snapshot& snapshot = simulation->loop.snapshots().latest();
    const auto place =
        snapshot.place ? std::shared_ptr<const Model>(snapshot.place, &snapshot.place->model) : simulation->model;
    putField(*points->rowsAt(place), snapshot.u, 1, u);
    return PALPATE_OK;
  });
}

int32_t palpate_velocities(const palpate_simulation* simulation, const palpate_points* points, double* v,
                           int32_t count) {
  if (const int32_t code = nullAmong({{v, "v"}})) return code;
  if (const int32_t code = misfit(points, simulation, count)) return code;
  if (!simulation->standsStill()) return simulation->busy();
  return guarded(nullptr, [&] {
    const auto rows = points->rowsAt(simulation->sharedPresent());
    putField(*rows, simulation->physics.state().du, 1 / simulation->model->dt, v);
    return PALPATE_OK;
  });
}

int32_t palpate_stresses(const palpate_simulation* simulation, const palpate_points* points, double* stress, double* J,
                         int32_t count) {
  if (const int32_t code = misfit(points, simulation, count)) return code;
  if (!simulation->standsStill()) return simulation->busy();
  return guarded(nullptr, [&] {
    const auto rows = points->rowsAt(simulation->sharedPresent());
    const Model& model = *rows->of;
    const State& state = simulation->physics.state();
    std::vector<Vec3> u;
    for (const Float4& a : state.u) u.push_back(toVec3(a));
    const PointHistory history = pointHistory(model.kernel, state.relaxation, model.pointCount(), model.dt);
    std::vector<Mat3> F;
    const std::vector<Mat3> P =
        pointStresses(model, u, F, history, simulation->physics.holdingFriction(), &state.live.kernel);
    for (std::size_t k = 0; k < points->X.size(); ++k) {
      const auto q = static_cast<std::size_t>(rows->nearest[k]);
      const double volume_ratio = F[q].determinant();
      const Mat3 tau = P[q] * F[q].transpose(), cauchy = (tau + tau.transpose()) / (2 * volume_ratio);
      if (stress != nullptr) std::copy_n(cauchy.data(), 9, stress + 9 * k);
      if (J != nullptr) J[k] = volume_ratio;
    }
    return PALPATE_OK;
  });
}

int32_t palpate_reactions(const palpate_simulation* simulation, double* force, double* moment, int32_t region_count) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  const std::vector<Reaction>& reactions = simulation->physics.reactions();
  if (const int32_t code = otherThan("region_count", region_count, reactions.size())) return code;
  if (!simulation->standsStill()) return simulation->busy();
  for (std::size_t b = 0; b < reactions.size(); ++b) {
    if (force != nullptr) put(reactions[b].force, force + 3 * b);
    if (moment != nullptr) put(reactions[b].moment, moment + 3 * b);
  }
  return PALPATE_OK;
}

int32_t palpate_pin_force(const palpate_simulation* simulation, int32_t vertex, double* force) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}, {force, "force"}})) return code;
  if (const int32_t code = outside("vertex", vertex, 0, simulation->model->skin.vertexCount())) return code;
  if (!simulation->standsStill()) return simulation->busy();
  put(simulation->physics.pinForce(vertex), force);
  return PALPATE_OK;
}

}  // extern "C"
