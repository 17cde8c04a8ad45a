#include "discretization/background_cells.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "base/input_error.h"
#include "discretization/delaunay.h"
#include "discretization/surface_geometry.h"

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
  InsideTest(const NodeCloud& cloud, const SurfaceTree& surface) : X_(cloud.X), surface_(surface) {
    depth_.resize(X_.size(), 0.0);
    for (std::size_t i = 0; i < X_.size(); ++i) {
      if (!cloud.on_surface[i]) depth_[i] = surface.closest(X_[i]).distance;
    }
  }

  /// True if at least half of the cell's samples lie inside the body.
  bool holds(const std::array<int, 4>& cell) const {
    // The ball around an inner node that does not reach the surface lies inside the body.
    for (int i : cell) {
      double longest = 0;
      for (int j : cell) longest = std::max(longest, (X_[i] - X_[j]).norm());
      if (longest < depth_[i]) return true;
    }
    int inside = 0;
    for (const Eigen::Vector4d& sample : samples_) {
      Vec3 x = Vec3::Zero();
      for (int k = 0; k < 4; ++k) x += sample[k] * X_[cell[k]];
      inside += surface_.inside(x);
    }
    return 2 * inside > static_cast<int>(samples_.size());
  }

 private:
  const std::vector<Vec3>& X_;
  const SurfaceTree& surface_;
  std::vector<double> depth_;  // (node_count) m below the surface; 0 on it
  std::array<Eigen::Vector4d, 15> samples_ = insideSamples();
};

double cellVolume(const std::vector<Vec3>& X, const std::array<int, 4>& cell) {
  return tetrahedronVolume(X[cell[0]], X[cell[1]], X[cell[2]], X[cell[3]]);
}

/// Drops slivers from the outside inward, so that no hole is left behind: cells of four surface nodes
/// with a face on the boundary. (Slivers inside are few and stay.) Returns how many.
int peelSlivers(std::vector<std::array<int, 4>>& cells, const NodeCloud& cloud) {
  const auto isSliver = [&](const std::array<int, 4>& cell) {
    const double longest = longestEdge(cloud.X, cell);
    return std::all_of(cell.begin(), cell.end(), [&](int i) { return cloud.on_surface[i] != 0; }) &&
           cellVolume(cloud.X, cell) < sliver * longest * longest * longest;
  };
  const std::size_t before = cells.size();
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
  return static_cast<int>(before - cells.size());
}

}  // namespace

BackgroundCells makeBackgroundCells(const NodeCloud& cloud, const SurfaceTree& surface) {
  std::vector<std::array<int, 4>> all;
  try {
    all = delaunay(cloud.X);
  } catch (const std::runtime_error& error) {
    throw InputError({}, std::string("the nodes can't be joined to cells (") + error.what() + ")",
                     "use a smaller node spacing");
  }

  BackgroundCells result;
  const InsideTest inside(cloud, surface);
  for (const std::array<int, 4>& cell : all) {
    if (!inside.holds(cell)) {
      ++result.outside_count;
    } else {
      result.cells.push_back(cell);
    }
  }
  result.sliver_count = peelSlivers(result.cells, cloud);
  std::vector<char> used(cloud.X.size(), false);
  for (const std::array<int, 4>& cell : result.cells) {
    for (int i : cell) used[i] = true;
  }
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) result.unused_nodes.push_back(static_cast<int>(i));
  }
  result.surface_volume = signedVolume(surface.surface());
  updateVolumes(result, cloud.X);
  return result;
}

std::vector<std::array<int, 3>> boundaryFacets(const std::vector<std::array<int, 4>>& cells) {
  struct Facet {
    std::array<int, 3> sorted, outward;
  };
  std::vector<Facet> facets;
  facets.reserve(4 * cells.size());
  for (const auto& [a, b, c, d] : cells) {
    for (const std::array<int, 3>& outward : {std::array{b, c, d}, {a, d, c}, {a, b, d}, {a, c, b}}) {
      std::array<int, 3> sorted = outward;
      std::sort(sorted.begin(), sorted.end());
      facets.push_back({sorted, outward});
    }
  }
  std::sort(facets.begin(), facets.end(), [](const Facet& p, const Facet& q) { return p.sorted < q.sorted; });
  std::vector<std::array<int, 3>> boundary;
  for (std::size_t begin = 0, end = 0; begin < facets.size(); begin = end) {
    while (end < facets.size() && facets[end].sorted == facets[begin].sorted) ++end;
    if (end - begin == 1) boundary.push_back(facets[begin].outward);
  }
  return boundary;
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
