#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "contact/skin_contact.h"
#include "contact/skin_places.h"
#include "contact/skin_points.h"
#include "discretization/surface/surface_bodies.h"
#include "discretization/surface/surface_geometry.h"

namespace palpate {
namespace {

/// Ranks of the bodies by the mean area of their vertices, the smallest first.
std::vector<int> byDensity(const SkinBodies& bodies, const SkinModel& skin) {
  const auto count = static_cast<std::size_t>(bodies.count);
  std::vector<double> area(count), vertices(count);
  for (int v = 0; v < skin.vertexCount(); ++v) {
    area[static_cast<std::size_t>(bodies.body[v])] += skin.area[v];
    vertices[static_cast<std::size_t>(bodies.body[v])] += 1;
  }
  std::vector<int> order(count), rank(count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return area[a] * vertices[b] < 0.999 * area[b] * vertices[a]; });
  for (std::size_t k = 0; k < count; ++k) rank[static_cast<std::size_t>(order[k])] = static_cast<int>(k);
  return rank;
}

/// The faces around each cluster's vertices.
void addClusterFaces(const SkinModel& skin, SkinBodies& bodies) {
  const SkinTopology& topology = *skin.topology;
  bodies.cluster_face_begin.assign(1, 0);
  for (int c = 0; c < skin.clusterCount(); ++c) {
    int of = bodies.body[skin.cluster_representative[c]];
    for (int k = skin.cluster_begin[c]; k < skin.cluster_begin[c + 1]; ++k)
      if (bodies.body[skin.cluster_vertex[k]] != of) of = -1;
    bodies.cluster_body.push_back(of);
    const auto first = static_cast<std::ptrdiff_t>(bodies.cluster_face.size());
    for (int k = skin.cluster_begin[c]; k < skin.cluster_begin[c + 1]; ++k) {
      const int v = skin.cluster_vertex[k];
      bodies.cluster_face.insert(bodies.cluster_face.end(), topology.face_of.begin() + topology.face_begin[v],
                                 topology.face_of.begin() + topology.face_begin[v + 1]);
    }
    std::sort(bodies.cluster_face.begin() + first, bodies.cluster_face.end());
    bodies.cluster_face.erase(std::unique(bodies.cluster_face.begin() + first, bodies.cluster_face.end()),
                              bodies.cluster_face.end());
    bodies.cluster_face_begin.push_back(static_cast<int>(bodies.cluster_face.size()));
  }
}

/// The nodes that move each region's vertices.
void addRegionNodes(const SkinModel& skin, SkinBodies& bodies) {
  bodies.region.resize(static_cast<std::size_t>(skin.vertexCount()));
  bodies.region_node_begin.assign(1, 0);
  std::vector<int> last_region(static_cast<std::size_t>(bodies.node_count), -1);  // that a node was found in
  for (int r = 0; r < skin.regionCount(); ++r) {
    const auto first = static_cast<std::ptrdiff_t>(bodies.region_node.size());
    for (int k = skin.cluster_begin[skin.region_begin[r]]; k < skin.cluster_begin[skin.region_begin[r + 1]]; ++k) {
      const int v = skin.cluster_vertex[k];
      bodies.region[v] = r;
      for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e)
        if (std::exchange(last_region[skin.node[e]], r) != r) bodies.region_node.push_back(skin.node[e]);
    }
    std::sort(bodies.region_node.begin() + first, bodies.region_node.end());
    bodies.region_node_begin.push_back(static_cast<int>(bodies.region_node.size()));
  }
}

/// The normals of a cluster's vertices: one, and the sine of the largest angle that another has to it (1: any).
struct Aspect {
  Vec3 axis = Vec3::Zero();
  double turned = 1;
};

Aspect aspectOf(const SkinModel& skin, const std::vector<Vec3>& normal, int c) {
  const std::span<const int> vertices(skin.cluster_vertex.data() + skin.cluster_begin[c],
                                      skin.cluster_vertex.data() + skin.cluster_begin[c + 1]);
  Vec3 sum = Vec3::Zero();
  for (const int v : vertices) sum += normal[v];
  const Vec3 axis = unit(sum);
  double least = 1;
  for (const int v : vertices) least = std::min(least, axis.dot(normal[v]));
  return {axis, least > 0 ? std::sqrt(1 - least * least) : 1};
}

/// Whether no vertex of cluster a can look at one of b: for each all of b look the same way, or are behind it. Where it
/// says no, some may all the same not.
bool looksPast(const SkinModel& skin, const std::vector<Aspect>& aspect, int a, int b) {
  constexpr double rounding = 1e-9;
  const double turned = aspect[a].turned, straight = std::sqrt(1 - turned * turned),
               alike = std::clamp(aspect[a].axis.dot(aspect[b].axis), -1.0, 1.0);
  if (alike * straight - std::sqrt(1 - alike * alike) * turned > aspect[b].turned + rounding) return true;
  const auto& X = skin.surface.vertices;
  const Vec3 way = X[skin.cluster_representative[b]] - X[skin.cluster_representative[a]];
  const double ahead = way.dot(aspect[a].axis), beside = (way - ahead * aspect[a].axis).norm(),
               radii = (static_cast<double>(skin.cluster_radius[a]) + static_cast<double>(skin.cluster_radius[b])) *
                       (1 + 1e-6);
  return ahead < 0 && ahead * straight + beside * turned < -radii;
}

/// Apart from each other, per spacing of the nodes there, are the points that touch other bodies: the displacement
/// between them is no finer. Of two blocks that meet at 0.9 m/s one goes 1.8 mm into the other with 0.5, 0.34 mm with
/// this, 0.25 mm where all vertices touch, which takes seven times as long.
constexpr double organ_point_distance = 0.35;

/// Which vertices touch other bodies.
void addPoints(const SkinModel& skin, const SpacingField& spacing, SkinBodies& bodies) {
  bodies.apart = bodies.longest_edge;
  if (!bodies.several()) return;
  bodies.apart = std::max(bodies.apart, organ_point_distance * spacing.largest());
  const SkinPoints points =
      skinPoints(skin, bodies.body, [&](const Vec3& X) { return organ_point_distance * spacing.at(X); });
  bodies.area.assign(bodies.body.size(), 0);
  for (std::size_t p = 0; p < points.vertex.size(); ++p) bodies.area[points.vertex[p]] = points.area[p];
}

/// Which clusters look at each other across a gap, and how near they are.
void addGaps(const SkinModel& skin, SkinBodies& bodies) {
  const auto &X = skin.surface.vertices, &N = bodies.normal;
  const double along = along_skin * bodies.spacing;
  constexpr double rounding = 1e-9;
  bodies.least_gap = bodies.several() ? 0 : along;
  std::vector<Aspect> aspect;
  for (int c = 0; c < skin.clusterCount(); ++c) aspect.push_back(aspectOf(skin, N, c));
  for (int a = 0; a < skin.clusterCount(); ++a)
    for (int b = a; b < skin.clusterCount(); ++b) {
      if (looksPast(skin, aspect, a, b) || !areOfOne(bodies, a, b) || distanceBetween(skin, a, b)[0] > along) continue;
      const Vec3& centre = X[skin.cluster_representative[b]];
      const double radius = static_cast<double>(skin.cluster_radius[b]) * (1 + 1e-6);
      bool are_across = false;
      for (int k = skin.cluster_begin[a]; k < skin.cluster_begin[a + 1]; ++k) {
        const int v = skin.cluster_vertex[k];
        // All of the others look the same way, or are behind it.
        if (N[v].dot(aspect[b].axis) > aspect[b].turned + rounding || N[v].dot(centre - X[v]) < -radius) continue;
        for (int l = skin.cluster_begin[b]; l < skin.cluster_begin[b + 1]; ++l) {
          const int w = skin.cluster_vertex[l];
          if ((X[v] - X[w]).squaredNorm() > along * along || !mayTouch(bodies, skin, v, w)) continue;
          are_across = true;
          bodies.least_gap = std::min(bodies.least_gap, (X[v] - X[w]).norm());
        }
      }
      if (are_across) bodies.across_gaps.push_back({a, b});
    }
}

}  // namespace

SkinBodies makeSkinBodies(const SkinModel& skin, double spacing, const SpacingField& finest) {
  SkinBodies bodies;
  const SurfaceBodies of = bodiesOf(skin.surface);
  bodies.count = of.count;
  bodies.body = of.ofVertices(skin.surface);
  for (int& b : bodies.body) b = std::max(b, 0);
  bodies.rank = byDensity(bodies, skin);
  bodies.organ.assign(static_cast<std::size_t>(of.count), 0);
  bodies.friction.assign(static_cast<std::size_t>(of.count), 0.0F);
  bodies.spacing = spacing;
  for (const float length : skin.topology->edge_length)
    bodies.longest_edge = std::max(bodies.longest_edge, static_cast<double>(length));
  bodies.normal = vertexNormals(skin.surface);
  addPoints(skin, finest, bodies);
  addClusterFaces(skin, bodies);
  addGaps(skin, bodies);
  return bodies;
}

void addRows(const SkinModel& skin, SkinBodies& bodies) {
  for (int v = 0; v < skin.vertexCount(); ++v) bodies.row_sum = std::max(bodies.row_sum, rowSum(skin, v));
  for (const int i : skin.node) bodies.node_count = std::max(bodies.node_count, i + 1);
  addRegionNodes(skin, bodies);
}

}  // namespace palpate
