#pragma once

#include "discretization/surface/feature_edges.h"
#include "simulation/discretize.h"

namespace palpate {

/// What `discretize` is made of, for clouds of which parts are used (place.h).
///
///   discretize = discretizeOnSurface, fitToVolume (volume_fit.h), putInSlices

/// The spacing that a scene asks for.
SpacingField spacingField(const Scene& scene);

/// Nodes and cells before the volume is fitted: surface nodes are on the surface. @throws as discretize
Discretization discretizeOnSurface(const Scene& scene, const SurfaceTree& organ,
                                   const std::function<void(double)>& progress);

/// The lines that its nodes follow: the organ's sharp edges, and rims of imposed cylindrical regions.
FeatureEdges featuresOf(const Scene& scene, const SurfaceTree& organ);

/// Nodes in slicedOrder; the cells go with them.
void putInSlices(Discretization& discretization);

}  // namespace palpate
