#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "approximation/shape_table.h"
#include "base/types.h"

namespace palpate {

/// Where a boundary integral is sampled: int g n dS is about sum_k g(X_k) area_k.
struct BoundaryPoints {
  std::vector<Vec3> X;        // (sample_count) m
  std::vector<Vec3> area;     // (sample_count) weight times area times outward normal, m^2
  std::vector<int> node;      // (sample_count) the node that it is at, where a traction is lumped; or -1
  std::vector<int> face;      // (sample_count) of held faces: their number; or -1
  std::vector<Vec3> of_held;  // (sample_count) what area would be by 6 points a facet, on held faces; else 0

  void add(const Vec3& at, const Vec3& its_area, int its_node = -1);
  /// Samples begin .. end - 1 of another.
  void append(const BoundaryPoints& other, std::size_t begin, std::size_t end);
};

/// Samples of the cells' outer faces. The rule of each face is one whose integral the tractions there can balance:
///
///   facets whose three nodes are imposed  the nodes, a third of the area to each (balanceNodes mends that on held
///                                         faces): tractions of SEBCIEM act at nodes (paper eqs. 18-20), and a uniform
///                                         stress is in equilibrium with them only where the integral is such a sum
///   all others                            Dunavant's 6 points, exact for polynomials of degree 4
///
/// The nodes' rule everywhere costs accuracy: it misses how sharply N changes along the surface, and that error goes
/// into the gradients. Box in extension, 1,102 nodes, R/h 2, mu 0.05, node patches, three or four clouds: force
/// +4.5 .. +4.8 % with the nodes' rule everywhere, +1.1 .. +1.3 % with this one; 6 points everywhere give
/// +0.7 .. +0.9 %, but need tractions that are integrated as well: the cube's error is then 2e-3, not rounding.
///
/// Held faces are those of facets that share edges and lie less than 60 degrees aslant, with nodes imposed in each
/// component that the facet faces (in all of them where the skin bears loads, which act on thirds along a face).
///
/// @param X        nodes, m                                                    (node_count)
/// @param facets   outward, counter-clockwise (background_cells.h)
/// @param imposed  bits of the components in which a node is imposed           (node_count)
/// @param loaded   the skin bears loads
/// Facets' samples come in their order, then the nodes' in ascending order, face by face.
/// Test: discretization/gradients/consistent_gradients_test.cpp
BoundaryPoints boundaryPoints(const std::vector<Vec3>& X, const std::vector<std::array<int, 3>>& facets,
                              const std::vector<std::uint8_t>& imposed, bool loaded = false);

/// Gives the nodes of held faces areas that integrate the shape functions as 6 points a facet do. A third of the area
/// to each is the trapezoidal rule: it overrates second moments by 2 / n^2 over n spacings, and with gradients made to
/// it what is bent or twisted by its faces is 2.5 % too stiff where it is 1 % off with these. For each held face
///
///   min sum_i |sum_k N_i(X_k) a_k - int N_i n dS|^2  with  sum_k a_k = int n dS,  sum_k X_k (x) a_k = int X (x) n dS
///
/// @param at_boundary  N at the samples, one row each
/// Test: discretization/gradients/consistent_gradients_test.cpp
void balanceNodes(BoundaryPoints& boundary, const ShapeTable& at_boundary);

}  // namespace palpate
