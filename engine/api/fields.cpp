#include <numeric>

#include "api/border.h"
#include "api/handles.h"
#include "simulation/body_points.h"
#include "simulation/scene_messages.h"
#include "simulation/solution_fields.h"

using namespace palpate;
using namespace palpate::api;

namespace {

constexpr std::int32_t max_points = 10'000'000;

/// Refuses the first that the body does not have, or its nodes can't carry.
void check(const palpate_points& points, const std::vector<InadmissibleSupport>& failed) {
  const SurfaceTree skin(points.model->skin.surface);
  const double tolerance = 0.05 * points.model->scene.spacing;  // flat faces stand for round ones
  const auto refuse = [&](std::size_t k, const char* why) {
    throw Refusal(PALPATE_BAD_ARGUMENT, "point " + std::to_string(k) + " at " + coordinates(points.X[k]) + why);
  };
  for (std::size_t k = 0; k < points.X.size(); ++k)
    if (skin.signedDistance(points.X[k]) > tolerance) refuse(k, " is not in the body");
  if (!failed.empty()) refuse(static_cast<std::size_t>(failed.front().row), " has too few nodes around it");
}

/// Whether the points are the simulation's, and the caller's memory is for all of them.
bool fits(const palpate_points* points, const palpate_simulation* simulation, std::int32_t count) {
  return points != nullptr && simulation != nullptr && points->model == simulation->model && count == points->count();
}

/// The field of nodal values at a point.
template <class Values>
Vec3 fieldAt(const ShapeTable& shape, std::size_t row, const Values& values) {
  Vec3 sum = Vec3::Zero();
  for (int e = shape.begin[row]; e < shape.begin[row + 1]; ++e) {
    const auto entry = static_cast<std::size_t>(e);
    sum += shape.N[entry] * toVec3(values[static_cast<std::size_t>(shape.node[entry])]);
  }
  return sum;
}

template <class Values>
void putField(const palpate_points& points, const Values& values, double factor, double* out) {
  for (std::size_t k = 0; k < points.X.size(); ++k) put(factor * fieldAt(*points.shape, k, values), out + 3 * k);
}

}  // namespace

extern "C" {

int32_t palpate_points_create(const palpate_model* model, const double* X, int32_t count, palpate_points** points,
                              palpate_error* error) {
  if (points != nullptr) *points = nullptr;
  if (model == nullptr || points == nullptr || X == nullptr || count < 1 || count > max_points)
    return say(error, PALPATE_BAD_ARGUMENT, "model, X or points is NULL, or count not in 1 .. 1e7");
  return guarded(error, [&] {
    requireCloudThatStays(*model, "fields");
    auto made = std::make_unique<palpate_points>();
    made->model = model->model;
    for (std::int32_t k = 0; k < count; ++k) {
      made->X.emplace_back(X + 3 * static_cast<std::size_t>(k));
      if (!made->X.back().allFinite())
        throw Refusal(PALPATE_BAD_ARGUMENT, "point " + std::to_string(k) + " is not finite");
    }
    std::vector<InadmissibleSupport> failed;
    made->own = shapeAt(*made->model, made->X, failed);
    check(*made, failed);
    made->shape = &made->own;
    made->nearest = nearestPoints(*made->model, made->X);
    *points = made.release();
    return PALPATE_OK;
  });
}

int32_t palpate_points_of(const palpate_model* model, int32_t kind, palpate_points** points, palpate_error* error) {
  if (points != nullptr) *points = nullptr;
  if (model == nullptr || points == nullptr || (kind != PALPATE_NODES && kind != PALPATE_INTEGRATION_POINTS))
    return say(error, PALPATE_BAD_ARGUMENT, "model or points is NULL, or there is no such kind");
  return guarded(error, [&] {
    requireCloudThatStays(*model, "fields");
    auto made = std::make_unique<palpate_points>();
    made->model = model->model;
    const Model& m = *made->model;
    if (kind == PALPATE_NODES) {
      made->X = m.X;
      made->shape = &m.node_shape;
      made->nearest = nearestPoints(m, m.X);
    } else {
      made->X = m.point_X;
      made->shape = &m.point_shape;
      made->nearest.resize(m.point_X.size());
      std::iota(made->nearest.begin(), made->nearest.end(), 0);
    }
    *points = made.release();
    return PALPATE_OK;
  });
}

void palpate_points_destroy(palpate_points* points) { delete points; }

int32_t palpate_points_rest(const palpate_points* points, double* X, double* volume, int32_t count) {
  if (points == nullptr || count != points->count()) return PALPATE_BAD_ARGUMENT;
  const Model& model = *points->model;
  if (volume != nullptr && points->shape != &model.point_shape) return PALPATE_BAD_ARGUMENT;
  for (std::size_t k = 0; X != nullptr && k < points->X.size(); ++k) put(points->X[k], X + 3 * k);
  if (volume != nullptr) std::copy(model.point_volume.begin(), model.point_volume.end(), volume);
  return PALPATE_OK;
}

int32_t palpate_displacements(palpate_simulation* simulation, const palpate_points* points, double* u, int32_t count) {
  if (u == nullptr || !fits(points, simulation, count)) return PALPATE_BAD_ARGUMENT;
  putField(*points, simulation->loop.snapshots().latest().u, 1, u);
  return PALPATE_OK;
}

int32_t palpate_velocities(const palpate_simulation* simulation, const palpate_points* points, double* v,
                           int32_t count) {
  if (v == nullptr || !fits(points, simulation, count)) return PALPATE_BAD_ARGUMENT;
  if (!simulation->standsStill()) return PALPATE_BUSY;
  putField(*points, simulation->physics.state().du, 1 / simulation->model->dt, v);
  return PALPATE_OK;
}

int32_t palpate_stresses(const palpate_simulation* simulation, const palpate_points* points, double* stress, double* J,
                         int32_t count) {
  if (!fits(points, simulation, count)) return PALPATE_BAD_ARGUMENT;
  if (!simulation->standsStill()) return PALPATE_BUSY;
  return guarded(nullptr, [&] {
    const Model& model = *simulation->model;
    const State& state = simulation->physics.state();
    std::vector<Vec3> u;
    for (const Float4& a : state.u) u.push_back(toVec3(a));
    const PointHistory history = pointHistory(model.kernel, state.relaxation, model.pointCount(), model.dt);
    std::vector<Mat3> F;
    const std::vector<Mat3> P = pointStresses(model, u, F, history, &state.live.kernel);
    for (std::size_t k = 0; k < points->X.size(); ++k) {
      const auto q = static_cast<std::size_t>(points->nearest[k]);
      const double volume_ratio = F[q].determinant();
      const Mat3 tau = P[q] * F[q].transpose(), cauchy = (tau + tau.transpose()) / (2 * volume_ratio);
      if (stress != nullptr) std::copy_n(cauchy.data(), 9, stress + 9 * k);
      if (J != nullptr) J[k] = volume_ratio;
    }
    return PALPATE_OK;
  });
}

int32_t palpate_reactions(const palpate_simulation* simulation, double* force, double* moment, int32_t region_count) {
  if (simulation == nullptr) return PALPATE_BAD_ARGUMENT;
  const std::vector<Reaction>& reactions = simulation->physics.reactions();
  if (region_count != static_cast<std::int32_t>(reactions.size())) return PALPATE_BAD_ARGUMENT;
  if (!simulation->standsStill()) return PALPATE_BUSY;
  for (std::size_t b = 0; b < reactions.size(); ++b) {
    if (force != nullptr) put(reactions[b].force, force + 3 * b);
    if (moment != nullptr) put(reactions[b].moment, moment + 3 * b);
  }
  return PALPATE_OK;
}

}  // extern "C"
