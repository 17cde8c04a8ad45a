#include "discretization/cells/background_cells.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "base/input_error.h"
#include "base/parallel_for.h"
#include "discretization/cells/delaunay.h"
#include "discretization/surface/surface_gaps.h"
#include "discretization/surface/surface_geometry.h"

namespace palpate {
namespace {

/// Cells with less volume than this times the cube of their longest edge (a regular one has 0.118) are
/// slivers.
constexpr double sliver = 1e-3;

double longestEdge(const std::vector<Vec3>& X, const std::array<int, 4>& cell) {
  double longest = 0;
  for (int i : cell) {
    for (int j : cell) longest = std::max(longest, (X[i] - X[j]).norm());
  }
  return longest;
}

/// Barycentric samples: the centre, and rings drawn to the corners, edges and faces.
std::array<Eigen::Vector4d, 15> insideSamples() {
  std::array<Eigen::Vector4d, 15> samples;
  int n = 0;
  samples[n++] = Eigen::Vector4d::Constant(0.25);
  for (int k = 0; k < 4; ++k) {
    samples[n] = Eigen::Vector4d::Constant(0.1);
    samples[n++][k] = 0.7;
    samples[n] = Eigen::Vector4d::Constant(0.3);
    samples[n++][k] = 0.1;
    for (int l = 0; l < k; ++l) {
      samples[n] = Eigen::Vector4d::Constant(0.1);
      samples[n][k] = samples[n][l] = 0.4;
      ++n;
    }
  }
  return samples;
}

class InsideTest {
 public:
  /// For these cells.
  InsideTest(const NodeCloud& cloud, const std::vector<std::array<int, 4>>& cells, const SurfaceTree& surface)
      : X_(cloud.X), surface_(surface), depth_(cloud.X.size(), 0.0) {
    std::vector<double> longest(X_.size(), 0.0);  // edge of the cells at each node, m
    for (const std::array<int, 4>& cell : cells)
      for (int i : cell) longest[i] = std::max(longest[i], longestEdgeAt(i, cell));
    parallelFor(static_cast<int>(X_.size()), [&](int first, int last) {
      for (int i = first; i < last; ++i) {
        if (cloud.on_surface[i] || longest[i] == 0) continue;
        const SurfaceTree::Closest foot = surface.closest(X_[i], longest[i]);
        depth_[i] = foot.triangle < 0 ? std::numeric_limits<double>::infinity() : foot.distance;
      }
    });
  }

  /// True if at least half of the cell's samples lie inside the body.
  bool holds(const std::array<int, 4>& cell) const {
    // The ball around an inner node that does not reach the surface lies inside the body.
    for (int i : cell)
      if (longestEdgeAt(i, cell) < depth_[i]) return true;
    // So do the samples in such a ball around the centre, or all outside.
    std::array<Vec3, 15> x;
    for (std::size_t n = 0; n < x.size(); ++n) {
      x[n] = Vec3::Zero();
      for (int k = 0; k < 4; ++k) x[n] += samples_[n][k] * X_[cell[k]];
    }
    const double above = surface_.signedDistance(x[0]);
    constexpr int majority = 8;
    int inside = 0, outside = 0;
    const auto near = [&](const Vec3& sample) { return (sample - x[0]).norm() < std::abs(above); };
    for (const Vec3& sample : x)
      if (near(sample)) ++(above < 0 ? inside : outside);
    for (const Vec3& sample : x) {
      if (inside >= majority || outside >= majority) break;
      if (!near(sample)) ++(surface_.inside(sample) ? inside : outside);
    }
    return inside >= majority;
  }

 private:
  double longestEdgeAt(int i, const std::array<int, 4>& cell) const {
    double longest = 0;
    for (int j : cell) longest = std::max(longest, (X_[i] - X_[j]).norm());
    return longest;
  }

  const std::vector<Vec3>& X_;
  const SurfaceTree& surface_;
  std::vector<double> depth_;  // (node_count) m below the surface; 0 on it, infinite where no cell's edge gets there
  std::array<Eigen::Vector4d, 15> samples_ = insideSamples();
};

/// Whether each cell lies inside.
std::vector<char> heldCells(const NodeCloud& cloud, const std::vector<std::array<int, 4>>& cells,
                            const SurfaceTree& surface, SurfaceMemory* memory) {
  const auto places = [&](const std::array<int, 4>& cell) {
    const auto& [a, b, c, d] = cell;
    return std::array{cloud.X[a], cloud.X[b], cloud.X[c], cloud.X[d]};
  };
  std::vector<char> held(cells.size(), 0);
  std::vector<int> unknown;
  std::vector<std::array<int, 4>> asked;
  for (int c = 0; c < static_cast<int>(cells.size()); ++c) {
    if (const bool* const known = memory ? memory->holds.find(places(cells[c])) : nullptr) {
      held[c] = *known;
      continue;
    }
    unknown.push_back(c);
    asked.push_back(cells[c]);
  }
  const InsideTest inside(cloud, asked, surface);
  parallelFor(static_cast<int>(asked.size()), [&](int first, int last) {
    for (int k = first; k < last; ++k) held[unknown[k]] = inside.holds(asked[k]);
  });
  for (std::size_t c = 0; memory && c < cells.size(); ++c) memory->holds.keep(places(cells[c]), held[c] != 0);
  return held;
}

double cellVolume(const std::vector<Vec3>& X, const std::array<int, 4>& cell) {
  return tetrahedronVolume(X[cell[0]], X[cell[1]], X[cell[2]], X[cell[3]]);
}

/// Drops slivers from the outside inward, so that no hole is left behind: cells of four surface nodes
/// with a face on the boundary. (Slivers inside are few and stay.)
void peelSlivers(std::vector<std::array<int, 4>>& cells, const NodeCloud& cloud) {
  const auto isSliver = [&](const std::array<int, 4>& cell) {
    const double longest = longestEdge(cloud.X, cell);
    return std::all_of(cell.begin(), cell.end(), [&](int i) { return cloud.on_surface[i] != 0; }) &&
           cellVolume(cloud.X, cell) < sliver * longest * longest * longest;
  };
  for (std::size_t last = 0; last != cells.size();) {
    last = cells.size();
    std::vector<std::array<int, 3>> boundary = boundaryFacets(cells);
    for (std::array<int, 3>& facet : boundary) std::sort(facet.begin(), facet.end());
    std::sort(boundary.begin(), boundary.end());
    const auto onBoundary = [&](std::array<int, 4> cell) {
      std::sort(cell.begin(), cell.end());
      const auto& [a, b, c, d] = cell;
      const std::array<std::array<int, 3>, 4> facets = {{{a, b, c}, {a, b, d}, {a, c, d}, {b, c, d}}};
      return std::any_of(facets.begin(), facets.end(), [&](const auto& facet) {
        return std::binary_search(boundary.begin(), boundary.end(), facet);
      });
    };
    std::erase_if(cells, [&](const auto& cell) { return isSliver(cell) && onBoundary(cell); });
  }
}

/// Drops cells with an edge across narrow air: they join what does not hold together, and no support carries what of
/// them is in the air. (`narrow` 0.4 or 1 and `outside` 0.2 leave slits and flaps of 1 mm the same cells.)
void dropAcrossAir(std::vector<std::array<int, 4>>& cells, const NodeCloud& cloud, const SurfaceTree& surface) {
  constexpr double narrow = 0.7;    // of the mean edge of the cells at a node
  constexpr double outside = 0.05;  // of the air's width, from the skin: an edge at the end of the air lies in the skin
  const std::vector<Vec3>& X = cloud.X;
  std::vector<double> length(X.size(), 0.0);
  std::vector<int> count(X.size(), 0);
  for (const auto& cell : cells)
    for (const int i : cell) {
      for (const int j : cell) length[i] += (X[j] - X[i]).norm();
      count[i] += 3;
    }
  std::vector<std::vector<Vec3>> air(X.size());  // ways across it, m
  parallelFor(static_cast<int>(X.size()), [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      if (!cloud.on_surface[i] || count[i] == 0) continue;
      air[i] = acrossAir(surface, X[i], narrow * length[i] / count[i]);
      for (Vec3& way : air[i]) way -= X[i];
    }
  });
  const auto crosses = [&](int i, int j) {
    const Vec3 edge = X[j] - X[i];
    return std::any_of(air[i].begin(), air[i].end(), [&](const Vec3& way) {
      const double along = edge.dot(way) / way.squaredNorm();
      return along > 0.5 && surface.signedDistance(X[i] + 0.5 / along * edge) > outside * way.norm();
    });
  };
  std::erase_if(cells, [&](const std::array<int, 4>& cell) {
    return std::any_of(cell.begin(), cell.end(), [&](int i) {
      return std::any_of(cell.begin(), cell.end(), [&](int j) { return i != j && crosses(i, j); });
    });
  });
}

}  // namespace

BackgroundCells makeBackgroundCells(const NodeCloud& cloud, const SurfaceTree& surface, SurfaceMemory* memory) {
  std::vector<std::array<int, 4>> all;
  try {
    all = delaunay(cloud.X);
  } catch (const std::runtime_error& error) {
    throw InputError({}, std::string("the nodes can't be joined to cells (") + error.what() + ")",
                     "use a smaller node spacing");
  }

  BackgroundCells result;
  const std::vector<char> held = heldCells(cloud, all, surface, memory);
  for (std::size_t c = 0; c < all.size(); ++c)
    if (held[c]) result.cells.push_back(all[c]);
  dropAcrossAir(result.cells, cloud, surface);
  peelSlivers(result.cells, cloud);
  result.surface_volume = signedVolume(surface.surface());
  updateVolumes(result, cloud.X);
  return result;
}

namespace {

struct Facet {
  std::array<int, 3> sorted, outward;
  int cell;
};

/// All cells' facets, those of the same nodes after one another.
std::vector<Facet> sortedFacets(const std::vector<std::array<int, 4>>& cells) {
  // By their lowest node first: many short sorts are faster than a long one.
  int nodes = 0;
  for (const auto& cell : cells) nodes = std::max(nodes, 1 + *std::max_element(cell.begin(), cell.end()));
  const auto forEachFacet = [&](auto&& visit) {
    for (int k = 0; k < static_cast<int>(cells.size()); ++k) {
      const auto& [a, b, c, d] = cells[k];
      for (const std::array<int, 3>& outward : {std::array{b, c, d}, {a, d, c}, {a, b, d}, {a, c, b}}) {
        std::array<int, 3> sorted = outward;
        std::sort(sorted.begin(), sorted.end());
        visit(Facet{sorted, outward, k});
      }
    }
  };
  std::vector<int> of_node(static_cast<std::size_t>(nodes) + 1, 0);
  forEachFacet([&](const Facet& f) { ++of_node[f.sorted[0] + 1]; });
  for (int i = 0; i < nodes; ++i) of_node[i + 1] += of_node[i];
  std::vector<Facet> facets(4 * cells.size());
  std::vector<int> next(of_node.begin(), of_node.end());
  forEachFacet([&](const Facet& f) { facets[next[f.sorted[0]]++] = f; });
  parallelFor(nodes, [&](int first, int last) {
    for (int i = first; i < last; ++i)
      std::sort(facets.begin() + of_node[i], facets.begin() + of_node[i + 1],
                [](const Facet& p, const Facet& q) { return std::tie(p.sorted, p.cell) < std::tie(q.sorted, q.cell); });
  });
  return facets;
}

/// Calls visit(first, count) for the facets of the same nodes: one on the boundary, two between cells.
template <class Visit>
void forEachPlace(const std::vector<Facet>& facets, Visit visit) {
  for (std::size_t begin = 0, end = 0; begin < facets.size(); begin = end) {
    while (end < facets.size() && facets[end].sorted == facets[begin].sorted) ++end;
    visit(&facets[begin], end - begin);
  }
}

}  // namespace

std::vector<std::array<int, 3>> boundaryFacets(const std::vector<std::array<int, 4>>& cells) {
  std::vector<std::array<int, 3>> boundary;
  forEachPlace(sortedFacets(cells), [&](const Facet* facet, std::size_t count) {
    if (count == 1) boundary.push_back(facet->outward);
  });
  return boundary;
}

std::vector<std::array<int, 2>> neighbouringCells(const std::vector<std::array<int, 4>>& cells) {
  std::vector<std::array<int, 2>> neighbours;
  forEachPlace(sortedFacets(cells), [&](const Facet* facet, std::size_t count) {
    if (count == 2) neighbours.push_back({facet[0].cell, facet[1].cell});
  });
  return neighbours;
}

std::vector<Vec3> centroids(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells) {
  std::vector<Vec3> centroid;
  centroid.reserve(cells.size());
  for (const auto& [a, b, c, d] : cells) centroid.push_back((X[a] + X[b] + X[c] + X[d]) / 4);
  return centroid;
}

void updateVolumes(BackgroundCells& cells, const std::vector<Vec3>& X) {
  cells.volume.clear();
  cells.total_volume = 0;
  for (const std::array<int, 4>& cell : cells.cells) {
    cells.volume.push_back(cellVolume(X, cell));
    cells.total_volume += cells.volume.back();
  }
}

}  // namespace palpate
