#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/types.h"

namespace palpate {

/// Where a boundary integral is sampled: int g n dS is about sum_k g(X_k) area_k.
struct BoundaryPoints {
  std::vector<Vec3> X;     // (sample_count) m
  std::vector<Vec3> area;  // (sample_count) weight times area times outward normal, m^2
};

/// Samples of the cells' outer faces. The rule of each face is one whose integral the tractions there can balance:
///
///   facets whose three nodes are imposed  the nodes, a third of the area to each: tractions of SEBCIEM act at
///                                         nodes (paper eqs. 18-20), and a uniform stress is in equilibrium with
///                                         them only where the integral is such a sum
///   all others                            Dunavant's 6 points, exact for polynomials of degree 4
///
/// The nodes' rule everywhere costs accuracy: it misses how sharply N changes along the surface, and that error goes
/// into the gradients. Box in extension, 1,102 nodes, R/h 2, mu 0.05, node patches, three or four clouds: force
/// +4.5 .. +4.8 % with the nodes' rule everywhere, +1.1 .. +1.3 % with this one; 6 points everywhere give
/// +0.7 .. +0.9 %, but need tractions that are integrated as well: the cube's error is then 2e-3, not rounding.
///
/// @param X        nodes, m                                                    (node_count)
/// @param facets   outward, counter-clockwise (background_cells.h)
/// @param imposed  not 0 where a component of the node is imposed              (node_count)
/// Facets' samples come in their order, then the nodes' in ascending order.
/// Test: discretization/gradients/consistent_gradients_test.cpp
BoundaryPoints boundaryPoints(const std::vector<Vec3>& X, const std::vector<std::array<int, 3>>& facets,
                              const std::vector<std::uint8_t>& imposed);

}  // namespace palpate
