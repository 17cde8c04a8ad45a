#include "discretization/gradients/boundary_points.h"

#include <algorithm>

#include "discretization/surface/facet_rule.h"

namespace palpate {

BoundaryPoints boundaryPoints(const std::vector<Vec3>& X, const std::vector<std::array<int, 3>>& facets,
                              const std::vector<std::uint8_t>& imposed) {
  BoundaryPoints samples;
  std::vector<Vec3> node_area(X.size(), Vec3::Zero());
  std::vector<char> sampled(X.size(), 0);
  for (const auto& f : facets) {
    const Vec3 area = (X[f[1]] - X[f[0]]).cross(X[f[2]] - X[f[0]]) / 2;
    if (std::all_of(f.begin(), f.end(), [&](int i) { return imposed[i] != 0; })) {
      for (const int i : f) {
        node_area[i] += area / 3;
        sampled[i] = 1;
      }
      continue;
    }
    for (int k = 0; k < FacetRule::size; ++k) {
      samples.X.push_back(FacetRule::point(k, X[f[0]], X[f[1]], X[f[2]]));
      samples.area.push_back(FacetRule::weight(k) * area);
    }
  }
  for (std::size_t i = 0; i < X.size(); ++i) {
    if (!sampled[i]) continue;
    samples.X.push_back(X[i]);
    samples.area.push_back(node_area[i]);
  }
  return samples;
}

}  // namespace palpate
