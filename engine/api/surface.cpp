#include "api/border.h"
#include "api/handles.h"
#include "contact/samples/face_samples.h"
#include "contact/skin.h"
#include "step/tool_bodies.h"

using namespace palpate;
using namespace palpate::api;

namespace {

/// The skin in the newest tick as a tree, made anew where that has moved it.
const SurfaceTree& skinNow(palpate_simulation& simulation) {
  const Snapshot& snapshot = simulation.loop.snapshots().latest();
  const auto& u = snapshot.u;
  const auto& made = simulation.skin;
  if (!made || made->u.size() != u.size() || std::memcmp(made->u.data(), u.data(), u.size() * sizeof(Float4)) != 0) {
    const SkinModel& skin = modelOf(snapshot, *simulation.model).skin;
    TriangleSurface surface = skin.surface;
    for (int v = 0; v < skin.vertexCount(); ++v)
      surface.vertices[static_cast<std::size_t>(v)] = skinPosition(skin, v, u.data());
    simulation.skin.reset(new DeformedSkin{u, SurfaceTree(std::move(surface))});
  }
  return simulation.skin->tree;
}

/// Normal and barycentric coordinates of a place on a triangle.
void putPlace(const SurfaceTree& tree, int triangle, const Vec3& point, palpate_skin_point& out) {
  const auto& [a, b, c] = tree.surface().triangles[static_cast<std::size_t>(triangle)];
  const auto& x = tree.surface().vertices;
  const Vec3 A = x[static_cast<std::size_t>(a)], B = x[static_cast<std::size_t>(b)], C = x[static_cast<std::size_t>(c)];
  const Vec3 area = (B - A).cross(C - A);
  out.triangle = triangle;
  put(point, out.point);
  if (area.squaredNorm() <= 0) return;
  put(area.normalized(), out.normal);
  const double whole = area.squaredNorm();
  out.barycentric[0] = (C - B).cross(point - B).dot(area) / whole;
  out.barycentric[1] = (A - C).cross(point - C).dot(area) / whole;
  out.barycentric[2] = 1 - out.barycentric[0] - out.barycentric[1];
}

/// Calls call(tool, position, outward normal of the tool, force on the tissue) for each contact point with a force.
template <class Call>
void forEachContactPoint(const Model& model, const State& state, Call call) {
  for (int b = 0; b < model.tools.bodyCount(); ++b) {
    const ToolBody& body = model.tools.body[b];
    const Quat turn = bodyPose(body, state.tool[body.tool]).orientation;
    forEachTouched(state.contact[b], [&](double, const Float4& force, const Vec3f& normal, const SkinPoint& point) {
      call(body.tool, skinPosition(model.skin, point, state.u.data()), turn * normal.cast<double>(), toVec3(force));
    });
  }
}

}  // namespace

extern "C" {

int32_t palpate_skin_positions(palpate_simulation* simulation, float* positions, int32_t vertex_count) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}, {positions, "positions"}})) return code;
  const Snapshot& snapshot = simulation->loop.snapshots().latest();
  const SkinModel& skin = modelOf(snapshot, *simulation->model).skin;
  if (const int32_t code = otherThan("vertex_count", vertex_count, skin.surface.vertices.size())) return code;
  for (int v = 0; v < vertex_count; ++v) {
    const Vec3f x = skinPosition(skin, v, snapshot.u.data()).cast<float>();
    positions = std::copy_n(x.data(), 3, positions);
  }
  return PALPATE_OK;
}

int32_t palpate_rigid_forces(palpate_simulation* simulation, double* force, int32_t rigid_count) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}, {force, "force"}})) return code;
  if (const int32_t code = otherThan("rigid_count", rigid_count, simulation->model->rigid.body.size())) return code;
  const Snapshot& snapshot = simulation->loop.snapshots().latest();
  for (std::size_t b = 0; b < static_cast<std::size_t>(rigid_count); ++b)
    put(snapshot.report.rigid[b].force, force + 3 * b);
  return PALPATE_OK;
}

int32_t palpate_contacts(palpate_simulation* simulation, int32_t* vertex, float* force, int32_t capacity,
                         int32_t* count) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}, {count, "count"}})) return code;
  if (capacity < 0) return refuse(PALPATE_BAD_ARGUMENT, "capacity is negative");
  if (capacity > 0)
    if (const int32_t code = nullAmong({{vertex, "vertex"}, {force, "force"}})) return code;
  const Snapshot& snapshot = simulation->loop.snapshots().latest();
  *count = snapshot.contact_entries;
  for (std::size_t k = 0; k < static_cast<std::size_t>(std::min(capacity, *count)); ++k) {
    const Float4& f = snapshot.contact_force[k];
    vertex[k] = snapshot.contact_vertex[k];
    *force++ = f.x;
    *force++ = f.y;
    *force++ = f.z;
  }
  return PALPATE_OK;
}

int32_t palpate_contact_points(const palpate_simulation* simulation, double* position, double* normal, double* force,
                               int32_t* tool, int32_t capacity, int32_t* count) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}, {count, "count"}})) return code;
  if (capacity < 0) return refuse(PALPATE_BAD_ARGUMENT, "capacity is negative");
  if (!simulation->standsStill()) return simulation->busy();
  *count = 0;
  forEachContactPoint(simulation->present(), simulation->physics.state(),
                      [&](int of_tool, const Vec3& at, const Vec3& outward, const Vec3& on_tissue) {
                        const int k = (*count)++;
                        if (k >= capacity) return;
                        if (position != nullptr) put(at, position + 3 * k);
                        if (normal != nullptr) put(-outward, normal + 3 * k);
                        if (force != nullptr) put(on_tissue, force + 3 * k);
                        if (tool != nullptr) tool[k] = of_tool;
                      });
  return PALPATE_OK;
}

int32_t palpate_closest(palpate_simulation* simulation, const double* x, palpate_skin_point* place) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}, {place, "place"}})) return code;
  if (const int32_t code = placeProblem(x, "x")) return code;
  if (!isSize(place->size)) return badSize(place->size);
  return guarded(nullptr, [&] {
    const SurfaceTree& tree = skinNow(*simulation);
    const Vec3 from(x[0], x[1], x[2]);
    const SurfaceTree::Closest closest = tree.closest(from);
    palpate_skin_point out{};
    out.triangle = -1;
    if (closest.triangle >= 0) {
      putPlace(tree, closest.triangle, closest.point, out);
      out.distance = tree.inside(from) ? -closest.distance : closest.distance;
    }
    return fill(place, out);
  });
}

int32_t palpate_ray(palpate_simulation* simulation, const double* origin, const double* direction,
                    palpate_skin_point* place) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}, {place, "place"}})) return code;
  if (const int32_t code = placeProblem(origin, "origin")) return code;
  if (const int32_t code = placeProblem(direction, "direction")) return code;
  if (!isSize(place->size)) return badSize(place->size);
  const Vec3 from(origin[0], origin[1], origin[2]), along(direction[0], direction[1], direction[2]);
  if (!(along.norm() > 0)) return refuse(PALPATE_BAD_ARGUMENT, "direction is 0");
  return guarded(nullptr, [&] {
    const SurfaceTree& tree = skinNow(*simulation);
    palpate_skin_point out{};
    out.triangle = -1;
    if (const auto hit = tree.firstHit(from, along.normalized())) {
      putPlace(tree, hit->triangle, hit->point, out);
      out.distance = hit->distance;
    }
    return fill(place, out);
  });
}

}  // extern "C"
