#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "base/types.h"
#include "contact/skin_contact.h"
#include "discretization/surface/surface_bodies.h"
#include "discretization/surface/surface_geometry.h"

namespace palpate {
namespace {

/// Vertices are followed from this distance on, spacings; so far things may move before all are looked at again.
constexpr double followed_from = 0.5;

/// Spacings, to which a vertex may be inside another body and is still taken for one that goes out by the nearest face:
/// what came so deep between two looks.
constexpr double deepest_entry = 1;

/// Spacings, by which a vertex is elsewhere than its anchor says, however the tissue is stretched.
constexpr double rough_error = 1;

/// m, within which what rests takes part: forces on its neighbours may push it to the other skin.
constexpr double least_way = 1e-4;

/// Faces that meet at less than this are of one smooth skin (cosine).
constexpr double smooth_cosine = 0.7;

Vec3 unit(const Vec3& a) {
  const double length = a.norm();
  return length > 0 ? Vec3(a / length) : Vec3::Zero();
}

/// m: nearer or not is no question below.
constexpr double same_distance = 1e-7;

/// Cosine of the angle between the face's normal and the way to what is before it: what is beyond an edge, beside the
/// face, does not touch it.
constexpr double before_face = 0.5;

/// Edges of the skin, by which vertices of the coarser skin may go into the finer: corners that stand between the
/// finer one's vertices are met here. Both sides at once would be more conditions than there are nodes, and forces
/// would wander between them, which friction does not survive.
constexpr double missed_depth = 0.05;

/// How a vertex stands to the face that it is before.
struct Stand {
  int face = -1;
  Vec3 barycentric = Vec3::Zero();
  double distance = std::numeric_limits<double>::infinity();  // m
};

/// One look at the skins as they are.
class Look {
 public:
  Look(const SkinModel& skin, const Float4* u, SkinContactScratch& scratch) : skin_(skin), u_(u), scratch_(scratch) {
    if (++scratch_.look == 0) {  // once in 2^32 looks
      std::fill(scratch_.known.begin(), scratch_.known.end(), 0U);
      std::fill(scratch_.directed.begin(), scratch_.directed.end(), 0U);
      std::fill(scratch_.measured.begin(), scratch_.measured.end(), 0U);
      scratch_.look = 1;
    }
  }

  const Vec3& at(int v) {
    if (scratch_.known[v] != scratch_.look) {
      scratch_.known[v] = scratch_.look;
      scratch_.position[v] = skinPosition(skin_, v, u_);
    }
    return scratch_.position[v];
  }

  /// Of the faces around a vertex as they are.
  const Vec3& normalAt(int v) {
    if (scratch_.directed[v] == scratch_.look) return scratch_.normal[v];
    scratch_.directed[v] = scratch_.look;
    Vec3 sum = Vec3::Zero();
    for (const int t : facesAround(v)) sum += areaOf(t);
    return scratch_.normal[v] = unit(sum);
  }

  /// The nearest of the faces around a face's corners, and so on until none is nearer.
  /// @param touches  then it stays on the side by which it came: no sharp edge is crossed
  Stand follow(int vertex, int face, bool touches = false) {
    constexpr int most_moves = 32;
    Stand best = standAt(at(vertex), face);
    if (best.barycentric.minCoeff() > 0) return best;  // straight before it
    for (int move = 0; move < most_moves; ++move) {
      const int from = best.face;
      for (const int v : skin_.surface.triangles[from]) nearestAround(vertex, v, touches, best);
      if (best.face == from) break;
    }
    return best;
  }

  /// From the faces around another vertex on.
  Stand followFrom(int vertex, int other) {
    Stand best;
    nearestAround(vertex, other, false, best);
    return follow(vertex, best.face);
  }

  /// Between the corners' normals, so that it turns steadily for what slides over the faces. Across a sharp edge no
  /// normal is averaged.
  Vec3 normalOf(const Stand& stand) {
    const Vec3 own = unit(areaOf(stand.face));
    Vec3 normal = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      Vec3 around = Vec3::Zero();
      for (const int t : facesAround(corners(stand.face)[static_cast<std::size_t>(k)])) {
        const Vec3& area = areaOf(t);
        const double along = area.dot(own);
        if (along > 0 && along * along > smooth_cosine * smooth_cosine * area.squaredNorm()) around += area;
      }
      normal += stand.barycentric[k] * unit(around);
    }
    return unit(normal);
  }

  Vec3 pointOf(const Stand& stand) {
    Vec3 x = Vec3::Zero();
    for (int k = 0; k < 3; ++k) x += stand.barycentric[k] * at(corners(stand.face)[static_cast<std::size_t>(k)]);
    return x;
  }

  const std::array<int, 3>& corners(int face) const { return skin_.surface.triangles[face]; }

 private:
  std::span<const int> facesAround(int v) const {
    const auto& topology = skin_.topology;
    return {topology.face_of.data() + topology.face_begin[v],
            static_cast<std::size_t>(topology.face_begin[v + 1] - topology.face_begin[v])};
  }

  /// Twice its area along its normal, m^2.
  const Vec3& areaOf(int face) {
    if (scratch_.measured[face] == scratch_.look) return scratch_.area[face];
    scratch_.measured[face] = scratch_.look;
    const auto& [a, b, c] = corners(face);
    return scratch_.area[face] = (at(b) - at(a)).cross(at(c) - at(a));
  }

  bool areSmooth(int t, int other) { return unit(areaOf(t)).dot(unit(areaOf(other))) > smooth_cosine; }

  Stand standAt(const Vec3& x, int face) {
    Stand stand;
    stand.face = face;
    const auto& [a, b, c] = corners(face);
    stand.barycentric = closestBarycentric(x, at(a), at(b), at(c));
    stand.distance = (x - pointOf(stand)).norm();
    return stand;
  }

  /// Of faces at whose common edge or corner the vertex is nearest, the one that it faces.
  void nearestAround(int vertex, int v, bool touches, Stand& best) {
    for (const int t : facesAround(v)) {
      if (t == best.face || (touches && !areSmooth(t, best.face))) continue;
      const Stand stand = standAt(at(vertex), t);
      if (stand.distance > best.distance + same_distance) continue;
      if (stand.distance >= best.distance - same_distance && best.face >= 0 &&
          unit(areaOf(t)).dot(normalAt(vertex)) >= unit(areaOf(best.face)).dot(normalAt(vertex)))
        continue;
      best = stand;
    }
  }

  const SkinModel& skin_;
  const Float4* u_;
  SkinContactScratch& scratch_;
};

/// A hashed grid over some of the skin's vertices.
class VertexGrid {
 public:
  VertexGrid(double cell, SkinContactScratch& scratch) : cell_(cell), scratch_(scratch) {
    std::fill(scratch_.head.begin(), scratch_.head.end(), -1);
  }
  void add(int v, const Vec3& x) {
    int& head = scratch_.head[bucket(cellOf(x))];
    scratch_.next[v] = head;
    head = v;
  }
  template <class Visit>
  void around(const Vec3& x, Visit&& visit) const {
    const auto middle = cellOf(x);
    std::array<std::size_t, 27> seen{};
    std::size_t count = 0;
    for (int n = 0; n < 27; ++n) {
      const std::size_t b = bucket({middle[0] + n % 3 - 1, middle[1] + n / 3 % 3 - 1, middle[2] + n / 9 - 1});
      const auto end = seen.begin() + static_cast<std::ptrdiff_t>(count);
      if (std::find(seen.begin(), end, b) != end) continue;
      seen[count++] = b;
      for (int v = scratch_.head[b]; v >= 0; v = scratch_.next[v]) visit(v);
    }
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  Cell cellOf(const Vec3& x) const {
    Cell cell{};
    for (int a = 0; a < 3; ++a) {
      const double at = std::floor(x[a] / cell_);
      cell[static_cast<std::size_t>(a)] = std::abs(at) < 1e9 ? static_cast<std::int64_t>(at) : 0;
    }
    return cell;
  }
  std::size_t bucket(const Cell& c) const {
    const auto mixed = static_cast<std::uint64_t>(c[0]) * 73856093U ^ static_cast<std::uint64_t>(c[1]) * 19349663U ^
                       static_cast<std::uint64_t>(c[2]) * 83492791U;
    return mixed % scratch_.head.size();
  }

  double cell_;
  SkinContactScratch& scratch_;
};

/// Whether a pair touched when it was last looked at, or is so near that it may by now.
bool touches(const SkinContactState& state, int k) {
  const Float4& f = state.force[k];
  return state.clearance[k] <= 0 || f.x != 0 || f.y != 0 || f.z != 0;
}

/// Looks at all vertices. @param reach  m, from which on they are listed
void search(const SkinBodies& bodies, const SkinModel& skin, const Float4* u, double reach, Look& look,
            SkinContactState& state, SkinContactScratch& scratch) {
  const int vertices = skin.vertexCount();
  // Roughly, where bodies are: what is far from all others is looked at no closer.
  const auto roughly = [&](int v) { return Vec3(skin.surface.vertices[v] + toVec3(u[bodies.anchor[v]])); };
  std::array<Box3, max_skin_bodies> box;
  for (int v = 0; v < vertices; ++v) box[static_cast<std::size_t>(bodies.body[v])].extend(roughly(v));
  // How far a body's vertices are from one that is before the middle of its largest face.
  const double apart = reach + bodies.longest_edge;
  VertexGrid grid(apart, scratch);
  const auto isBetween = [&](int v) {
    const Vec3 x = roughly(v);
    const double near = apart + 2 * rough_error * bodies.spacing;
    for (int b = 0; b < bodies.count; ++b)
      if (b != bodies.body[v] && box[static_cast<std::size_t>(b)].squaredExteriorDistance(x) <= near * near)
        return true;
    return false;
  };
  for (int v = vertices - 1; v >= 0; --v)
    if (isBetween(v)) grid.add(v, look.at(v));

  for (int k = 0; k < state.count; ++k) scratch.old_touches[k] = touches(state, k) ? 1 : 0;
  std::swap(state.vertex, scratch.old_vertex);
  std::swap(state.face, scratch.old_face);
  std::swap(state.force, scratch.old_force);
  const int old_count = state.count;
  int old = 0;
  state.count = 0;
  for (int v = 0; v < vertices; ++v) {
    while (old < old_count && scratch.old_vertex[old] < v) ++old;
    const bool followed = old < old_count && scratch.old_vertex[old] == v;
    const bool touched = followed && scratch.old_touches[old] != 0;
    Stand stand;
    if (followed) {
      stand = look.follow(v, scratch.old_face[old], touched);
    } else if (isBetween(v)) {
      const Vec3& x = look.at(v);
      int nearest = -1;
      double least = apart * apart;
      grid.around(x, [&](int w) {
        if (bodies.body[w] == bodies.body[v]) return;
        const double d2 = (look.at(w) - x).squaredNorm();
        if (d2 < least || (d2 == least && w < nearest)) least = d2, nearest = w;
      });
      if (nearest < 0) continue;
      stand = look.followFrom(v, nearest);
    } else {
      continue;
    }
    if (!(stand.distance <= reach) && !touched) continue;
    if (!followed) {  // from which side it came
      const double side = look.normalOf(stand).dot(look.at(v) - look.pointOf(stand));
      if (side < 0 &&
          (stand.distance > deepest_entry * bodies.spacing || look.normalOf(stand).dot(look.normalAt(v)) > 0))
        continue;
    }
    const int k = state.count++;
    state.vertex[k] = v;
    state.face[k] = stand.face;
    state.force[k] = followed ? scratch.old_force[old] : Float4{};
    state.clearance[k] = touched ? 0.0F : static_cast<float>(stand.distance);
  }
}

/// What the vertex has more of each node than the face's point. @return false where there is no room
bool addEntries(const SkinModel& skin, int vertex, const std::array<int, 3>& corner, const Vec3& share,
                SkinContactScratch::Row& row, SkinContactScratch& scratch) {
  const int of[] = {vertex, corner[0], corner[1], corner[2]};
  const double weight[] = {1, -share[0], -share[1], -share[2]};
  int at[4], length = 0;
  for (int k = 0; k < 4; ++k) {
    at[k] = weight[k] != 0 ? skin.begin[of[k]] : skin.begin[of[k] + 1];
    length += skin.begin[of[k] + 1] - at[k];
  }
  if (static_cast<std::size_t>(row.begin + length) > scratch.node.size()) return false;
  row.end = row.begin;
  while (true) {  // rows are ascending
    int next = std::numeric_limits<int>::max();
    for (int k = 0; k < 4; ++k)
      if (at[k] < skin.begin[of[k] + 1]) next = std::min(next, skin.node[at[k]]);
    if (next == std::numeric_limits<int>::max()) return true;
    float sum = 0;
    for (int k = 0; k < 4; ++k)
      if (at[k] < skin.begin[of[k] + 1] && skin.node[at[k]] == next)
        sum += static_cast<float>(weight[k]) * skin.N[at[k]++];
    scratch.node[row.end] = next;
    scratch.N[row.end++] = sum;
  }
}

/// The pairs that may touch in this tick, as rows.
void makeRows(const SkinBodies& bodies, const SkinModel& skin, double way, Look& look, SkinContactState& state,
              SkinContactScratch& scratch) {
  scratch.row_count = 0;
  scratch.overflow = false;
  int end = 0;
  for (int k = 0; k < state.count; ++k) {
    if (static_cast<double>(state.clearance[k]) > way) continue;
    const int v = state.vertex[k];
    const Stand stand = look.follow(v, state.face[k], touches(state, k));
    state.face[k] = stand.face;
    const Vec3 normal = look.normalOf(stand);
    const double gap = normal.dot(look.at(v) - look.pointOf(stand));
    const bool is_beside = stand.distance > way && std::abs(gap) < before_face * stand.distance;
    state.clearance[k] = gap > 0 || is_beside ? static_cast<float>(stand.distance) : 0.0F;
    const bool may_touch = static_cast<double>(state.clearance[k]) <= way && std::isfinite(gap);
    scratch.overflow |= may_touch && static_cast<std::size_t>(scratch.row_count) == scratch.row.size();
    if (!may_touch || scratch.overflow) {
      state.force[k] = {};
      continue;
    }
    SkinContactScratch::Row& row = scratch.row[static_cast<std::size_t>(scratch.row_count)];
    row.slot = k;
    row.begin = end;
    row.normal << normal.cast<float>(), 0;
    const int own = bodies.body[v], other = bodies.body[look.corners(stand.face)[0]];
    row.friction = std::max(bodies.friction[own], bodies.friction[other]);
    row.lift = bodies.rank[own] < bodies.rank[other] ? 0 : static_cast<float>(missed_depth * bodies.longest_edge);
    const auto& corner = look.corners(stand.face);
    Vec3 apart = skin.surface.vertices[v];
    for (int c = 0; c < 3; ++c)
      apart -= stand.barycentric[c] * skin.surface.vertices[corner[static_cast<std::size_t>(c)]];
    row.apart << apart.cast<float>(), 0;
    if (!addEntries(skin, v, corner, stand.barycentric, row, scratch)) {
      scratch.overflow = true;
      state.force[k] = {};
      continue;
    }
    end = row.end;
    ++scratch.row_count;
  }
}

/// Ranks of the bodies by the mean area of their vertices, the smallest first.
std::vector<int> byDensity(const SkinBodies& bodies, const SkinModel& skin) {
  const auto count = static_cast<std::size_t>(bodies.count);
  std::vector<double> area(count), vertices(count);
  for (int v = 0; v < skin.vertexCount(); ++v) {
    area[static_cast<std::size_t>(bodies.body[v])] += skin.area[v];
    vertices[static_cast<std::size_t>(bodies.body[v])] += 1;
  }
  std::vector<int> order(count), rank(count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return area[a] * vertices[b] < 0.999 * area[b] * vertices[a]; });
  for (std::size_t k = 0; k < count; ++k) rank[static_cast<std::size_t>(order[k])] = static_cast<int>(k);
  return rank;
}

}  // namespace

SkinBodies makeSkinBodies(const SkinModel& skin, double spacing) {
  SkinBodies bodies;
  const SurfaceBodies of = bodiesOf(skin.surface);
  bodies.count = of.count;
  if (of.count < 2) return bodies;
  bodies.body = of.ofVertices(skin.surface);
  for (int& b : bodies.body) b = std::max(b, 0);
  bodies.rank = byDensity(bodies, skin);
  for (int v = 0; v < skin.vertexCount(); ++v)
    bodies.anchor.push_back(
        skin.node[std::max_element(skin.N.begin() + skin.begin[v], skin.N.begin() + skin.begin[v + 1]) -
                  skin.N.begin()]);
  bodies.organ.assign(static_cast<std::size_t>(of.count), 0);
  bodies.friction.assign(static_cast<std::size_t>(of.count), 0.0F);
  bodies.spacing = spacing;
  for (const float length : skin.topology.edge_length)
    bodies.longest_edge = std::max(bodies.longest_edge, static_cast<double>(length));
  for (int v = 0; v < skin.vertexCount(); ++v) {
    double sum = 0;
    for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e) sum += std::abs(static_cast<double>(skin.N[e]));
    bodies.row_sum = std::max(bodies.row_sum, sum);
  }
  return bodies;
}

SkinContactState makeSkinContactState(const SkinBodies& bodies, const SkinModel& skin) {
  SkinContactState state;
  const std::size_t capacity = bodies.empty() ? 0 : skin.area.size();
  state.vertex.resize(capacity);
  state.face.resize(capacity);
  state.clearance.resize(capacity);
  state.force.resize(capacity);
  return state;
}

namespace {

/// Pairs at most: as many as a tool may have.
constexpr std::size_t most_pairs = 4096;

std::size_t longestRow(const SkinModel& skin) {
  int longest = 0;
  for (int v = 0; v < skin.vertexCount(); ++v) longest = std::max(longest, skin.begin[v + 1] - skin.begin[v]);
  return static_cast<std::size_t>(longest);
}

}  // namespace

SkinContactScratch::SkinContactScratch(const SkinBodies& bodies, const SkinModel& skin) {
  const std::size_t capacity = bodies.empty() ? 0 : skin.area.size();
  for (auto* list : {&old_vertex, &old_face, &head, &next}) list->resize(capacity);
  for (auto* looks : {&known, &directed}) looks->resize(capacity);
  for (auto* vectors : {&position, &normal}) vectors->resize(capacity, Vec3::Zero());
  const std::size_t faces = bodies.empty() ? 0 : skin.surface.triangles.size();
  measured.resize(faces);
  area.resize(faces, Vec3::Zero());
  old_force.resize(capacity);
  old_touches.resize(capacity);
  const std::size_t rows = std::min(capacity, most_pairs), longest = 4 * longestRow(skin);
  row.resize(rows);
  active.resize(rows);
  node.resize(rows * longest);
  N.resize(rows * longest);
}

void findSkinPairs(const SkinBodies& bodies, const SkinModel& skin, const Float4* u, SkinContactState& state,
                   SkinContactScratch& scratch) {
  if (bodies.empty()) return;
  // Two skins come nearer by twice what the fastest vertex does; the next tick may be half as fast again.
  const double come = 2 * state.travel, way = 1.5 * come + least_way;
  state.travel = 0;
  state.since_search += come;
  for (int k = 0; k < state.count; ++k) state.clearance[k] -= static_cast<float>(come);
  Look look(skin, u, scratch);
  const double followed = followed_from * bodies.spacing;
  if (!state.searched || state.since_search + way > followed) {
    search(bodies, skin, u, followed + way, look, state, scratch);
    state.searched = true;
    state.since_search = 0;
  }
  makeRows(bodies, skin, way, look, state, scratch);
}

}  // namespace palpate
