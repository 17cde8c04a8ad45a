#include "setup/interface_nodes.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "discretization/nodes/node_scatter.h"
#include "discretization/nodes/volume_fit.h"
#include "discretization/surface/facet_rule.h"
#include "discretization/surface/feature_edges.h"
#include "discretization/surface/surface_geometry.h"
#include "scene/scene_regions.h"
#include "setup/mixtures.h"

namespace palpate {
namespace {

constexpr double reach = 0.45;       // spacings: nodes of a border come from this far
constexpr double on_edge_of = 1e-3;  // spacings: nodes that were put on a sharp edge are nearer to it
constexpr int bisections = 40;       // of a way across a border
constexpr double past = 1 + 1e-6;    // of the way to a border, so that rounding does not leave a node before it

/// How a node may move: along `axes`, of which there are `free`.
struct Freedom {
  int free = 3;
  Mat3 axes = Mat3::Identity();
};

/// Nodes are imposed in it also inside of the organ, and it is no smaller than what lies between nodes: it ends at a
/// border there. Shells go along the surface.
bool endsInside(const Scene& scene, const BoundarySpec& spec) {
  constexpr double least_radius = 0.5, least_distance = 0.1;  // spacings
  const Region& region = spec.region;
  const double h = scene.discretization.spacing;
  switch (region.kind) {
    case Region::Kind::Shell:
    case Region::Kind::Point:
      return false;
    case Region::Kind::NearPlane:
      return !spec.surface_only && region.distance > least_distance * h;
    case Region::Kind::Sphere:
    case Region::Kind::Cylinder:
      return !spec.surface_only && region.radius > least_radius * h;
    default:
      return !spec.surface_only;
  }
}

/// What a place is of, as a number: its material, and the regions that impose displacements there.
class Parts {
 public:
  Parts(const Scene& scene, const SurfaceTree& organ, bool with_regions)
      : scene_(scene), organ_(organ), materials_(hasSharpInterfaces(scene) || !with_regions) {
    for (const BoundarySpec& spec : scene.boundaries)
      if (with_regions && endsInside(scene, spec)) regions_.push_back(&spec.region);
  }

  int at(const Vec3& X) const {
    int regions = 0;
    for (std::size_t k = 0; k < regions_.size(); ++k)
      if (contains(*regions_[k], X, organ_)) regions |= 1 << (k % most_regions);
    return regions * static_cast<int>(scene_.materials.size()) + (materials_ ? materialAt(scene_, X, organ_) : 0);
  }
  bool isImposed(int part) const { return part >= static_cast<int>(scene_.materials.size()); }

 private:
  static constexpr std::size_t most_regions = 16;  // that are told from each other

  const Scene& scene_;
  const SurfaceTree& organ_;
  bool materials_;
  std::vector<const Region*> regions_;
};

/// Moves nodes of one cloud.
class Mover {
 public:
  Mover(const Scene& scene, const SurfaceTree& organ, bool with_regions = true)
      : parts_(scene, organ, with_regions), organ_(organ), edges_(findFeatureEdges(organ.surface())) {}

  int partAt(const Vec3& X) const { return parts_.at(X); }
  bool isImposed(int part) const { return parts_.isImposed(part); }

  /// The first of some places, further and further into what is imposed, that is on the surface, if it should be, and
  /// imposed still; the last where none is.
  template <class PlaceAt>
  Vec3 imposedPlace(bool on_surface, PlaceAt placeAt) const {
    Vec3 to = Vec3::Zero();
    for (const double further : {0.0, 2e-3, 1e-2, 3e-2, 0.1}) {
      to = placeAt(further);
      if (on_surface) to = organ_.closest(to).point;
      if (isImposed(partAt(to))) break;
    }
    return to;
  }

  /// Whether another material is next to X.
  bool isOnBorder(const Vec3& X, double h) const {
    const int own = partAt(X);
    for (int code = 0; code < 27; ++code) {
      const Vec3 sign(code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1);
      if (!sign.isZero(0) && partAt(X + on_edge_of * h * sign) != own) return true;
    }
    return false;
  }

  /// How far along n the border of material `own` lies from X, or against it where X is of another; 0 where it is not
  /// found within `range`; m.
  double heightOfBorder(const Vec3& X, const Vec3& n, int own, double range) const {
    const int here = partAt(X);
    const double way = here == own ? wayAcross(X, n, own, range) : wayTo(X, -n, own, range);
    return way < 0 ? 0 : here == own ? way : -way;
  }

  /// The part of a motion that leaves a node on the organ's edge or surface where it is on one.
  Vec3 allowed(const Vec3& motion, const Vec3& X, bool on_surface, double h) const {
    if (!on_surface) return motion;
    const Freedom freedom = ofSurface(X, h);
    Vec3 left = Vec3::Zero();
    for (int k = 0; k < freedom.free; ++k) left += freedom.axes.col(k).dot(motion) * freedom.axes.col(k);
    return left;
  }

  /// Whether a node of the surface may go to another place there: those of edges stay on their edge, corners where they
  /// are.
  bool staysOnEdge(const Vec3& X, const Vec3& to, double h) const {
    return ofSurface(X, h).free == 2 || (allowed(to - X, X, true, h) - (to - X)).norm() < on_edge_of * h;
  }

  /// Where the way from a to b gets to another material, away from its ends; none where it does not, or where it only
  /// runs along a border.
  std::optional<Vec3> crossing(const Vec3& a, const Vec3& b) const {
    constexpr double looks[] = {0.08, 0.36, 0.64, 0.92};  // of the way: a layer that it crosses takes up a third of it
    for (std::size_t k = 1; k < std::size(looks); ++k) {
      const int own = partAt(a + looks[k - 1] * (b - a));
      if (partAt(a + looks[k] * (b - a)) == own) continue;
      double low = looks[k - 1], high = looks[k];
      for (int n = 0; n < bisections; ++n) {
        const double middle = (low + high) / 2;
        (partAt(a + middle * (b - a)) == own ? low : high) = middle;
      }
      const Vec3 at = a + high * (b - a);
      const double h = (b - a).norm();
      if (!isOnBorder((a + at) / 2, h) && !isOnBorder((at + b) / 2, h)) return at;
    }
    return std::nullopt;
  }

  /// Where the node gets to a border within `range`; itself where it doesn't.
  Vec3 onBorder(const Vec3& X, bool on_surface, double h) const {
    const Freedom freedom = on_surface ? ofSurface(X, h) : Freedom{};
    if (freedom.free == 0) return X;
    const int own = partAt(X);
    // Distances to the border along many directions; of a plane border they give its normal.
    Mat3 A = Mat3::Zero();
    Vec3 b = Vec3::Zero(), best = Vec3::Zero();
    double nearest = 2 * h;
    for (int code = 0; code < 27; ++code) {
      const Vec3 sign(code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1);
      if ((sign.tail(3 - freedom.free).array() != 0).any() || sign.isZero(0)) continue;
      const Vec3 d = (freedom.axes * sign).normalized();
      const double t = wayAcross(X, d, own, 1.5 * reach * h);
      if (t < 0) continue;
      A += t * t * d * d.transpose();
      b += t * d;
      if (t < nearest) nearest = t, best = d;
    }
    if (nearest > 1.5 * reach * h) return X;
    const double size = A.trace();
    const Vec3 normal = (A + 1e-9 * size * Mat3::Identity()).inverse() * b;
    if (normal.norm() > 0) {
      const double t = wayAcross(X, normal.normalized(), own, 1.5 * reach * h);
      if (t >= 0 && t < nearest) nearest = t, best = normal.normalized();
    }
    if (nearest > reach * h) return X;
    const bool leaves = isImposed(own), enters = !leaves && isImposed(partAt(X + nearest * past * best));
    if (leaves && nearest < on_edge_of * h) return X;  // it is there
    if (leaves || enters) {
      const double side = leaves ? -1 : 1;  // of the border, to be on
      const Vec3 to = imposedPlace(
          on_surface, [&](double further) { return Vec3(X + nearest * (1 + side * (past - 1 + further)) * best); });
      if (!isImposed(partAt(to)) || (on_surface && !staysOnEdge(X, to, h))) return X;
      return on_surface || organ_.signedDistance(to) <= -closest_approach * h ? to : X;
    }
    const Vec3 moved = X + nearest * past * best;
    if (on_surface) return back(moved, freedom);
    return organ_.signedDistance(moved) <= -closest_approach * h ? moved : X;
  }

 private:
  /// m along d to another material, or -1: none within `range`.
  double wayAcross(const Vec3& X, const Vec3& d, int own, double range) const {
    return way(X, d, range, [own](int material) { return material != own; });
  }

  /// m along d to that material, or -1 likewise.
  double wayTo(const Vec3& X, const Vec3& d, int other, double range) const {
    return way(X, d, range, [other](int material) { return material == other; });
  }

  template <class Wanted>
  double way(const Vec3& X, const Vec3& d, double range, Wanted wanted) const {
    constexpr int looks = 3;
    for (int k = 1; k <= looks; ++k) {
      double low = range * (k - 1) / looks, high = range * k / looks;
      if (!wanted(partAt(X + high * d))) continue;
      for (int n = 0; n < bisections; ++n) {
        const double middle = (low + high) / 2;
        (wanted(partAt(X + middle * d)) ? high : low) = middle;
      }
      return high;
    }
    return -1;
  }

  Freedom ofSurface(const Vec3& X, double h) const {
    for (const Vec3& corner : edges_.corners)
      if ((corner - X).norm() < on_edge_of * h) return {0, Mat3::Identity()};
    Freedom freedom;
    Vec3 along;
    if (nearestOfEdges(X, on_edge_of * h, &along)) {
      freedom.free = 1;
      freedom.axes.col(0) = along;
      return freedom;
    }
    const auto& face = organ_.surface().triangles[static_cast<std::size_t>(organ_.closest(X).triangle)];
    const auto& V = organ_.surface().vertices;
    const Vec3 normal = (V[face[1]] - V[face[0]]).cross(V[face[2]] - V[face[0]]).normalized();
    freedom.free = 2;
    freedom.axes.col(0) = normal.unitOrthogonal();
    freedom.axes.col(1) = normal.cross(freedom.axes.col(0));
    return freedom;
  }

  /// The point of the sharp edges nearest to X, if one is within `range`; and the edge's direction there.
  std::optional<Vec3> nearestOfEdges(const Vec3& X, double range, Vec3* along = nullptr) const {
    std::optional<Vec3> found;
    for (const auto& chain : edges_.chains)
      for (std::size_t k = 0; k + 1 < chain.points.size(); ++k) {
        const Vec3 edge = chain.points[k + 1] - chain.points[k];
        const double t = std::clamp((X - chain.points[k]).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
        const Vec3 p = chain.points[k] + t * edge;
        if ((p - X).norm() > range) continue;
        range = (p - X).norm();
        found = p;
        if (along != nullptr) *along = edge.normalized();
      }
    return found;
  }

  /// Back onto the edge or the surface.
  Vec3 back(const Vec3& X, const Freedom& freedom) const {
    if (freedom.free == 1) return nearestOfEdges(X, std::numeric_limits<double>::infinity()).value_or(X);
    return organ_.closest(X).point;
  }

  Parts parts_;
  const SurfaceTree& organ_;
  FeatureEdges edges_;
};

}  // namespace

bool hasSharpInterfaces(const Scene& scene) {
  return scene.discretization.formulation.sharp_interfaces && scene.materials.size() > 1 && mixedMaterial(scene) == 0 &&
         scene.discretization.formulation.consistent_gradients;
}

bool hasBorders(const Scene& scene) {
  const Formulation& formulation = scene.discretization.formulation;
  const bool imposes = std::any_of(scene.boundaries.begin(), scene.boundaries.end(),
                                   [&](const BoundarySpec& spec) { return endsInside(scene, spec); });
  return hasSharpInterfaces(scene) || (imposes && formulation.sharp_interfaces && formulation.consistent_gradients);
}

int putOnInterfaces(const Scene& scene, const SurfaceTree& organ, const SpacingField& spacing, NodeCloud& cloud) {
  const Mover mover(scene, organ);
  struct Move {
    double way;  // spacings
    std::size_t node;
    Vec3 to;
  };
  std::vector<Move> moves;
  SiteGrid grid(boundingBox(organ.surface()), std::sqrt(spacing.smallest() * spacing.largest()));
  std::vector<Vec3> now = cloud.X;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const double h = spacing.at(now[i]);
    grid.add({now[i], Vec3::Zero(), h});
    const Vec3 to = mover.onBorder(now[i], cloud.on_surface[i] != 0, h);
    if (const double way = (to - now[i]).norm(); way > 0) moves.push_back({way / h, i, to});
  }
  // Edges before faces before the inside, as the cloud has them, and the nearest first.
  std::stable_sort(moves.begin(), moves.end(), [&](const Move& a, const Move& b) {
    const int before = cloud.on_surface[a.node] - cloud.on_surface[b.node];
    return before != 0 ? before > 0 : a.way < b.way;
  });
  int moved = 0;
  for (const Move& move : moves) {
    const double h = spacing.at(move.to);
    bool free = true;
    // No node goes further than `reach`: who is near now was near before.
    grid.forEachWithin(move.to, (closest_approach + reach) * h, [&](int j, const Site&) {
      free = static_cast<std::size_t>(j) == move.node || (now[j] - move.to).norm() >= closest_approach * h;
      return free;
    });
    if (!free) continue;
    now[move.node] = move.to;
    ++moved;
  }
  cloud.X = std::move(now);
  return moved;
}

Mended closeInterfaces(const Scene& scene, const SurfaceTree& organ, const SpacingField& spacing,
                       const std::vector<std::array<int, 4>>& cells, NodeCloud& cloud) {
  constexpr double free = 0.45;  // spacings: nearer nodes move instead of a new one, if they may
  // Spacings: no new one is nearer to one that may not, or to the surface; at the border of what is imposed.
  constexpr double least_of_materials = 0.3, least_of_imposed = 0.45;
  constexpr double there = 0.1;  // spacings: a node of the surface may lie a little within what is imposed
  const Mover mover(scene, organ);
  std::vector<int> part(cloud.X.size());
  std::vector<std::uint8_t> on_border(cloud.X.size());
  SiteGrid grid(boundingBox(organ.surface()), std::sqrt(spacing.smallest() * spacing.largest()));
  for (std::size_t i = 0; i < cloud.X.size(); ++i) {
    const double h = spacing.at(cloud.X[i]);
    part[i] = mover.partAt(cloud.X[i]);
    on_border[i] = mover.isOnBorder(cloud.X[i], h);
    grid.add({cloud.X[i], Vec3::Zero(), h});
  }
  std::set<std::pair<int, int>> edges;
  for (const auto& cell : cells)
    for (const int i : cell)
      for (const int j : cell)
        if (i < j && (part[i] != part[j] || on_border[i] || on_border[j])) edges.insert({i, j});
  Mended mended;
  for (const auto& [i, j] : edges) {
    const std::optional<Vec3> crossing = mover.crossing(cloud.X[i], cloud.X[j]);
    if (!crossing) continue;
    const double h = spacing.at(*crossing);
    const bool of_imposed = mover.isImposed(part[i]) != mover.isImposed(part[j]);
    const double least = of_imposed ? least_of_imposed : least_of_materials;
    const bool on_surface =
        (cloud.on_surface[i] != 0 && cloud.on_surface[j] != 0) || organ.signedDistance(*crossing) > -least * h;
    const Vec3& imposed = cloud.X[mover.isImposed(part[i]) ? i : j];
    const Vec3 at =
        of_imposed ? mover.imposedPlace(
                         on_surface, [&](double further) { return Vec3(*crossing + further * (imposed - *crossing)); })
        : on_surface ? organ.closest(*crossing).point
                     : *crossing;
    if (of_imposed && (at - *crossing).norm() > there * h) continue;  // the surface's own nodes have to do
    int nearest = -1;
    double distance = free * h;
    grid.forEachWithin(at, (free + reach) * h, [&](int k, const Site&) {
      if (const double d = (cloud.X[k] - at).norm(); d < distance) distance = d, nearest = k;
      return true;
    });
    if (of_imposed && nearest >= 0 && distance < there * h) continue;
    if (nearest >= 0 && !on_border[nearest] && (cloud.on_surface[nearest] != 0) == on_surface &&
        (!on_surface || mover.staysOnEdge(cloud.X[nearest], at, h))) {
      cloud.X[nearest] = at;
      on_border[nearest] = 1;
    } else if (nearest < 0 || distance > least * h) {
      grid.add({at, Vec3::Zero(), h});
      cloud.X.push_back(at);
      cloud.on_surface.push_back(on_surface ? 1 : 0);
      on_border.push_back(1);
    } else {
      continue;
    }
    ++(of_imposed ? mended.of_imposed : mended.of_materials);
  }
  return mended;
}

void fitInterfaces(const Scene& scene, const SurfaceTree& organ, NodeCloud& cloud, BackgroundCells& cells) {
  constexpr int rounds = 4;          // each leaves about a third of the gap
  constexpr double flat_gap = 1e-4;  // of a facet's edge: nodes were put on the border less exactly than that
  constexpr double farthest = 0.25;  // of a facet's edge, of a node's way
  const Mover mover(scene, organ, false);
  std::vector<int> material;
  for (const Vec3& middle : centroids(cloud.X, cells.cells)) material.push_back(materialAt(scene, middle, organ));
  struct Facet {
    std::array<int, 3> nodes;
    int cell;  // on the side that the normal leaves
  };
  std::vector<Facet> facets;
  for (const auto& [a, b] : neighbouringCells(cells.cells)) {
    const auto &one = cells.cells[static_cast<std::size_t>(a)], &other = cells.cells[static_cast<std::size_t>(b)];
    if (material[static_cast<std::size_t>(a)] == material[static_cast<std::size_t>(b)]) continue;
    Facet facet{{}, a};
    std::copy_if(one.begin(), one.end(), facet.nodes.begin(),
                 [&](int i) { return std::find(other.begin(), other.end(), i) != other.end(); });
    facets.push_back(facet);
  }
  const std::vector<Vec3> start = cloud.X;
  const std::vector<double> first_volume = cells.volume;
  for (int round = 0; round < rounds; ++round) {
    std::vector<Vec3> motion(start.size(), Vec3::Zero());
    std::vector<double> area(start.size(), 0), reach_of(start.size(), 0);
    const std::vector<Vec3> middles = centroids(cloud.X, cells.cells);
    bool uneven = false;
    for (const Facet& facet : facets) {
      const auto corner = [&](std::size_t k) -> const Vec3& {
        return cloud.X[static_cast<std::size_t>(facet.nodes[k])];
      };
      const Vec3 across = (corner(1) - corner(0)).cross(corner(2) - corner(0)) / 2;
      const auto cell = static_cast<std::size_t>(facet.cell);
      const Vec3 n = across.normalized() * ((corner(0) - middles[cell]).dot(across) < 0 ? -1 : 1);
      const double edge = std::sqrt(2 * across.norm());
      double gap = 0;
      for (int k = 0; k < FacetRule::size; ++k)
        gap += FacetRule::weight(k) * mover.heightOfBorder(FacetRule::point(k, corner(0), corner(1), corner(2)), n,
                                                           material[cell], 0.5 * edge);
      uneven |= std::abs(gap) > flat_gap * edge;
      for (const int i : facet.nodes) {
        motion[static_cast<std::size_t>(i)] += across.norm() * (std::abs(gap) > flat_gap * edge ? gap : 0) * n;
        area[static_cast<std::size_t>(i)] += across.norm();
        reach_of[static_cast<std::size_t>(i)] += across.norm() * edge;
      }
    }
    if (!uneven) return;
    std::vector<Vec3> X = cloud.X;
    for (std::size_t i = 0; i < X.size(); ++i) {
      if (area[i] == 0) continue;
      const double edge = reach_of[i] / area[i];
      const Vec3 total =
          cloud.X[i] + mover.allowed(motion[i] / area[i], start[i], cloud.on_surface[i] != 0, edge) - start[i];
      X[i] = start[i] + total * std::min(1.0, farthest * edge / std::max(total.norm(), 1e-300));
    }
    holdShrinking(cells, first_volume, cloud.X, X);
    cloud.X = X;
  }
  updateVolumes(cells, cloud.X);
}

}  // namespace palpate
