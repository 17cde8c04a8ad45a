#pragma once

#include <vector>

#include "app/render/colour_map.h"
#include "base/types.h"
#include "model/body.h"

namespace palpate::app {

using Displacements = AlignedVector<Float4>;

/// Where evaluation points stand under u, m: X_r + sum_i N_i(X_r) u_i.  (row_count)
/// @param rows  begin, node and N of each: a ShapeTable or a SkinModel
template <class Rows>
std::vector<Vec3f> deformed(const std::vector<Vec3>& X, const Rows& rows, const Displacements& u) {
  std::vector<Vec3f> x(X.size());
  for (std::size_t r = 0; r < X.size(); ++r) {
    Vec3 sum = X[r];
    if (!u.empty())
      for (int k = rows.begin[r]; k < rows.begin[r + 1]; ++k) sum += rows.N[k] * toVec3(u[rows.node[k]]);
    // A state that blew up is still drawn, at rest, so that what went wrong can be read on the screen.
    x[r] = (sum.allFinite() ? sum : X[r]).template cast<float>();
  }
  return x;
}

/// von Mises stress (Pa) or J at the integration points, from F = I + sum_i u_i (x) gradN_i
/// (X of paper eqs. 9, 31).  (point_count)
/// Of a material that relaxes the stress of its law: what has relaxed is the simulation's.
/// @param materials  the present ones where they were changed live (Snapshot::materials); empty: the model's
std::vector<float> pointValues(const Body& model, const Displacements& u, ColourMap map,
                               const std::vector<Material>& materials = {});

/// Averages over the integration points around each node, weighted by volume and by the
/// positive part of the node's shape function: a convex mean, so that no average leaves the
/// range of the values. NaN for a node that no integration point sees.  (node_count)
std::vector<float> nodeAverages(const Body& model, const std::vector<float>& point_values);

/// Values at the skin's vertices from the nodes', likewise convex; NaN nodes don't count.
/// (skin vertex_count)
std::vector<float> skinAverages(const Body& model, const std::vector<float>& node_values);

/// The field that `map` shows, at the skin's vertices: m, Pa or 1; zeros for Tissue.
/// @param x  the skin's vertices under u, m
/// @param materials  as for pointValues
std::vector<float> skinValues(const Body& model, const Displacements& u, const std::vector<Vec3f>& x, ColourMap map,
                              const std::vector<Material>& materials = {});

/// The range that shows these values well: from 0 to the largest, or for J evenly about 1;
/// never narrower than what is worth showing (0.1 mm, 10 Pa, 0.01; 1 kPa of peak pressure).
ColourScale automaticScale(const std::vector<float>& values, ColourMap map);

}  // namespace palpate::app
