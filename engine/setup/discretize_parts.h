#pragma once

#include "discretization/surface/feature_edges.h"
#include "setup/discretize.h"

namespace palpate {

/// What `discretize` is made of, for clouds of which parts are used (place.h).
///
///   discretize = discretizeOnSurface, fitVolumes, putInSlices

/// Nodes that the fine cloud of places may have: 45,000 take 12 s, once.
inline constexpr double most_fine_nodes = 100000, most_nodes = 60000;

/// The spacing with which a body has about so many nodes, m. @param volume, area  m^3, m^2, of which a sheet has more
double finestSpacing(double volume, double area, double nodes);

/// The spacing that a scene asks for.
SpacingField spacingField(const Scene& scene);

/// Nodes and cells before the volume is fitted: surface nodes are on the surface. @throws as discretize
/// @param paired_air  makeNodeCloud's
Discretization discretizeOnSurface(const Scene& scene, const SurfaceTree& organ,
                                   const std::function<void(double)>& progress, double paired_air = 0);

/// Moves nodes so that cells enclose the organ's volume (volume_fit.h) and, where materials meet, each its own
/// (interface_nodes.h).
/// @param memory  of the organ's surface, or null
void fitVolumes(const Scene& scene, const SurfaceTree& organ, Discretization& discretization,
                SurfaceMemory* memory = nullptr);

/// The lines that its nodes follow: the organ's sharp edges, and rims of imposed cylindrical regions.
FeatureEdges featuresOf(const Scene& scene, const SurfaceTree& organ);

/// Nodes in slicedOrder; the cells go with them.
void putInSlices(Discretization& discretization);

}  // namespace palpate
