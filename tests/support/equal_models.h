#pragma once

#include <catch2/catch.hpp>
#include <cstring>

#include "setup/build_model.h"

namespace palpate::test {

/// Requires that two lists of plain values have the same bits.
template <class List>
void requireSameBits(const char* what, const List& a, const List& b) {
  INFO(what);
  REQUIRE(a.size() == b.size());
  if (!a.empty()) REQUIRE(std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
}

inline void requireSameBits(const char* what, const ShapeTable& a, const ShapeTable& b) {
  requireSameBits(what, a.begin, b.begin);
  requireSameBits(what, a.node, b.node);
  requireSameBits(what, a.N, b.N);
  requireSameBits(what, a.gradN, b.gradN);
}

/// Requires that every array and number of two models has the same bits, but for the time that they took.
inline void requireSameModel(const Model& a, const Model& b) {
  requireSameBits("X", a.X, b.X);
  requireSameBits("support_radius", a.support_radius, b.support_radius);
  requireSameBits("imposed", a.imposed, b.imposed);
  requireSameBits("cells", a.cells, b.cells);
  requireSameBits("point_X", a.point_X, b.point_X);
  requireSameBits("point_volume", a.point_volume, b.point_volume);
  requireSameBits("point_material", a.point_material, b.point_material);
  requireSameBits("point_cell", a.point_cell, b.point_cell);
  requireSameBits("point_other_cell", a.point_other_cell, b.point_other_cell);
  requireSameBits("point_shape", a.point_shape, b.point_shape);
  requireSameBits("node_shape", a.node_shape, b.node_shape);
  requireSameBits("mass", a.mass, b.mass);
  requireSameBits("own_mass", a.own_mass, b.own_mass);
  requireSameBits("inverse_mass", a.inverse_mass, b.inverse_mass);
  requireSameBits("patch nodes", a.patches.node, b.patches.node);
  requireSameBits("patch weights", a.patches.weight, b.patches.weight);
  requireSameBits("patch volumes", a.patches.volume, b.patches.volume);
  requireSameBits("patch moduli", a.patches.bulk_modulus, b.patches.bulk_modulus);
  requireSameBits("kernel nodes", a.kernel.node, b.kernel.node);
  requireSameBits("kernel gradients", a.kernel.gradN, b.kernel.gradN);
  requireSameBits("kernel volumes", a.kernel.volume, b.kernel.volume);
  requireSameBits("kernel points", a.kernel.point, b.kernel.point);
  requireSameBits("essential nodes", a.essential.nodes, b.essential.nodes);
  requireSameBits("essential X", a.essential.X, b.essential.X);
  requireSameBits("essential phi", a.essential.phi, b.essential.phi);
  requireSameBits("facets", a.essential.facets, b.essential.facets);
  requireSameBits("facet weights", a.essential.facet_weight, b.essential.facet_weight);
  requireSameBits("facet phi", a.essential.facet_phi, b.essential.facet_phi);
  REQUIRE(a.essential.facet_points == b.essential.facet_points);
  REQUIRE(a.essential.motions.size() == b.essential.motions.size());
  REQUIRE(a.boundary.sets.size() == b.boundary.sets.size());
  for (std::size_t s = 0; s < a.boundary.sets.size(); ++s) {
    requireSameBits("boundary phi", a.boundary.sets[s].phi.value, b.boundary.sets[s].phi.value);
    requireSameBits("boundary u", a.boundary.sets[s].u.value, b.boundary.sets[s].u.value);
    requireSameBits("boundary pivots", a.boundary.sets[s].inverse_pivot, b.boundary.sets[s].inverse_pivot);
  }
  requireSameBits("skin vertices", a.skin.surface.vertices, b.skin.surface.vertices);
  requireSameBits("skin triangles", a.skin.surface.triangles, b.skin.surface.triangles);
  requireSameBits("skin rows", a.skin.begin, b.skin.begin);
  requireSameBits("skin nodes", a.skin.node, b.skin.node);
  requireSameBits("skin N", a.skin.N, b.skin.N);
  requireSameBits("skin clusters", a.skin.cluster_vertex, b.skin.cluster_vertex);
  const auto numbers = [](const Model& m) {
    return std::vector<double>{m.surface_volume,
                               m.layer_error,
                               static_cast<double>(m.thin_layer),
                               m.cell_volume,
                               m.tools.first().first_contact_travel,
                               m.dt,
                               m.dt_critical,
                               m.dt_proven,
                               static_cast<double>(m.substeps_per_tick),
                               m.max_increment,
                               m.tools.tool[0].max_force,
                               m.skin.layer_depth};
  };
  requireSameBits("numbers", numbers(a), numbers(b));
}

}  // namespace palpate::test
