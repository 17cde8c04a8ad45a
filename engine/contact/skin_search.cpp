#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "base/types.h"
#include "contact/skin_contact.h"
#include "contact/skin_places.h"
#include "discretization/surface/surface_geometry.h"

namespace palpate {
namespace {

/// Vertices are followed from this distance on, spacings; so far two regions may move before they are looked at again.
/// (Under a hand at 1 m/s on the liver 0.5 to 3 cost the same: fewer looks, each at more.)
constexpr double followed_from = 0.5;

/// Spacings, by which parts that are far from each other may come nearer before that is asked again: a tenth of what
/// regions may move is then spent when they begin to be watched, and asking costs as much as reading the nodes once.
constexpr double calm_for = 0.1;

/// m, by which a region's vertices may move in the coming tick: half as much again as in the last.
double comingOf(double moved) { return 1.5 * moved; }

/// Spacings, to which a vertex may be inside another body and is still taken for one that goes out by the nearest face:
/// what came so deep between two looks.
constexpr double deepest_entry = 1;

/// Spacings, by which two places of one body may be in each other. What comes deeper has been passed by something that
/// contact can't hold, and finds its way back better alone: held, it locks (0.5 left a gel's skin crossing itself in 29
/// of 77 looks after a rough hand, 0.1 in as many as no contact at all, 2).
constexpr double deepest_hold = 0.1;

/// Of the skin, which the bounds of clusters allow for, as the tools' (broad_phase.cpp).
constexpr double most_stretch = 2;

/// m, within which what rests takes part: forces on its neighbours may push it to the other skin.
constexpr double least_way = 1e-4;

/// m, from which on vertices are listed where they came nearer by so much in the last tick.
double reachOf(const SkinBodies& bodies, double come) {
  return std::max(followed_from * bodies.spacing, comingOf(come) + least_way);
}

/// Faces that meet at less than this are of one smooth skin (cosine).
constexpr double smooth_cosine = 0.7;

/// m: nearer or not is no question below.
constexpr double same_distance = 1e-7;

/// Cosine of the angle between the face's normal and the way to what is before it: what is beyond an edge, beside the
/// face, does not touch it.
constexpr double before_face = 0.5;

/// Cosine of the angle between the normals of a vertex and of a face of another body that it looks at, and rather
/// touches than others: what lies flat under an edge that slides over it is not met by the side beyond the edge.
/// (Else a soft cube on a soft block stuck on slopes of twice its angle of friction, its edge in its own dent. -0.05
/// does, too.)
constexpr double facing = -0.25;

/// Distances of points, or edges of the skin, by which those of the coarser skin may go into the finer: corners that
/// stand between the finer one's are met here. Both sides at once would be more conditions than there are nodes, and
/// forces would wander between them, which friction does not survive.
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
  Look(const SkinBodies& bodies, const SkinModel& skin, const Float4* u, const Float4* du, int steps,
       SkinContactScratch& scratch)
      : bodies_(bodies), skin_(skin), u_(u), du_(du), steps_(steps), scratch_(scratch) {
    if (++scratch_.look == 0) {  // once in 2^32 looks
      std::fill(scratch_.known.begin(), scratch_.known.end(), 0U);
      std::fill(scratch_.directed.begin(), scratch_.directed.end(), 0U);
      std::fill(scratch_.measured.begin(), scratch_.measured.end(), 0U);
      for (SkinContactScratch::Cluster& cluster : scratch_.cluster) cluster.look = cluster.directed = 0;
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

  /// m, that it will move in a tick if it goes on as now.
  Vec3 comingAt(int v) const { return steps_ * interpolateAtVertex(skin_, v, du_).head<3>().cast<double>(); }

  /// Of the faces around a vertex as they are.
  const Vec3& normalAt(int v) {
    if (scratch_.directed[v] == scratch_.look) return scratch_.normal[v];
    scratch_.directed[v] = scratch_.look;
    Vec3 sum = Vec3::Zero();
    for (const int t : facesAround(v)) sum += areaOf(t);
    return scratch_.normal[v] = unit(sum);
  }

  /// The nearest of the faces around a face's corners, and so on until none is nearer; of those that the vertex looks
  /// at, where there are any.
  /// @param touches  then it stays on the side by which it came: no sharp edge is crossed
  Stand follow(int vertex, int face, bool touches = false) {
    const Stand first = standAt(at(vertex), face);
    const bool is_faced = touches || isFaced(vertex, face);
    if (is_faced && first.barycentric.minCoeff() > 0) return first;  // straight before it
    if (is_faced) return nearestFrom(vertex, first, touches, false);
    Stand far = first;
    far.distance = std::numeric_limits<double>::infinity();
    const Stand faced = nearestFrom(vertex, far, touches, true);
    return faced.face != face                 ? faced
           : first.barycentric.minCoeff() > 0 ? first
                                              : nearestFrom(vertex, first, touches, false);
  }

  /// Whether a vertex looks at a face of another body.
  bool isFaced(int vertex, int t) {
    return bodies_.body[vertex] == bodies_.body[corners(t)[0]] || unit(areaOf(t)).dot(normalAt(vertex)) <= facing;
  }

  /// From the faces around another vertex on.
  Stand followFrom(int vertex, int other) {
    Stand best;
    nearestAround(vertex, other, false, false, best);
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
    const auto& topology = *skin_.topology;
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

  Stand nearestFrom(int vertex, Stand best, bool touches, bool faced) {
    constexpr int most_moves = 32;
    for (int move = 0; move < most_moves; ++move) {
      const int from = best.face;
      for (const int v : skin_.surface.triangles[from]) nearestAround(vertex, v, touches, faced, best);
      if (best.face == from) break;
    }
    return best;
  }

  /// Of faces at whose common edge or corner the vertex is nearest, the one that it faces.
  /// @param faced  only faces that it looks at
  void nearestAround(int vertex, int v, bool touches, bool faced, Stand& best) {
    for (const int t : facesAround(v)) {
      if (t == best.face || !isApart(vertex, t)) continue;
      if ((touches && !areSmooth(t, best.face)) || (faced && !isFaced(vertex, t))) continue;
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
  const Float4 *u_, *du_;
  int steps_;
  SkinContactScratch& scratch_;
};

/// SkinContactState::clearance of what is inside the other's skin.
constexpr float inside = -std::numeric_limits<float>::infinity();

/// Whether a pair touched when it was last looked at.
bool touched(const SkinContactState& state, int k) { return state.clearance[k] == inside || !isZero(state.force[k]); }

/// Or is so near that it may by now.
bool touches(const SkinContactState& state, int k) { return state.clearance[k] <= 0 || touched(state, k); }

/// How far a cluster's vertices are from its centre, and how it moves.
const SkinContactScratch::Cluster& measured(const SkinModel& skin, int c, Look& look, SkinContactScratch& scratch) {
  SkinContactScratch::Cluster& cluster = scratch.cluster[static_cast<std::size_t>(c)];
  if (cluster.look == scratch.look) return cluster;
  cluster.look = scratch.look;
  cluster.coming = look.comingAt(skin.cluster_representative[c]);
  double far2 = 0, uneven2 = 0;
  for (int k = skin.cluster_begin[c]; k < skin.cluster_begin[c + 1]; ++k) {
    far2 = std::max(far2, (look.at(skin.cluster_vertex[k]) - cluster.centre).squaredNorm());
    uneven2 = std::max(uneven2, (look.comingAt(skin.cluster_vertex[k]) - cluster.coming).squaredNorm());
  }
  cluster.radius = std::sqrt(far2);
  cluster.uneven = std::sqrt(uneven2);
  return cluster;
}

/// With the ways that a cluster's faces look, and its vertices in blocks.
void direct(const SkinBodies& bodies, const SkinModel& skin, int c, Look& look, SkinContactScratch& scratch) {
  SkinContactScratch::Cluster& cluster = scratch.cluster[static_cast<std::size_t>(c)];
  if (cluster.directed == scratch.look) return;
  cluster.directed = scratch.look;
  Vec3 sum = Vec3::Zero();
  const std::span<const int> faces(bodies.cluster_face.data() + bodies.cluster_face_begin[c],
                                   bodies.cluster_face.data() + bodies.cluster_face_begin[c + 1]);
  for (const int t : faces) sum += look.areaOf(t);
  cluster.axis = unit(sum);
  double least = 1;
  for (const int t : faces) least = std::min(least, unit(look.areaOf(t)).dot(cluster.axis));
  cluster.spread = std::acos(std::clamp(least, -1.0, 1.0));
  for (int k = skin.cluster_begin[c]; k < skin.cluster_begin[c + 1]; ++k) {
    const int v = skin.cluster_vertex[k], place = k - skin.cluster_begin[c];
    const Vec3f from_centre = (look.at(v) - cluster.centre).cast<float>(), normal = look.normalAt(v).cast<float>();
    auto& block = scratch.block[scratch.block_begin[c] + place / 16];
    for (std::size_t d = 0; d < 3; ++d) {
      block[d][static_cast<std::size_t>(place % 16)] = from_centre[static_cast<int>(d)];
      block[3 + d][static_cast<std::size_t>(place % 16)] = normal[static_cast<int>(d)];
    }
  }
}

/// Takes w for the nearest that v may touch if it is.
/// @param apart2  m^2: not further
void offer(const SkinBodies& bodies, const SkinModel& skin, int v, int w, double apart2, Look& look,
           SkinContactScratch& scratch) {
  const Vec3 to = look.at(w) - look.at(v);
  const double d2 = to.squaredNorm(), least = scratch.nearest_distance2[v];
  if (d2 > apart2 || d2 > least || (d2 == least && w > scratch.nearest[v])) return;
  // They look at each other; within one body with no tissue between them.
  const Vec3 &n = look.normalAt(v), &m = look.normalAt(w);
  if (n.dot(m) >= 0) return;
  if (bodies.body[v] == bodies.body[w] && (to.dot(n) <= 0 || to.dot(m) >= 0)) return;
  if (!mayTouch(bodies, skin, v, w)) return;
  scratch.nearest_distance2[v] = d2;
  scratch.nearest[v] = w;
}

/// The nearest that each vertex of one cluster may touch in another, no further than `apart` (m).
void findNearest(const SkinBodies& bodies, const SkinModel& skin, int a, int b, double apart, Look& look,
                 SkinContactScratch& scratch) {
  constexpr float rounding = 1e-5F;  // of squared lengths and of cosines, that is left to `offer`
  const SkinContactScratch::Cluster& other = scratch.cluster[static_cast<std::size_t>(b)];
  const double turned = other.spread < std::numbers::pi / 2 ? std::sin(other.spread) : 1;
  const bool of_one = areOfOne(bodies, a, b);
  const float between = of_one ? 0 : std::numeric_limits<float>::infinity();
  for (int k = skin.cluster_begin[a]; k < skin.cluster_begin[a + 1]; ++k) {
    const int v = skin.cluster_vertex[k];
    const double limit2 = std::min(apart * apart, scratch.nearest_distance2[v]);
    const Vec3 to = other.centre - look.at(v);
    const double way = to.norm() - other.radius;
    if (limit2 < 0 || (way > 0 && way * way > limit2)) continue;
    // It looks at none of them, or there is tissue between.
    const Vec3& n = look.normalAt(v);
    if (n.dot(other.axis) > turned || (of_one && n.dot(to) + other.radius <= 0)) continue;
    const Vec3f x = to.cast<float>(), m = n.cast<float>();
    const float far2 = (1 + rounding) * static_cast<float>(limit2), aside = rounding * std::sqrt(far2) + between;
    for (int t = scratch.block_begin[b]; t < scratch.block_begin[b + 1]; ++t) {
      const auto& [X, Y, Z, U, V, W] = scratch.block[t];
      std::array<std::uint8_t, 16> near;
      unsigned any = 0;
      for (std::size_t l = 0; l < 16; ++l) {
        const float dx = x[0] + X[l], dy = x[1] + Y[l], dz = x[2] + Z[l];
        near[l] = (dx * dx + dy * dy + dz * dz <= far2) & (m[0] * U[l] + m[1] * V[l] + m[2] * W[l] <= rounding) &
                  (dx * m[0] + dy * m[1] + dz * m[2] >= -aside) & (dx * U[l] + dy * V[l] + dz * W[l] <= aside);
        any |= near[l];
      }
      if (any == 0) continue;
      const int first = skin.cluster_begin[b] + 16 * (t - scratch.block_begin[b]);
      for (std::size_t l = 0; l < 16; ++l)
        if (near[l] != 0)
          offer(bodies, skin, v, skin.cluster_vertex[first + static_cast<int>(l)], apart * apart, look, scratch);
    }
  }
}

/// The nearest vertex that each may touch, no further than `apart` (m); -1: none. Not for those that touch: they are
/// followed from face to face.
/// @param moved  m: no two places are further from where they were to each other
void findNearest(const SkinBodies& bodies, const SkinModel& skin, double apart, double moved, Look& look,
                 const SkinContactState& state, SkinContactScratch& scratch) {
  std::fill(scratch.nearest.begin(), scratch.nearest.end(), -1);
  std::fill(scratch.nearest_distance2.begin(), scratch.nearest_distance2.end(), apart * apart);
  for (int k = 0; k < state.count; ++k) {
    const int v = state.vertex[k];
    if (touches(state, k))
      scratch.nearest_distance2[v] = -1;
    else  // what was near a vertex mostly still is, and whatever is further need not be looked at
      for (const int w : look.corners(state.face[k])) offer(bodies, skin, v, w, apart * apart, look, scratch);
  }
  for (int c = 0; c < skin.clusterCount(); ++c) {
    SkinContactScratch::Cluster& cluster = scratch.cluster[static_cast<std::size_t>(c)];
    cluster.centre = look.at(skin.cluster_representative[c]);
    cluster.reach = most_stretch * static_cast<double>(skin.cluster_radius[c]);
  }
  const SkinContactScratch::Cluster* clusters = scratch.cluster.data();
  const auto areNear = [&](const Vec3& x, const Vec3& y, double reach) {
    return (x - y).squaredNorm() <= (apart + reach) * (apart + reach);
  };
  const auto mayBeNear = [&](int a, int b) {
    return areNear(clusters[a].centre, clusters[b].centre, clusters[a].reach + clusters[b].reach);
  };
  const auto compare = [&](int a, int b) {
    const SkinContactScratch::Cluster &one = measured(skin, a, look, scratch),
                                      &other = measured(skin, b, look, scratch);
    // What moves with the other comes no nearer.
    const double come = (one.coming - other.coming).norm() + one.uneven + other.uneven;
    const double near = std::min(apart, reachOf(bodies, come) + bodies.longest_edge);
    if ((one.centre - other.centre).norm() > near + one.radius + other.radius) return;
    // No two of their faces look at each other.
    direct(bodies, skin, a, look, scratch);
    direct(bodies, skin, b, look, scratch);
    const double turned = one.spread + other.spread;
    if (turned < std::numbers::pi / 2 && one.axis.dot(other.axis) > std::sin(turned)) return;
    findNearest(bodies, skin, a, b, near, look, scratch);
    if (a != b) findNearest(bodies, skin, b, a, near, look, scratch);
  };
  const auto isDue = [&](int cluster) { return scratch.due[bodies.region[skin.cluster_representative[cluster]]] != 0; };
  for (const auto& [a, b] : bodies.across_gaps)
    if ((isDue(a) || isDue(b)) && distanceBetween(skin, a, b)[0] < moved + apart && mayBeNear(a, b)) compare(a, b);
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
  const auto regionRadius = [&](int r) {
    double far = 0;
    for (int c = skin.region_begin[r]; c < skin.region_begin[r + 1]; ++c)
      far = std::max(far, (clusters[c].centre - centreOf(r)).norm() + clusters[c].reach);
    return far;
  };
  // Places that are far from each other at rest can be near only if their clusters have moved differently: those of one
  // move as its middle does, to within its radius.
  const auto mayHaveFolded = [&](int a, int b) {
    const int v = skin.cluster_representative[a], w = skin.cluster_representative[b];
    const auto& X = skin.surface.vertices;
    const auto radii = static_cast<double>(skin.cluster_radius[a] + skin.cluster_radius[b]);
    const double least = along_skin * bodies.spacing - apart - radii;
    return (least <= 0 || (clusters[a].centre - X[v] - clusters[b].centre + X[w]).squaredNorm() >= least * least) &&
           distanceBetween(skin, a, b)[1] > along_skin * bodies.spacing;
  };
  std::array<double, 1024> radius;  // of so many regions; the others are taken for near
  const auto known = std::min<int>(skin.regionCount(), static_cast<int>(radius.size()));
  for (int r = 0; r < known; ++r) radius[static_cast<std::size_t>(r)] = regionRadius(r);
  for (int r = 0; r < skin.regionCount(); ++r)
    for (int s = r; s < skin.regionCount(); ++s) {
      if (scratch.due[r] == 0 && scratch.due[s] == 0) continue;
      if (calm && bodyOf(r) >= 0 && bodyOf(r) == bodyOf(s)) continue;
      if (s < known &&
          !areNear(centreOf(r), centreOf(s), radius[static_cast<std::size_t>(r)] + radius[static_cast<std::size_t>(s)]))
        continue;
      for (int a = skin.region_begin[r]; a < skin.region_begin[r + 1]; ++a)
        for (int b = std::max(a, skin.region_begin[s]); b < skin.region_begin[s + 1]; ++b)
          if (mayBeNear(a, b) && (!areOfOne(bodies, a, b) || (!calm && mayHaveFolded(a, b)))) compare(a, b);
    }
}

/// Whether a vertex is listed before a face: near, on its outer side or no deeper than what came in between two looks.
bool mayEnter(const SkinBodies& bodies, int v, const Stand& stand, double reach, Look& look) {
  if (stand.face < 0 || !(stand.distance <= reach)) return false;
  const Vec3 normal = look.normalOf(stand);
  return normal.dot(look.at(v) - look.pointOf(stand)) >= 0 ||
         (bodies.body[v] != bodies.body[look.corners(stand.face)[0]] &&
          stand.distance <= deepest_entry * bodies.spacing && normal.dot(look.normalAt(v)) <= 0);
}

/// Looks at the regions that are due. @param reach  m, from which on vertices are listed
void search(const SkinBodies& bodies, const SkinModel& skin, double reach, double moved, Look& look,
            SkinContactState& state, SkinContactScratch& scratch) {
  // How far a body's vertices are from one that is before the middle of its largest face.
  findNearest(bodies, skin, reach + bodies.longest_edge, moved, look, state, scratch);
  for (int k = 0; k < state.count; ++k)
    scratch.old_touches[k] = state.clearance[k] == inside ? 2 : touches(state, k) ? 1 : 0;
  std::swap(state.vertex, scratch.old_vertex);
  std::swap(state.face, scratch.old_face);
  std::swap(state.force, scratch.old_force);
  std::swap(state.clearance, scratch.old_clearance);
  const int old_count = state.count, vertices = skin.vertexCount();
  int old = 0;
  state.count = 0;
  for (int v = 0; v < vertices; ++v) {
    while (old < old_count && scratch.old_vertex[old] < v) ++old;
    const bool listed = old < old_count && scratch.old_vertex[old] == v;
    const bool touched = listed && scratch.old_touches[old] != 0;
    const bool kept = listed && !touched && scratch.due[bodies.region[v]] == 0;
    if (!touched && scratch.nearest[v] < 0 && !kept) continue;
    Stand stand;
    if (touched)
      stand = look.follow(v, scratch.old_face[old], touched);
    else if (scratch.nearest[v] >= 0)
      stand = look.followFrom(v, scratch.nearest[v]);
    const bool is_new = !touched && mayEnter(bodies, v, stand, reach, look) &&
                        !(kept && look.follow(v, scratch.old_face[old]).distance <= stand.distance);
    if (!touched && !is_new && !kept) continue;
    const int k = state.count++;
    state.vertex[k] = v;
    state.face[k] = touched || is_new ? stand.face : scratch.old_face[old];
    state.force[k] = touched ? scratch.old_force[old] : Float4{};
    state.clearance[k] = touched  ? (scratch.old_touches[old] == 2 ? inside : 0.0F)
                         : is_new ? static_cast<float>(stand.distance)
                                  : scratch.old_clearance[old];
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

/// m: by so much vertex and face of a pair came nearer in the last tick at most.
double movedOf(const SkinBodies& bodies, const SkinModel& skin, const SkinContactState& state, int k) {
  float of_face = 0;
  for (const int corner : skin.surface.triangles[state.face[k]])
    of_face = std::max(of_face, state.moved[bodies.region[corner]]);
  return static_cast<double>(state.moved[bodies.region[state.vertex[k]]] + of_face);
}

/// The pairs that may touch in this tick, as rows.
void makeRows(const SkinBodies& bodies, const SkinModel& skin, Look& look, SkinContactState& state,
              SkinContactScratch& scratch) {
  int end = 0;
  for (int k = 0; k < state.count; ++k) {
    const double way = comingOf(movedOf(bodies, skin, state, k)) + least_way;
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
    const bool may_touch = (same || bodies.area[v] > 0) && !is_beside &&
                           static_cast<double>(state.clearance[k]) <= way && std::isfinite(gap);
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
    row.lift = static_cast<float>(same ? (carries(v, corner[0], skin) ? -missed_depth * bodies.longest_edge : 0)
                                       : (bodies.rank[own] < bodies.rank[other] ? 0 : missed_depth * bodies.apart));
    row.area = same ? static_cast<float>(skin.area[v]) : bodies.area[v];
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

SkinContactState makeSkinContactState(const SkinBodies& bodies) {
  SkinContactState state;
  const std::size_t capacity = bodies.body.size();
  state.vertex.resize(capacity);
  state.face.resize(capacity);
  state.clearance.resize(capacity);
  state.force.resize(capacity);
  if (!bodies.body.empty()) {
    state.moved.resize(bodies.region_node_begin.size() - 1);
    state.unseen.resize(state.moved.size(), std::numeric_limits<float>::infinity());
  }
  return state;
}

namespace {

/// Of the skin's vertices, which may touch at once; more where more are points that touch other bodies (sheets in a
/// pile).
constexpr double most_pairs = 0.5;

/// Of a vertex's row, a pair's: that of the vertex and those of a face beside it have most of their nodes in common.
/// (2.24 on three blocks, 2.36 on two cubes.)
constexpr double pair_length = 2.5;

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
  old_clearance.resize(capacity);
  due.resize(bodies.body.empty() ? 0 : static_cast<std::size_t>(skin.regionCount()));
  block_begin.push_back(0);
  for (std::size_t c = 0; c < cluster.size(); ++c)
    block_begin.push_back(block_begin[c] + (skin.cluster_begin[c + 1] - skin.cluster_begin[c] + 15) / 16);
  std::array<std::array<float, 16>, 6> far_away{};
  far_away[0].fill(1e9F);
  block.assign(static_cast<std::size_t>(block_begin.back()), far_away);
  const auto others = std::count(bodies.area.begin(), bodies.area.end(), 0.0F);
  const double points = static_cast<double>(bodies.area.size()) - static_cast<double>(others),
               rows = std::max(points, most_pairs * static_cast<double>(capacity)),
               mean_row = static_cast<double>(skin.node.size()) / std::max(1, skin.vertexCount());
  row.resize(static_cast<std::size_t>(rows));
  active.resize(row.size());
  node.resize(static_cast<std::size_t>(rows * pair_length * mean_row));
  N.resize(node.size());
}

namespace {

/// Parts that were far from each other may not be so for long.
bool staysCalm(const SkinBodies& bodies, const SkinContactState& state) {
  const double come = 2 * state.travel;
  return state.calm && state.since_calm + come + comingOf(come) + least_way <= calm_for * bodies.spacing;
}

/// A region has moved so far that its vertices may be near others.
bool isDue(const SkinBodies& bodies, const SkinContactState& state, std::size_t r) {
  const auto unseen = static_cast<double>(state.unseen[r]), moved = static_cast<double>(state.moved[r]);
  return 2 * (unseen + moved + comingOf(moved)) + least_way > followed_from * bodies.spacing;
}

/// All parts that may touch are far from each other, or it is known by how much each region has moved since.
/// @param moved  m, relativeMotion
void findCalm(const SkinBodies& bodies, double reach, double moved, SkinContactState& state) {
  const bool was_calm = state.calm;
  state.calm = !bodies.several() && moved + reach + bodies.longest_edge < bodies.least_gap;
  if (state.calm) {
    state.count = 0;
    state.since_calm = 0;
  } else if (was_calm) {
    std::fill(state.moved.begin(), state.moved.end(), static_cast<float>(state.travel));
    std::fill(state.unseen.begin(), state.unseen.end(), static_cast<float>(state.since_calm / 2));
  }
}

}  // namespace

bool areCalm(const SkinBodies& bodies, const SkinContactState& state) {
  if (bodies.body.empty() || staysCalm(bodies, state)) return true;
  if (state.calm || state.count > 0) return false;
  for (std::size_t r = 0; r < state.moved.size(); ++r)
    if (isDue(bodies, state, r)) return false;
  return true;
}

void findSkinPairs(const SkinBodies& bodies, const SkinModel& skin, const Float4* u, const Float4* du, int steps,
                   SkinContactState& state, SkinContactScratch& scratch) {
  scratch.row_count = 0;
  scratch.overflow = false;
  if (bodies.body.empty()) return;
  const double come = 2 * state.travel, reach = reachOf(bodies, come);
  if (staysCalm(bodies, state)) {
    state.since_calm += come;
  } else {
    const double moved = relativeMotion(bodies, u);
    findCalm(bodies, reach, moved, state);
    if (!state.calm) {
      bool any = false;
      for (std::size_t r = 0; r < state.moved.size(); ++r) any |= (scratch.due[r] = isDue(bodies, state, r)) != 0;
      for (int k = 0; k < state.count; ++k) state.clearance[k] -= static_cast<float>(movedOf(bodies, skin, state, k));
      Look look(bodies, skin, u, du, steps, scratch);
      if (any) search(bodies, skin, reach, moved, look, state, scratch);
      makeRows(bodies, skin, look, state, scratch);
      for (std::size_t r = 0; r < state.moved.size(); ++r)
        state.unseen[r] = scratch.due[r] != 0 ? 0.0F : state.unseen[r] + state.moved[r];
    }
  }
  std::fill(state.moved.begin(), state.moved.end(), 0.0F);
  state.travel = 0;
}

}  // namespace palpate
