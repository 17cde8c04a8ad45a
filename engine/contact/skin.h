#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "approximation/shape_table.h"
#include "base/float4.h"
#include "base/types.h"
#include "contact/samples/skin_topology.h"
#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// The skin as the contact reads it: constant. Vertices are not nodes; vertex v
/// stands at X_v + sum_i N_i(X_v) u_i. They are also the quadrature points of the
/// contact pressure, so what the tool feels is only as fine as the skin (faces that are stretched
/// get points of their own, face_samples.h). Where a tool can
/// touch, edges should be at most 0.35 of its radius and no longer than its rounding (ToolProfile):
/// first touch is then late by up to 0.02 R (a quarter of that with half the edges).
struct SkinModel {
  TriangleSurface surface;   // reference configuration, m
  std::vector<double> area;  // (vertex_count) a third of the adjacent triangles, m^2
  // Row r of the shape table in the layout of the real-time loop.
  std::vector<int> begin;  // (vertex_count + 1)
  std::vector<int> node;   // (entry_count)
  AlignedVector<float> N;  // (entry_count)
  // Clusters for the broad phase, made by buildSkinModel.
  std::vector<int> cluster_begin;           // (cluster_count + 1)
  std::vector<int> cluster_vertex;          // (vertex_count) vertices, grouped by cluster
  std::vector<int> cluster_representative;  // (cluster_count) a vertex near the cluster's centre
  std::vector<float> cluster_radius;        // (cluster_count) m, around it; reference configuration
  // Consecutive clusters in regions, which are tested first.
  std::vector<int> region_begin;           // (region_count + 1) clusters
  std::vector<int> region_representative;  // (region_count) as a cluster's
  std::vector<float> region_radius;        // (region_count)
  // The elastic layer through which all contact acts, a little stiffer than the tissue below it.
  std::vector<float> layer;  // (vertex_count) Pa/m, pressure per penetration
  double layer_depth = 0;    // m, penetration at a pressure of Young's modulus, of what keeps its volume of less
  // For samples on stretched faces (face_samples.h); one for all models with this surface.
  std::shared_ptr<const SkinTopology> topology = std::make_shared<const SkinTopology>();

  int vertexCount() const { return static_cast<int>(area.size()); }
  int clusterCount() const { return static_cast<int>(cluster_representative.size()); }
  int regionCount() const { return static_cast<int>(region_representative.size()); }
};

/// Groups the skin's vertices into clusters and copies the shape table into the
/// real-time layout. `shape` has one row per skin vertex. The topology and the layer are the caller's to add.
SkinModel buildSkinModel(const TriangleSurface& surface, const ShapeTable& shape);

/// m, SkinModel::layer_depth before tissue whose nodes are `spacing` (m) apart, for tools of that radius (m) and wider.
double layerDepth(double tool_radius, double spacing);

/// Pa, by which the layer before a tissue goes: Young's modulus where its shape resists, 3 G, or a tenth of the wave
/// modulus where its volume does: what is thin or held gives way by the latter alone, of which the layer would have 3 %
/// at nu 0.49, and more than the tissue at 0.4999. (With a third or a sixth vertices knock as they enter, and the
/// linear systems of sensitivities are not solved.)
/// @param bulk_modulus, shear_modulus  Pa
double layerModulus(double bulk_modulus, double shear_modulus);

/// Depths of the layer from which on the pressure grows no further. Only a tool that is put into the tissue gets there;
/// the cap lets it be expelled instead of exploding.
inline constexpr double most_depths = 100;

/// Copies the values of a table with one row per skin vertex.
void setRows(const ShapeTable& shape, SkinModel& skin);

/// Interpolates a nodal field at skin vertex v: sum_i N_i(X_v) field_i. Lane w is 0.
/// Four partial sums, so that the additions overlap; their order is fixed.
/// Real-time; cost ~ 25 four-lane FMAs.
inline Eigen::Vector4f interpolateAtVertex(const SkinModel& skin, int v, const Float4* field) {
  const float* N = skin.N.data();
  const int* node = skin.node.data();
  const int end = skin.begin[v + 1];
  Group s0{}, s1{}, s2{}, s3{};
  int e = skin.begin[v];
  for (; e + 4 <= end; e += 4) {
    s0 += N[e] * load(field[node[e]]);
    s1 += N[e + 1] * load(field[node[e + 1]]);
    s2 += N[e + 2] * load(field[node[e + 2]]);
    s3 += N[e + 3] * load(field[node[e + 3]]);
  }
  for (; e < end; ++e) s0 += N[e] * load(field[node[e]]);
  Eigen::Vector4f sum;
  storeGroup(sum.data(), (s0 + s1) + (s2 + s3));
  return sum;
}

/// Asks for the row of vertex v, which the next step's other data have driven from the near caches. Real-time.
inline void prefetchVertex(const SkinModel& skin, int v) {
  constexpr int line = 16;  // entries
  for (int e = skin.begin[v]; e < skin.begin[v + 1]; e += line) {
    __builtin_prefetch(&skin.N[e]);
    __builtin_prefetch(&skin.node[e]);
  }
}

/// Whether a point is in what a closed skin encloses as it is now: by the faces above it, each by its side.
/// @param position  (vertex_count) scratch
/// Real-time: no allocation, no lock, no throw; an interpolation for each vertex.
bool isInside(const SkinModel& skin, const Float4* u, const Vec3& point, std::vector<Vec3f>& position);

/// sum_i |N_i| of skin vertex v: how much further than nodes it goes at most.
inline double rowSum(const SkinModel& skin, int v) {
  double sum = 0;
  for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e) sum += std::abs(static_cast<double>(skin.N[e]));
  return sum;
}

/// Where skin vertex v is now, m. Real-time.
inline Vec3 skinPosition(const SkinModel& skin, int v, const Float4* u) {
  return skin.surface.vertices[v] + interpolateAtVertex(skin, v, u).head<3>().cast<double>();
}

}  // namespace palpate
