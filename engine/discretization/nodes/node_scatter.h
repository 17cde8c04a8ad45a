#pragma once

#include <functional>
#include <random>
#include <vector>

#include "base/types.h"
#include "discretization/nodes/site_grid.h"
#include "discretization/nodes/spacing_field.h"
#include "discretization/surface/feature_edges.h"
#include "discretization/surface/surface_tree.h"

namespace palpate {

/// Random numbers that are the same bits with every standard library.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform() { return (engine_() + 0.5) / 4294967296.0; }  // in (0, 1)
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(uniform() * static_cast<double>(n)); }

 private:
  std::mt19937 engine_;
};

/// No two nodes come closer than this, in units of h.
constexpr double closest_approach = 0.5;
/// Inner nodes stay this far below the surface, in units of h (0.5 is promised; the rest is reserve).
constexpr double min_depth = 0.55;
/// Area of surface per node, in units of h^2: the hexagonal lattice of edge h (sqrt(3)/2).
constexpr double area_per_node = 0.866;
/// Volume per inner node, in units of h^3: the face-centred lattice of edge h (1/sqrt(2)).
constexpr double volume_per_node = 0.7;

/// A cube of space in the search for the body's inside.
struct Cube {
  enum class Kind { Open, Outside, Divided, Leaf };
  Vec3 centre = Vec3::Zero();
  double edge = 0;           // m
  double depth = 0;          // m below the surface at the centre, negative outside; the parent's until computed
  Vec3 foot = Vec3::Zero();  // point of the surface closest to the centre; the parent's until computed
  double h = 0;              // m, the spacing wanted at the centre
  bool deep = false;         // known to lie inside, deeper than any node must
  Kind kind = Kind::Open;
};

/// Nodes placed so far, in a grid for neighbour searches.
class Scatter {
 public:
  /// @param progress  called with the share that is done, 0..1; may throw
  Scatter(const SurfaceTree& surface, const SpacingField& spacing, unsigned seed,
          std::function<void(double)> progress = {});

  /// The five stages, in this order.
  void placeCorners(const FeatureEdges& features);
  void placeEdges(const FeatureEdges& features);
  void placeFaces();
  /// @param widest  m; air narrower than the closest approach has pairs in any case
  void pairAcrossAir(double widest);
  void placeInside();

  const std::vector<Site>& sites() const { return sites_; }
  std::size_t surfaceCount() const { return surface_count_; }

 private:
  double searchRadius(const Site& site, double factor) const;
  double clearance(const Site& site, double most) const;
  void tell(double share) const {
    if (progress_) progress_(share);
  }
  void add(const Site& site);
  bool addIfFree(const Site& site);
  void throwDarts(std::vector<Site> candidates, std::size_t wanted);
  std::vector<Site> faceCandidates(double& wanted);
  void judge(Cube& cube) const;
  std::vector<Cube> leaves() const;
  std::vector<Site> insideCandidates(double& wanted);
  Vec3 pushed(const Site& site, int dimension) const;
  template <class Confine>
  void relax(std::size_t begin, int dimension, double told, double tells, Confine&& confine);

  const SurfaceTree& surface_;
  const SpacingField& spacing_;
  std::function<void(double)> progress_;
  Random random_;
  SiteGrid grid_;  // of sites_
  std::vector<Site> sites_;
  double corner_count_ = 0, edge_count_ = 0;
  std::size_t surface_count_ = 0;
};

}  // namespace palpate
