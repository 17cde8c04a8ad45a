#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
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

/// Spacings at rest, from which on two places of one body may touch. Those that look at each other across a gap, from
/// `across_gap` on: nearer ones are moved by the same nodes. Others only where skin folds, from `along_skin` on: nearer
/// ones bend with each other, and what crumples between nodes is no contact (at 1.5 a gel that is 4.4 spacings wide,
/// pressed roughly, locked itself into folds that it had not without).
constexpr double across_gap = 0.5, along_skin = 4;

/// Spacings, by which two places of one body may be in each other. What comes deeper has been passed by something that
/// contact can't hold, and finds its way back better alone: held, it locks (0.5 left a gel's skin crossing itself in 29
/// of 77 looks after a rough hand, 0.1 in as many as no contact at all, 2).
constexpr double deepest_hold = 0.1;

/// Of the skin, which the bounds of clusters allow for, as the tools' (broad_phase.cpp).
constexpr double most_stretch = 2;

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

/// Two vertices may touch: they are of two bodies, or were far enough from each other at rest.
bool mayTouch(const SkinBodies& bodies, const SkinModel& skin, int v, int w) {
  if (bodies.body[v] != bodies.body[w]) return true;
  const auto &X = skin.surface.vertices, &N = bodies.normal;
  const Vec3 way = X[w] - X[v];
  const double distance2 = way.squaredNorm() / (bodies.spacing * bodies.spacing);
  return distance2 > along_skin * along_skin ||
         (distance2 > across_gap * across_gap && way.dot(N[v]) > 0 && way.dot(N[w]) < 0 && N[v].dot(N[w]) < 0);
}

/// Two clusters have vertices of one and the same body.
bool areOfOne(const SkinBodies& bodies, int a, int b) {
  return bodies.cluster_body[a] >= 0 && bodies.cluster_body[a] == bodies.cluster_body[b];
}

/// m, at rest, between the vertices of two clusters: at least, and at most.
std::array<double, 2> distanceBetween(const SkinModel& skin, int a, int b) {
  const auto& X = skin.surface.vertices;
  const double centres = (X[skin.cluster_representative[a]] - X[skin.cluster_representative[b]]).norm();
  const auto radii = static_cast<double>(skin.cluster_radius[a] + skin.cluster_radius[b]);
  return {centres - radii, centres + radii};
}

/// How a vertex stands to the face that it is before.
struct Stand {
  int face = -1;
  Vec3 barycentric = Vec3::Zero();
  double distance = std::numeric_limits<double>::infinity();  // m
};

/// One look at the skins as they are.
class Look {
 public:
  Look(const SkinBodies& bodies, const SkinModel& skin, const Float4* u, SkinContactScratch& scratch)
      : bodies_(bodies), skin_(skin), u_(u), scratch_(scratch) {
    if (++scratch_.look == 0) {  // once in 2^32 looks
      std::fill(scratch_.known.begin(), scratch_.known.end(), 0U);
      std::fill(scratch_.directed.begin(), scratch_.directed.end(), 0U);
      std::fill(scratch_.measured.begin(), scratch_.measured.end(), 0U);
      for (SkinContactScratch::Cluster& cluster : scratch_.cluster) cluster.look = 0;
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
    return best.face < 0 ? best : follow(vertex, best.face);
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

  /// Twice its area along its normal, m^2.
  const Vec3& areaOf(int face) {
    if (scratch_.measured[face] == scratch_.look) return scratch_.area[face];
    scratch_.measured[face] = scratch_.look;
    const auto& [a, b, c] = corners(face);
    return scratch_.area[face] = (at(b) - at(a)).cross(at(c) - at(a));
  }

 private:
  std::span<const int> facesAround(int v) const {
    const auto& topology = skin_.topology;
    return {topology.face_of.data() + topology.face_begin[v],
            static_cast<std::size_t>(topology.face_begin[v + 1] - topology.face_begin[v])};
  }

  bool isApart(int v, int t) const {
    const auto& [a, b, c] = corners(t);
    return mayTouch(bodies_, skin_, v, a) && mayTouch(bodies_, skin_, v, b) && mayTouch(bodies_, skin_, v, c);
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
      if (t == best.face || (touches && !areSmooth(t, best.face)) || !isApart(vertex, t)) continue;
      const Stand stand = standAt(at(vertex), t);
      if (stand.distance > best.distance + same_distance) continue;
      if (stand.distance >= best.distance - same_distance && best.face >= 0 &&
          unit(areaOf(t)).dot(normalAt(vertex)) >= unit(areaOf(best.face)).dot(normalAt(vertex)))
        continue;
      best = stand;
    }
  }

  const SkinBodies& bodies_;
  const SkinModel& skin_;
  const Float4* u_;
  SkinContactScratch& scratch_;
};

/// SkinContactState::clearance of what is inside the other's skin.
constexpr float inside = -std::numeric_limits<float>::infinity();

/// Whether a pair touched when it was last looked at.
bool touched(const SkinContactState& state, int k) {
  const Float4& f = state.force[k];
  return state.clearance[k] == inside || f.x != 0 || f.y != 0 || f.z != 0;
}

/// Or is so near that it may by now.
bool touches(const SkinContactState& state, int k) { return state.clearance[k] <= 0 || touched(state, k); }

/// Where a cluster of the skin is, and which ways its faces look.
const SkinContactScratch::Cluster& measured(const SkinBodies& bodies, const SkinModel& skin, int c, Look& look,
                                            SkinContactScratch& scratch) {
  SkinContactScratch::Cluster& cluster = scratch.cluster[static_cast<std::size_t>(c)];
  if (cluster.look == scratch.look) return cluster;
  cluster.look = scratch.look;
  cluster.centre = look.at(skin.cluster_representative[c]);
  double far2 = 0;
  for (int k = skin.cluster_begin[c]; k < skin.cluster_begin[c + 1]; ++k)
    far2 = std::max(far2, (look.at(skin.cluster_vertex[k]) - cluster.centre).squaredNorm());
  cluster.radius = std::sqrt(far2);
  Vec3 sum = Vec3::Zero();
  const std::span<const int> faces(bodies.cluster_face.data() + bodies.cluster_face_begin[c],
                                   bodies.cluster_face.data() + bodies.cluster_face_begin[c + 1]);
  for (const int t : faces) sum += look.areaOf(t);
  cluster.axis = unit(sum);
  double least = 1;
  for (const int t : faces) least = std::min(least, unit(look.areaOf(t)).dot(cluster.axis));
  cluster.spread = std::acos(std::clamp(least, -1.0, 1.0));
  return cluster;
}

/// The nearest that each vertex of one cluster may touch in another.
void findNearest(const SkinBodies& bodies, const SkinModel& skin, int a, int b, Look& look,
                 SkinContactScratch& scratch) {
  const SkinContactScratch::Cluster& other = scratch.cluster[static_cast<std::size_t>(b)];
  const double turned = other.spread < std::numbers::pi / 2 ? std::sin(other.spread) : 1;
  for (int k = skin.cluster_begin[a]; k < skin.cluster_begin[a + 1]; ++k) {
    const int v = skin.cluster_vertex[k];
    const Vec3 &x = look.at(v), &n = look.normalAt(v);
    const double way = (x - other.centre).norm() - other.radius;
    if (way > 0 && way * way > scratch.nearest_distance2[v]) continue;
    if (n.dot(other.axis) > turned) continue;  // it looks at none of them
    for (int l = skin.cluster_begin[b]; l < skin.cluster_begin[b + 1]; ++l) {
      const int w = skin.cluster_vertex[l];
      const Vec3 to = look.at(w) - x;
      const double d2 = to.squaredNorm();
      if (d2 > scratch.nearest_distance2[v] || (d2 == scratch.nearest_distance2[v] && w > scratch.nearest[v])) continue;
      // They look at each other; within one body with no tissue between them.
      const Vec3& m = look.normalAt(w);
      if (n.dot(m) >= 0) continue;
      if (bodies.body[v] == bodies.body[w] && (to.dot(n) <= 0 || to.dot(m) >= 0)) continue;
      if (!mayTouch(bodies, skin, v, w)) continue;
      scratch.nearest_distance2[v] = d2;
      scratch.nearest[v] = w;
    }
  }
}

/// The nearest vertex that each may touch, no further than `apart` (m); -1: none.
/// @param moved  m: no two places are further from where they were to each other
void findNearest(const SkinBodies& bodies, const SkinModel& skin, double apart, double moved, Look& look,
                 SkinContactScratch& scratch) {
  std::fill(scratch.nearest.begin(), scratch.nearest.end(), -1);
  std::fill(scratch.nearest_distance2.begin(), scratch.nearest_distance2.end(), apart * apart);
  const auto reachOf = [&](int c) { return most_stretch * static_cast<double>(skin.cluster_radius[c]); };
  const auto areNear = [&](const Vec3& x, const Vec3& y, double reach) {
    return (x - y).squaredNorm() <= (apart + reach) * (apart + reach);
  };
  const auto compare = [&](int a, int b) {
    if (!areNear(look.at(skin.cluster_representative[a]), look.at(skin.cluster_representative[b]),
                 reachOf(a) + reachOf(b)))
      return;
    const SkinContactScratch::Cluster &one = measured(bodies, skin, a, look, scratch),
                                      &other = measured(bodies, skin, b, look, scratch);
    if (!areNear(one.centre, other.centre, one.radius + other.radius)) return;
    // No two of their faces look at each other.
    const double turned = one.spread + other.spread;
    if (turned < std::numbers::pi / 2 && one.axis.dot(other.axis) > std::sin(turned)) return;
    findNearest(bodies, skin, a, b, look, scratch);
    if (a != b) findNearest(bodies, skin, b, a, look, scratch);
  };
  for (const auto& [a, b] : bodies.across_gaps)
    if (distanceBetween(skin, a, b)[0] < moved + apart) compare(a, b);
  const bool calm = moved + apart < along_skin * bodies.spacing;
  if (calm && !bodies.several()) return;
  const auto centreOf = [&](int r) { return look.at(skin.region_representative[r]); };
  const auto bodyOf = [&](int r) {  // -1: of several
    const int of = bodies.cluster_body[skin.region_begin[r]];
    const auto first = bodies.cluster_body.begin();
    return std::all_of(first + skin.region_begin[r], first + skin.region_begin[r + 1], [&](int b) { return b == of; })
               ? of
               : -1;
  };
  const auto radiusOf = [&](int r) {
    double far = 0;
    for (int c = skin.region_begin[r]; c < skin.region_begin[r + 1]; ++c)
      far = std::max(far, (look.at(skin.cluster_representative[c]) - centreOf(r)).norm() + reachOf(c));
    return far;
  };
  // Places that are far from each other at rest can be near only if their clusters have moved differently: those of one
  // move as its middle does, to within its radius.
  const auto mayHaveFolded = [&](int a, int b) {
    const int v = skin.cluster_representative[a], w = skin.cluster_representative[b];
    const auto& X = skin.surface.vertices;
    const auto radii = static_cast<double>(skin.cluster_radius[a] + skin.cluster_radius[b]);
    const double least = along_skin * bodies.spacing - apart - radii;
    return (least <= 0 || (look.at(v) - X[v] - look.at(w) + X[w]).squaredNorm() >= least * least) &&
           distanceBetween(skin, a, b)[1] > along_skin * bodies.spacing;
  };
  std::array<double, 1024> radius;  // of so many regions; the others are taken for near
  const auto known = std::min<int>(skin.regionCount(), static_cast<int>(radius.size()));
  for (int r = 0; r < known; ++r) radius[static_cast<std::size_t>(r)] = radiusOf(r);
  for (int r = 0; r < skin.regionCount(); ++r)
    for (int s = r; s < skin.regionCount(); ++s) {
      if (calm && bodyOf(r) >= 0 && bodyOf(r) == bodyOf(s)) continue;
      if (s < known && !areNear(centreOf(r), centreOf(s),
                                radius[static_cast<std::size_t>(r)] + radius[static_cast<std::size_t>(s)]))
        continue;
      for (int a = skin.region_begin[r]; a < skin.region_begin[r + 1]; ++a)
        for (int b = std::max(a, skin.region_begin[s]); b < skin.region_begin[s + 1]; ++b)
          if (!areOfOne(bodies, a, b) || (!calm && mayHaveFolded(a, b))) compare(a, b);
    }
}

/// Looks at all vertices. @param reach  m, from which on they are listed
void search(const SkinBodies& bodies, const SkinModel& skin, double reach, double moved, Look& look,
            SkinContactState& state, SkinContactScratch& scratch) {
  // How far a body's vertices are from one that is before the middle of its largest face.
  findNearest(bodies, skin, reach + bodies.longest_edge, moved, look, scratch);
  for (int k = 0; k < state.count; ++k)
    scratch.old_touches[k] = state.clearance[k] == inside ? 2 : touches(state, k) ? 1 : 0;
  std::swap(state.vertex, scratch.old_vertex);
  std::swap(state.face, scratch.old_face);
  std::swap(state.force, scratch.old_force);
  const int old_count = state.count, vertices = skin.vertexCount();
  int old = 0;
  state.count = 0;
  for (int v = 0; v < vertices; ++v) {
    while (old < old_count && scratch.old_vertex[old] < v) ++old;
    const bool touched = old < old_count && scratch.old_vertex[old] == v && scratch.old_touches[old] != 0;
    if (!touched && scratch.nearest[v] < 0) continue;
    const Stand stand =
        touched ? look.follow(v, scratch.old_face[old], touched) : look.followFrom(v, scratch.nearest[v]);
    if (!touched) {
      if (stand.face < 0 || !(stand.distance <= reach)) continue;
      const double side = look.normalOf(stand).dot(look.at(v) - look.pointOf(stand));
      if (side < 0 &&
          (bodies.body[v] == bodies.body[look.corners(stand.face)[0]] ||
           stand.distance > deepest_entry * bodies.spacing || look.normalOf(stand).dot(look.normalAt(v)) > 0))
        continue;
    }
    const int k = state.count++;
    state.vertex[k] = v;
    state.face[k] = stand.face;
    state.force[k] = touched ? scratch.old_force[old] : Float4{};
    state.clearance[k] = !touched ? static_cast<float>(stand.distance) : scratch.old_touches[old] == 2 ? inside : 0.0F;
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

/// Of two places of one body that touch, the vertices of one carry the pressure, a little before the other's faces: of
/// that which comes first in a direction that no grid has.
bool carries(int v, int other, const SkinModel& skin) {
  return (skin.surface.vertices[v] - skin.surface.vertices[other]).dot(Vec3(0.46, 0.71, 0.53)) < 0;
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
    const bool was_inside = state.clearance[k] == inside;
    const Stand stand = look.follow(v, state.face[k], touches(state, k));
    state.face[k] = stand.face;
    const Vec3 normal = look.normalOf(stand);
    const double gap = normal.dot(look.at(v) - look.pointOf(stand));
    // Beyond an edge, or behind a face through which it did not come.
    const bool same = bodies.body[v] == bodies.body[look.corners(stand.face)[0]];
    const bool is_before = std::abs(gap) >= before_face * stand.distance;
    const bool has_touched = touched(state, k);
    const bool is_beside = same ? (stand.distance > least_way && !is_before) ||
                                      gap < -(has_touched ? deepest_hold * bodies.spacing : least_way) ||
                                      (!has_touched && normal.dot(look.normalAt(v)) >= 0)
                                : stand.distance > way && (!is_before || (!was_inside && gap < 0));
    const bool is_inside = gap <= 0 && !is_beside;
    state.clearance[k] = is_inside ? inside : static_cast<float>(stand.distance);
    const bool may_touch = !is_beside && static_cast<double>(state.clearance[k]) <= way && std::isfinite(gap);
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
    const auto& corner = look.corners(stand.face);
    const double missed = missed_depth * bodies.longest_edge;
    row.lift = static_cast<float>(same                                    ? (carries(v, corner[0], skin) ? -missed : 0)
                                  : bodies.rank[own] < bodies.rank[other] ? 0
                                                                          : missed);
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

/// The faces around each cluster's vertices.
void addClusterFaces(const SkinModel& skin, SkinBodies& bodies) {
  const SkinTopology& topology = skin.topology;
  bodies.cluster_face_begin.assign(1, 0);
  for (int c = 0; c < skin.clusterCount(); ++c) {
    int of = bodies.body[skin.cluster_representative[c]];
    for (int k = skin.cluster_begin[c]; k < skin.cluster_begin[c + 1]; ++k)
      if (bodies.body[skin.cluster_vertex[k]] != of) of = -1;
    bodies.cluster_body.push_back(of);
    const auto first = static_cast<std::ptrdiff_t>(bodies.cluster_face.size());
    for (int k = skin.cluster_begin[c]; k < skin.cluster_begin[c + 1]; ++k) {
      const int v = skin.cluster_vertex[k];
      bodies.cluster_face.insert(bodies.cluster_face.end(), topology.face_of.begin() + topology.face_begin[v],
                                 topology.face_of.begin() + topology.face_begin[v + 1]);
    }
    std::sort(bodies.cluster_face.begin() + first, bodies.cluster_face.end());
    bodies.cluster_face.erase(std::unique(bodies.cluster_face.begin() + first, bodies.cluster_face.end()),
                              bodies.cluster_face.end());
    bodies.cluster_face_begin.push_back(static_cast<int>(bodies.cluster_face.size()));
  }
}

/// The normals of a cluster's vertices: one, and the sine of the largest angle that another has to it (1: any).
struct Aspect {
  Vec3 axis = Vec3::Zero();
  double turned = 1;
};

Aspect aspectOf(const SkinModel& skin, const std::vector<Vec3>& normal, int c) {
  const std::span<const int> vertices(skin.cluster_vertex.data() + skin.cluster_begin[c],
                                      skin.cluster_vertex.data() + skin.cluster_begin[c + 1]);
  Vec3 sum = Vec3::Zero();
  for (const int v : vertices) sum += normal[v];
  const Vec3 axis = unit(sum);
  double least = 1;
  for (const int v : vertices) least = std::min(least, axis.dot(normal[v]));
  return {axis, least > 0 ? std::sqrt(1 - least * least) : 1};
}

/// Which clusters look at each other across a gap, and how near they are.
void addGaps(const SkinModel& skin, SkinBodies& bodies) {
  const auto &X = skin.surface.vertices, &N = bodies.normal;
  const double along = along_skin * bodies.spacing;
  constexpr double rounding = 1e-9;
  bodies.least_gap = bodies.several() ? 0 : along;
  std::vector<Aspect> aspect;
  for (int c = 0; c < skin.clusterCount(); ++c) aspect.push_back(aspectOf(skin, N, c));
  for (int a = 0; a < skin.clusterCount(); ++a)
    for (int b = a; b < skin.clusterCount(); ++b) {
      if (!areOfOne(bodies, a, b) || distanceBetween(skin, a, b)[0] > along) continue;
      const Vec3& centre = X[skin.cluster_representative[b]];
      const double radius = static_cast<double>(skin.cluster_radius[b]) * (1 + 1e-6);
      bool are_across = false;
      for (int k = skin.cluster_begin[a]; k < skin.cluster_begin[a + 1]; ++k) {
        const int v = skin.cluster_vertex[k];
        // All of the others look the same way, or are behind it.
        if (N[v].dot(aspect[b].axis) > aspect[b].turned + rounding || N[v].dot(centre - X[v]) < -radius) continue;
        for (int l = skin.cluster_begin[b]; l < skin.cluster_begin[b + 1]; ++l) {
          const int w = skin.cluster_vertex[l];
          if ((X[v] - X[w]).squaredNorm() > along * along || !mayTouch(bodies, skin, v, w)) continue;
          are_across = true;
          bodies.least_gap = std::min(bodies.least_gap, (X[v] - X[w]).norm());
        }
      }
      if (are_across) bodies.across_gaps.push_back({a, b});
    }
}

/// m: no two places are further from where they were to each other.
double relativeMotion(const SkinBodies& bodies, const Float4* u) {
  Group low = load(u[0]), high = low;
  for (int i = 1; i < bodies.node_count; ++i) {
    const Group at = load(u[i]);
    low = at < low ? at : low;
    high = at > high ? at : high;
  }
  Eigen::Vector4f size;
  storeGroup(size.data(), high - low);
  return bodies.row_sum * static_cast<double>(size.head<3>().norm());
}

}  // namespace

SkinBodies makeSkinBodies(const SkinModel& skin, double spacing) {
  SkinBodies bodies;
  const SurfaceBodies of = bodiesOf(skin.surface);
  bodies.count = of.count;
  bodies.body = of.ofVertices(skin.surface);
  for (int& b : bodies.body) b = std::max(b, 0);
  bodies.rank = byDensity(bodies, skin);
  bodies.organ.assign(static_cast<std::size_t>(of.count), 0);
  bodies.friction.assign(static_cast<std::size_t>(of.count), 0.0F);
  bodies.spacing = spacing;
  for (const float length : skin.topology.edge_length)
    bodies.longest_edge = std::max(bodies.longest_edge, static_cast<double>(length));
  bodies.normal = vertexNormals(skin.surface);
  addClusterFaces(skin, bodies);
  addGaps(skin, bodies);
  return bodies;
}

SkinContactState makeSkinContactState(const SkinBodies& bodies) {
  SkinContactState state;
  const std::size_t capacity = bodies.body.size();
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

SkinContactScratch::SkinContactScratch(const SkinBodies& bodies, const SkinModel& skin)
    : cluster(bodies.body.empty() ? 0 : static_cast<std::size_t>(skin.clusterCount())) {
  const std::size_t capacity = bodies.body.size();
  for (auto* list : {&old_vertex, &old_face, &nearest}) list->resize(capacity);
  for (auto* looks : {&known, &directed}) looks->resize(capacity);
  for (auto* vectors : {&position, &normal}) vectors->resize(capacity, Vec3::Zero());
  const std::size_t faces = bodies.body.empty() ? 0 : skin.surface.triangles.size();
  measured.resize(faces);
  area.resize(faces, Vec3::Zero());
  nearest_distance2.resize(capacity);
  old_force.resize(capacity);
  old_touches.resize(capacity);
  const std::size_t rows = std::min(capacity, most_pairs), longest = 4 * longestRow(skin);
  row.resize(rows);
  active.resize(rows);
  node.resize(rows * longest);
  N.resize(rows * longest);
}

namespace {

/// m: what is between two skins may be less by as much in the coming tick. They come nearer by twice what the fastest
/// vertex does, which may be half as fast again.
double wayOf(const SkinContactState& state) { return 1.5 * 2 * state.travel + least_way; }

bool needsSearch(const SkinBodies& bodies, const SkinContactState& state) {
  return !state.searched || state.since_search + 2 * state.travel + wayOf(state) > followed_from * bodies.spacing;
}

}  // namespace

bool areCalm(const SkinBodies& bodies, const SkinContactState& state) {
  return bodies.body.empty() || (state.count == 0 && !needsSearch(bodies, state));
}

void findSkinPairs(const SkinBodies& bodies, const SkinModel& skin, const Float4* u, SkinContactState& state,
                   SkinContactScratch& scratch) {
  if (bodies.body.empty()) return;
  const double come = 2 * state.travel, way = wayOf(state);
  const bool searches = needsSearch(bodies, state);
  state.travel = 0;
  state.since_search += come;
  for (int k = 0; k < state.count; ++k) state.clearance[k] -= static_cast<float>(come);
  Look look(bodies, skin, u, scratch);
  if (searches) {
    const double reach = followed_from * bodies.spacing + way;
    const double moved = relativeMotion(bodies, u);
    if (state.count > 0 || moved + reach + bodies.longest_edge >= bodies.least_gap)
      search(bodies, skin, reach, moved, look, state, scratch);
    state.searched = true;
    state.since_search = 0;
  }
  makeRows(bodies, skin, way, look, state, scratch);
}

}  // namespace palpate
