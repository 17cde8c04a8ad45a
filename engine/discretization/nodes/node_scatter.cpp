#include "discretization/nodes/node_scatter.h"

#include <algorithm>
#include <cmath>

#include "base/parallel_for.h"
#include "discretization/surface/surface_gaps.h"
#include "discretization/surface/surface_geometry.h"

namespace palpate {
namespace {

/// Places offered to the darts per node wanted. More cost time and change the result little: the relaxation
/// evens out.
constexpr double candidates_per_node = 16;

/// Pair repulsion s^-4 (1 - s/reach), s = distance / h, zero beyond. A linear law instead lets pairs
/// collapse: closest pair 0.57 h, 5 % flat cells; this one 0.77 h and 1.6 %. Steeper (s^-8) jams before it
/// has relaxed.
constexpr double reach = 1.5;
double repulsion(double s) { return s < reach ? (1 - s / reach) / (s * s * s * s) : 0; }
/// Step of the relaxation, in units of h per unit of repulsion; longest_move keeps stiff pairs from leaping.
constexpr double relax_step = 0.1;
/// 30 iterations bring the closest pair of a box's cloud to 0.71 h, 60 to 0.77 h, 120 to 0.81 h.
constexpr int relax_iterations = 60;
/// No node moves more than this in an iteration, in units of h, so none can leap over the 0.55 h of depth.
constexpr double longest_move = 0.15;

// Shares of the time that the stages take, about.
constexpr double faces_thrown = 0.05, faces_done = 0.3, inside_found = 0.5, inside_thrown = 0.6;

Box3 padded(Box3 box) {
  const Vec3 margin = Vec3::Constant(1e-3 * box.sizes().maxCoeff());
  return {box.min() - margin, box.max() + margin};
}

}  // namespace

Scatter::Scatter(const SurfaceTree& surface, const SpacingField& spacing, unsigned seed,
                 std::function<void(double)> progress)
    : surface_(surface),
      spacing_(spacing),
      progress_(std::move(progress)),
      random_(seed),
      grid_(padded(boundingBox(surface.surface())), std::sqrt(spacing.smallest() * spacing.largest())) {}

/// All nodes nearer than `factor` times the mean of both spacings lie within this distance, m.
double Scatter::searchRadius(const Site& site, double factor) const {
  const double by_growth = site.h / (1 - factor * SpacingField::steepest_growth / 2);
  return factor * std::min(by_growth, (site.h + spacing_.largest()) / 2);
}

/// Distance to the nearest node in units of the mean of both spacings, or `most` where there is none within
/// that; where it is below the closest approach, which no node may have, any such value. Nodes on a face that looks
/// the other way (the far side of a thin rim) only count within the closest
/// approach.
double Scatter::clearance(const Site& site, double most) const {
  double least = most;
  grid_.forEachWithin(site.X, searchRadius(site, most), [&](int, const Site& other) {
    const double s = 2 * (other.X - site.X).norm() / (site.h + other.h);
    const bool counts = s < closest_approach || site.normal.dot(other.normal) >= 0;
    if (counts) least = std::min(least, s);
    return least >= closest_approach;
  });
  return least;
}

void Scatter::add(const Site& site) {
  grid_.add(site);
  sites_.push_back(site);
}

bool Scatter::addIfFree(const Site& site) {
  const bool free = clearance(site, closest_approach) >= closest_approach;
  if (free) add(site);
  return free;
}

void Scatter::placeCorners(const FeatureEdges& features) {
  for (const Vec3& corner : features.corners) {
    corner_count_ += addIfFree({corner, Vec3::Zero(), spacing_.at(corner)});
  }
}

void Scatter::placeEdges(const FeatureEdges& features) {
  for (const FeatureEdges::Chain& chain : features.chains) {
    // Arc length in units of the local spacing, by the midpoint of pieces well below it.
    std::vector<Vec3> points{chain.points.front()};
    std::vector<double> arc{0.0};
    for (std::size_t k = 1; k < chain.points.size(); ++k) {
      const Vec3 from = chain.points[k - 1], along = chain.points[k] - from;
      const int pieces = std::max(1, static_cast<int>(std::ceil(4 * along.norm() / spacing_.smallest())));
      for (int p = 1; p <= pieces; ++p) {
        const Vec3 middle = from + (p - 0.5) / pieces * along;
        points.push_back(from + static_cast<double>(p) / pieces * along);
        arc.push_back(arc.back() + along.norm() / pieces / spacing_.at(middle));
      }
    }
    const int intervals = std::max(chain.closed ? 3 : 1, static_cast<int>(std::lround(arc.back())));
    std::size_t k = 0;
    for (int n = chain.closed ? 0 : 1; n < intervals; ++n) {
      const double wanted = arc.back() * n / intervals;
      while (arc[k + 1] < wanted) ++k;
      const double part = (wanted - arc[k]) / (arc[k + 1] - arc[k]);
      const Vec3 x = points[k] + part * (points[k + 1] - points[k]);
      edge_count_ += addIfFree({x, Vec3::Zero(), spacing_.at(x)});
    }
  }
}

/// Relaxation dart throwing (McCool and Fiume 1992): candidates in random order land where they have
/// room; the radius that they ask for shrinks until `wanted` have landed.
void Scatter::throwDarts(std::vector<Site> candidates, std::size_t wanted) {
  for (std::size_t k = candidates.size(); k > 1; --k) {
    std::swap(candidates[k - 1], candidates[random_.below(k)]);
  }
  // What was too close to a node stays so: a candidate's last clearance bounds all later ones from above. So those
  // of a batch that have no room already can be told on all cores; the others then land one by one.
  constexpr std::size_t batch = 4096;
  std::vector<double> room(candidates.size(), 1.0);
  std::vector<std::size_t> open;
  std::size_t landed = 0;
  for (double factor = 1.0; factor >= closest_approach; factor *= 0.94) {
    open.clear();
    for (std::size_t k = 0; k < candidates.size(); ++k)
      if (room[k] >= factor) open.push_back(k);
    for (std::size_t begin = 0; begin < open.size(); begin += batch) {
      const std::size_t end = std::min(begin + batch, open.size());
      parallelFor(static_cast<int>(end - begin), [&](int first, int last) {
        for (std::size_t o = begin + first; o < begin + last; ++o) room[open[o]] = clearance(candidates[open[o]], 1.0);
      });
      for (std::size_t o = begin; o < end; ++o) {
        const std::size_t k = open[o];
        if (landed == wanted) return;
        if (room[k] < factor) continue;
        room[k] = clearance(candidates[k], 1.0);
        if (room[k] < factor) continue;
        add(candidates[k]);
        room[k] = 0;
        ++landed;
      }
    }
  }
}

/// Where the nodes around a site push it. A pair's force goes with h^(dimension - 1), as the pressure between fine
/// and coarse parts would otherwise drive the nodes from the fine spacing into the coarse one.
Vec3 Scatter::pushed(const Site& site, int dimension) const {
  Vec3 push = Vec3::Zero();
  grid_.forEachWithin(site.X, searchRadius(site, reach), [&](int, const Site& other) {
    const Vec3 apart = site.X - other.X;
    const double distance = apart.norm();
    const double pair_h = (site.h + other.h) / 2;
    if (distance == 0 || site.normal.dot(other.normal) < 0) return true;
    const double ratio = pair_h / site.h;
    push += (dimension == 3 ? ratio * ratio : ratio) * repulsion(distance / pair_h) / distance * apart;
    return true;
  });
  push -= push.dot(site.normal) * site.normal;
  const double length = relax_step * push.norm();
  return site.X + relax_step * site.h * push * std::min(1.0, longest_move / std::max(length, 1e-300));
}

/// Moves the sites from `begin` on apart; confine(site, old_position) puts each back where it belongs. Progress goes
/// from `told` to `tells`.
template <class Confine>
void Scatter::relax(std::size_t begin, int dimension, double told, double tells, Confine&& confine) {
  std::vector<Vec3> moved(sites_.size());
  for (int iteration = 0; iteration < relax_iterations; ++iteration) {
    tell(told + (tells - told) * iteration / relax_iterations);
    grid_.assign(sites_);
    parallelFor(grid_.size(), [&](int first, int last) {
      for (int place = first; place < last; ++place) {
        const std::size_t i = grid_.indexAt(place);
        if (i >= begin) moved[i] = pushed(sites_[i], dimension);
      }
    });
    parallelFor(static_cast<int>(sites_.size() - begin), [&](int first, int last) {
      for (std::size_t i = begin + first; i < begin + last; ++i) {
        Site& site = sites_[i];
        const Vec3 old = site.X;
        site.X = moved[i];
        confine(site, old);
        site.h = spacing_.at(site.X);
      }
    });
  }

  // Where there was no room (between close sheets), the later node of a conflicting pair goes.
  const std::vector<Site> relaxed = std::move(sites_);
  sites_.clear();
  grid_.clear();
  for (std::size_t i = 0; i < relaxed.size(); ++i) {
    if (i < begin) {
      add(relaxed[i]);
    } else {
      addIfFree(relaxed[i]);
    }
  }
}

/// Random points of the faces, in numbers proportional to area / h^2. `wanted` becomes the number of nodes
/// that an unbounded hexagonal lattice would have on this area.
std::vector<Site> Scatter::faceCandidates(double& wanted) {
  const TriangleSurface& surface = surface_.surface();
  std::vector<Site> candidates;
  wanted = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    const Vec3 &A = surface.vertices[a], &B = surface.vertices[b], &C = surface.vertices[c];
    const Vec3 area = areaVector(surface, static_cast<int>(t));
    const double mean_h = (spacing_.at(A) + spacing_.at(B) + spacing_.at(C) + spacing_.at((A + B + C) / 3)) / 4;
    wanted += area.norm() / (area_per_node * mean_h * mean_h);
    // Rounding the running sum instead of each term keeps small faces represented.
    while (static_cast<double>(candidates.size()) < candidates_per_node * wanted) {
      const double root = std::sqrt(random_.uniform()), v = random_.uniform();
      const Vec3 x = (1 - root) * A + root * (1 - v) * B + root * v * C;
      candidates.push_back({x, area.normalized(), spacing_.at(x)});
    }
  }
  return candidates;
}

void Scatter::placeFaces() {
  const std::size_t begin = sites_.size();
  double wanted = 0;
  std::vector<Site> candidates = faceCandidates(wanted);
  // A node on an edge has half its share of area on either face, one at a cube's corner a quarter on each of
  // three.
  wanted = std::max(0.0, wanted - edge_count_ - 0.75 * corner_count_);
  throwDarts(std::move(candidates), static_cast<std::size_t>(std::lround(wanted)));
  relax(begin, 2, faces_thrown, faces_done, [&](Site& site, const Vec3& old) {
    // The old place is on the surface; the rest is for rounding.
    const double farthest = (1 + 1e-6) * (site.X - old).norm() + 1e-9 * site.h;
    const SurfaceTree::Closest foot = surface_.closest(site.X, farthest);
    if (foot.triangle < 0) {
      site.X = old;
    } else {
      site.X = foot.point;
      site.normal = areaVector(surface_.surface(), foot.triangle).normalized();
    }
  });
  surface_count_ = sites_.size();
}

/// Where air is so narrow that both its sides share their nodes, each node of one gets another straight across: either
/// side is then as dense as anywhere, and cells end at the air. A node on a face goes where that leaves no room.
void Scatter::pairAcrossAir(double widest) {
  constexpr double narrowest = 0.01;                           // in units of h; what is closer has one node
  const Vec3 first_way = Vec3(0.64, 0.57, 0.52).normalized();  // air that looks this way has its nodes first
  std::vector<std::vector<Vec3>> across(surface_count_);
  parallelFor(static_cast<int>(surface_count_), [&](int first, int last) {
    for (int i = first; i < last; ++i)
      across[i] = acrossAir(surface_, sites_[i].X, std::max(widest, closest_approach * sites_[i].h));
  });
  std::vector<char> gone(surface_count_, 0), paired(surface_count_, 0);
  const auto pair = [&](std::size_t i, const Vec3& at) {
    const Site image{at, Vec3::Zero(), spacing_.at(at)};
    const Vec3 x = sites_[i].X, way = at - x;
    std::vector<int> in_the_way;
    bool has_room = way.norm() > narrowest * image.h;
    grid_.forEachWithin(image.X, searchRadius(image, closest_approach), [&](int j, const Site& other) {
      const bool near = (other.X - image.X).norm() < closest_approach * (image.h + other.h) / 2;
      if (gone[j] || !near || (other.X - x).dot(way) < way.squaredNorm() / 2) return true;
      has_room = has_room && !paired[j] && !other.normal.isZero();
      in_the_way.push_back(j);
      return has_room;
    });
    if (!has_room) return;
    for (const int j : in_the_way) gone[j] = 1;
    add(image);
    gone.push_back(0);
    paired.push_back(1);
    paired[i] = 1;
  };
  for (const bool second : {false, true})
    for (std::size_t i = 0; i < surface_count_; ++i)
      for (const Vec3& at : across[i])
        if (!gone[i] && second != ((at - sites_[i].X).dot(first_way) > 0)) pair(i, at);
  if (sites_.size() == surface_count_) return;
  const std::vector<Site> all = std::move(sites_);
  sites_.clear();
  grid_.clear();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!gone[i]) add(all[i]);
  surface_count_ = sites_.size();
}

/// Looks where a cube lies: outside, to be divided, or a leaf.
void Scatter::judge(Cube& cube) const {
  // Edge of a smallest cube, in units of h.
  const double leaf = std::cbrt(volume_per_node / candidates_per_node);
  const double radius = cube.edge * std::sqrt(3.0) / 2;  // of the sphere around the cube
  cube.h = spacing_.at(cube.centre);
  if (!cube.deep) {
    // The surface does not pass between two points closer than one of them is to it.
    const bool same_side = std::abs(cube.depth) > radius;
    const bool inside = same_side ? cube.depth > 0 : surface_.inside(cube.centre);
    // The surface is no farther than the parent's foot on it; the rest is for rounding.
    const double farthest = (1 + 1e-9) * (cube.foot - cube.centre).norm() + 1e-9 * cube.edge;
    const SurfaceTree::Closest foot = surface_.closest(cube.centre, farthest);
    cube.foot = foot.point;
    cube.depth = foot.distance * (inside ? 1 : -1);
    if (cube.depth < -radius) {
      cube.kind = Cube::Kind::Outside;
      return;
    }
    cube.deep = cube.depth - radius > cube.h + SpacingField::steepest_growth * radius;
  }
  const double smallest_h = std::max(spacing_.smallest(), cube.h - SpacingField::steepest_growth * radius);
  const bool divide = cube.edge > leaf * cube.h && cube.edge > leaf * smallest_h;
  cube.kind = divide ? Cube::Kind::Divided : Cube::Kind::Leaf;
}

/// The leaves of an octree over the body, those outside left out, in the order of a depth-first search.
std::vector<Cube> Scatter::leaves() const {
  const Box3 box = padded(boundingBox(surface_.surface()));
  const Vec3 middle = box.center();
  std::vector<Cube> cubes{{middle, box.sizes().maxCoeff(), -surface_.signedDistance(middle),
                           surface_.closest(middle).point, 0, false, Cube::Kind::Open}};
  for (bool open = true; open;) {
    parallelFor(static_cast<int>(cubes.size()), [&](int first, int last) {
      for (int k = first; k < last; ++k)
        if (cubes[k].kind == Cube::Kind::Open) judge(cubes[k]);
    });
    open = false;
    std::vector<Cube> next;
    for (const Cube& cube : cubes) {
      if (cube.kind == Cube::Kind::Leaf) next.push_back(cube);
      if (cube.kind != Cube::Kind::Divided) continue;
      open = true;
      for (int octant = 7; octant >= 0; --octant) {
        const Vec3 side((octant & 1) - 0.5, ((octant >> 1) & 1) - 0.5, (octant >> 2) - 0.5);
        next.push_back(
            {cube.centre + side * cube.edge / 2, cube.edge / 2, cube.depth, cube.foot, 0, cube.deep, Cube::Kind::Open});
      }
    }
    cubes = std::move(next);
  }
  return cubes;
}

/// One random point in each cube of an octree that is deep enough inside. `wanted` becomes the number of
/// nodes of a close packing in the part of the body that surface nodes don't fill.
std::vector<Site> Scatter::insideCandidates(double& wanted) {
  // First layer of a close packing above a plane of nodes: sqrt(2/3) h; half of it belongs to the plane.
  constexpr double surface_share = 0.408;
  const std::vector<Cube> cubes = leaves();
  std::vector<Site> sites;
  wanted = 0;
  for (const Cube& cube : cubes) {
    if (cube.deep || cube.depth > surface_share * cube.h) wanted += std::pow(cube.edge / cube.h, 3) / volume_per_node;
    const Vec3 jitter(random_.uniform() - 0.5, random_.uniform() - 0.5, random_.uniform() - 0.5);
    const Vec3 x = cube.centre + cube.edge * jitter;
    sites.push_back({x, Vec3::Zero(), spacing_.at(x)});
  }
  std::vector<char> inside(cubes.size(), 0);
  parallelFor(static_cast<int>(cubes.size()), [&](int first, int last) {
    for (int k = first; k < last; ++k) {
      const Cube& cube = cubes[k];
      const double moved = (sites[k].X - cube.centre).norm(), least = min_depth * sites[k].h;
      inside[k] = cube.deep || cube.depth - moved > least ||
                  (cube.depth + moved > least && -surface_.signedDistance(sites[k].X) > least);
    }
  });
  std::vector<Site> candidates;
  for (std::size_t k = 0; k < sites.size(); ++k)
    if (inside[k]) candidates.push_back(sites[k]);
  return candidates;
}

void Scatter::placeInside() {
  const std::size_t begin = sites_.size();
  double wanted = 0;
  tell(faces_done);
  std::vector<Site> candidates = insideCandidates(wanted);
  tell(inside_found);
  throwDarts(std::move(candidates), static_cast<std::size_t>(std::lround(wanted)));
  std::vector<double> room(sites_.size(), 0.0);  // at least this far from the surface, m
  relax(begin, 3, inside_thrown, 1, [&](Site& site, const Vec3& old) {
    double& distance = room[&site - sites_.data()];
    const double depth = min_depth * site.h;
    distance -= (site.X - old).norm();
    if (distance > depth) return;
    const SurfaceTree::Closest foot = surface_.closest(site.X, 2 * site.h);
    distance = std::min(foot.distance, 2 * site.h);
    if (distance > depth) return;
    // Old was deeper than the longest move, so the site can't have crossed the surface.
    site.X = distance > 0 ? Vec3(foot.point + depth / distance * (site.X - foot.point)) : old;
    distance = 0;
  });
}

}  // namespace palpate
