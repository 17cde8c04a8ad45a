#include "setup/join_bodies.h"

#include <algorithm>
#include <bit>
#include <iterator>
#include <numeric>
#include <type_traits>

#include "scene/scene_messages.h"
#include "setup/imposed_nodes.h"

namespace palpate {
namespace {

template <class T, class Allocator>
void append(std::vector<T, Allocator>&& more, std::vector<T, Allocator>& all) {
  all.reserve(all.size() + more.size());  // no more than is needed: a place of a following cloud keeps it
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

/// Index arrays (rows of indices, too), by `at` in what they are joined to.
template <class T, class At>
void append(std::vector<T>&& more, At at, std::vector<T>& all) {
  for (T& entry : more) {
    if constexpr (std::is_same_v<T, int>)
      entry = at(entry);
    else
      for (int& index : entry) index = at(index);
  }
  append(std::move(more), all);
}

/// Of a ShapeTable or SkinModel. @param nodes  before those of `more`
template <class Rows>
void appendRows(Rows& more, int nodes, Rows& all) {
  const int entries = static_cast<int>(all.node.size());
  if (all.begin.empty() && !more.begin.empty()) all.begin.push_back(0);
  if (!more.begin.empty()) more.begin.erase(more.begin.begin());
  append(
      std::move(more.begin), [&](int e) { return entries + e; }, all.begin);
  append(
      std::move(more.node), [&](int i) { return nodes + i; }, all.node);
  append(std::move(more.N), all.N);
}

void append(ShapeTable&& more, int nodes, ShapeTable& all) {
  appendRows(more, nodes, all);
  append(std::move(more.gradN), all.gradN);
}

/// Where no material meets another the vertices at which the volume is held are the nodes, all of one group.
void giveVertices(Preparation& p) {
  if (!p.volume_cells.empty()) return;
  p.volume_cells = p.cells;
  p.vertex_group.assign(p.X.size(), 1);
}

/// Vertices at which the volume is held: nodes first, then what borders have more. Each body has groups of its own, so
/// that no support goes from one to another.
void joinVertices(std::vector<Preparation>& bodies, Preparation& all) {
  std::vector<std::uint64_t> side_group;
  int nodes = 0, groups = 0;
  const int node_count = std::accumulate(bodies.begin(), bodies.end(), 0,
                                         [](int sum, const Preparation& p) { return sum + p.nodeCount(); });
  for (Preparation& p : bodies) {
    giveVertices(p);
    const int own = p.nodeCount(), sides = static_cast<int>(all.side_node.size());
    std::uint64_t used = 0;
    for (std::uint64_t& group : p.vertex_group) {
      used |= group;
      group = std::rotl(group, groups % 64);
    }
    groups += std::bit_width(used);
    append(
        std::move(p.volume_cells), [&](int v) { return v < own ? nodes + v : node_count + sides + v - own; },
        all.volume_cells);
    append(
        std::move(p.side_node), [&](int i) { return nodes + i; }, all.side_node);
    all.vertex_group.insert(all.vertex_group.end(), p.vertex_group.begin(), p.vertex_group.begin() + own);
    side_group.insert(side_group.end(), p.vertex_group.begin() + own, p.vertex_group.end());
    nodes += own;
  }
  append(std::move(side_group), all.vertex_group);
}

/// @param nodes  before those of `more`
void append(EssentialNodes&& more, int nodes, EssentialNodes& all) {
  for (ImposedNode& row : more.nodes)
    if (row.node >= 0) row.node += nodes;
  append(std::move(more.nodes), all.nodes);
  append(std::move(more.X), all.X);
  all.motions = std::move(more.motions);
  append(
      std::move(more.facets), [&](int i) { return nodes + i; }, all.facets);
  all.facet_points = std::max(all.facet_points, more.facet_points);
  append(std::move(more.facet_phi), nodes, all.facet_phi);
  append(std::move(more.facet_weight), all.facet_weight);
}

void append(Preparation&& more, Preparation& all) {
  const int nodes = all.nodeCount(), cells = static_cast<int>(all.cells.size()), points = all.pointCount(),
            vertices = static_cast<int>(all.skin.surface.vertices.size());
  if (nodes == 0 || more.limit.dt_proven < all.limit.dt_proven) {
    all.limit.dt_proven = more.limit.dt_proven;
    all.limit.worst_node = nodes + more.limit.worst_node;
  }
  all.limit.dt = nodes == 0 ? more.limit.dt : std::min(all.limit.dt, more.limit.dt);
  all.limit.iterations = std::max(all.limit.iterations, more.limit.iterations);
  const auto node = [&](int i) { return nodes + i; };
  const auto cell = [&](int c) { return c < 0 ? c : cells + c; };

  append(std::move(more.X), all.X);
  append(std::move(more.support_radius), all.support_radius);
  append(std::move(more.mass), all.mass);
  append(std::move(more.own_mass), all.own_mass);
  append(std::move(more.cells), node, all.cells);
  if (!more.point_other_cell.empty() || !all.point_other_cell.empty()) {
    all.point_other_cell.resize(static_cast<std::size_t>(points), -1);
    more.point_other_cell.resize(more.point_X.size(), -1);
    append(std::move(more.point_other_cell), cell, all.point_other_cell);
  }
  append(std::move(more.point_X), all.point_X);
  append(std::move(more.point_volume), all.point_volume);
  append(std::move(more.point_material), all.point_material);
  append(std::move(more.point_cell), cell, all.point_cell);
  if (more.layer_error > all.layer_error) {
    all.layer_error = more.layer_error;
    all.thin_layer = more.thin_layer;
  }
  for (MissedShare& missed : more.missed_shares) missed.body += all.bodyCount();
  append(std::move(more.missed_shares), all.missed_shares);
  all.surface_volume += more.surface_volume;
  all.cell_volume += more.cell_volume;
  append(std::move(more.point_shape), nodes, all.point_shape);
  append(std::move(more.node_shape), nodes, all.node_shape);
  appendRows(more.skin, nodes, all.skin);
  append(std::move(more.skin.surface.vertices), all.skin.surface.vertices);
  append(
      std::move(more.skin.surface.triangles), [&](int v) { return vertices + v; }, all.skin.surface.triangles);
  append(std::move(more.essential), nodes, all.essential);
  all.end_node.push_back(all.nodeCount());
  all.end_point.push_back(all.pointCount());
}

}  // namespace

Scene sceneOf(const Scene& scene, const TriangleSurface& surface) {
  const int organ = surface.organ.empty() ? 0 : surface.organ.front();
  Region nothing;
  nothing.kind = Region::Kind::Sphere;
  nothing.radius = -1;
  const auto isOther = [&](int named) { return named >= 0 && named != organ; };
  Scene own = scene;
  for (BoundarySpec& boundary : own.boundaries)
    if (isOther(boundary.organ)) boundary.region = nothing;
  for (MaterialSpec& material : own.materials)
    if (isOther(material.organ)) {
      material.everywhere = false;
      material.region = nothing;
    }
  return own;
}

void checkBoundaries(const Scene& scene, std::size_t body_count,
                     const std::function<bool(std::size_t body, std::size_t boundary)>& has) {
  for (std::size_t b = 0; b < scene.boundaries.size(); ++b) {
    const BoundarySpec& spec = scene.boundaries[b];
    const bool is_point = spec.region.kind == Region::Kind::Point;
    bool found = false;
    for (std::size_t k = 0; k < body_count && !found; ++k) found = has(k, b);
    if (!found) refuseEmpty(scene, spec);
    if (body_count > 1 && is_point)
      throw InputError(spec.place, "points that are measured move one body, and here are " + number(body_count),
                       "leave the other organs out");
  }
}

// NOLINTNEXTLINE(performance-unnecessary-value-param): its parts are moved from
Preparation joinBodies(std::vector<Preparation> bodies) {
  Preparation all;
  joinVertices(bodies, all);
  for (Preparation& body : bodies) append(std::move(body), all);
  return all;
}

}  // namespace palpate
