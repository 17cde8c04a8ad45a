#include "discretization/surface/feature_edges.h"

#include <algorithm>
#include <cmath>

#include "discretization/surface/surface_geometry.h"
#include "discretization/surface/surface_parts.h"

namespace palpate {
namespace {

/// Of the angle from which an edge is sharp, rad: above what a coarse but smooth mesh has (a round of 9 faces), below a
/// right angle.
const double smooth_cosine = std::cos(0.698);

/// Pairs of vertices joined by a sharp edge, sorted. An edge without exactly two faces counts as sharp.
std::vector<std::array<int, 2>> sharpEdges(const TriangleSurface& surface) {
  std::vector<Vec3> normal(surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    normal[t] = areaVector(surface, static_cast<int>(t)).normalized();
  std::vector<std::array<int, 2>> sharp;
  forEachEdge(faceEdges(surface), [&](const FaceEdge* edge, int count) {
    const bool smooth = count == 2 && normal[edge[0].triangle].dot(normal[edge[1].triangle]) >= smooth_cosine;
    if (!smooth) sharp.push_back({edge->low, edge->high});
  });
  return sharp;
}

/// Follows sharp edges from vertex to vertex.
class Tracer {
 public:
  Tracer(const TriangleSurface& surface, std::vector<std::array<int, 2>> edges)
      : surface_(surface), edges_(std::move(edges)), used_(edges_.size(), false), at_(surface.vertices.size()) {
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      for (int v : edges_[e]) at_[v].push_back(static_cast<int>(e));
    }
    corner_.resize(at_.size());
    for (std::size_t v = 0; v < at_.size(); ++v) corner_[v] = isCorner(static_cast<int>(v));
  }

  FeatureEdges trace() {
    FeatureEdges features;
    for (std::size_t v = 0; v < at_.size(); ++v) {
      if (!corner_[v]) continue;
      features.corners.push_back(surface_.vertices[v]);
      for (int e : at_[v]) {
        if (!used_[e]) features.chains.push_back(follow(static_cast<int>(v), e));
      }
    }
    for (std::size_t e = 0; e < edges_.size(); ++e) {  // what is left are loops without a corner
      if (!used_[e]) features.chains.push_back(follow(edges_[e][0], static_cast<int>(e)));
    }
    return features;
  }

 private:
  int otherEnd(int e, int v) const { return edges_[e][0] == v ? edges_[e][1] : edges_[e][0]; }

  bool isCorner(int v) const {
    if (at_[v].empty()) return false;
    if (at_[v].size() != 2) return true;
    const Vec3& x = surface_.vertices[v];
    const Vec3 in = (x - surface_.vertices[otherEnd(at_[v][0], v)]).normalized();
    const Vec3 out = (surface_.vertices[otherEnd(at_[v][1], v)] - x).normalized();
    return in.dot(out) < smooth_cosine;
  }

  FeatureEdges::Chain follow(int start, int e) {
    FeatureEdges::Chain chain;
    chain.points.push_back(surface_.vertices[start]);
    int v = start;
    while (true) {
      used_[e] = true;
      v = otherEnd(e, v);
      chain.points.push_back(surface_.vertices[v]);
      if (corner_[v]) return chain;
      if (v == start) break;
      e = at_[v][0] == e ? at_[v][1] : at_[v][0];
    }
    chain.closed = true;
    return chain;
  }

  const TriangleSurface& surface_;
  std::vector<std::array<int, 2>> edges_;
  std::vector<char> used_;
  std::vector<std::vector<int>> at_;  // (vertex_count) sharp edges at a vertex
  std::vector<char> corner_;          // (vertex_count)
};

}  // namespace

FeatureEdges findFeatureEdges(const TriangleSurface& surface) { return Tracer(surface, sharpEdges(surface)).trace(); }

}  // namespace palpate
