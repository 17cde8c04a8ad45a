#pragma once

#include <array>
#include <span>
#include <vector>

#include "app/render/field.h"
#include "app/render/view.h"
#include "model/body.h"
#include "realtime/channels/snapshot.h"

namespace palpate::app {

/// A skin vertex as the shaders read it.
struct SkinVertex {
  Vec3f position;     // m, deformed
  Vec3f normal;       // unit, outward
  Vec3f reference;    // m, at rest: what patterns stick to
  float value = 0;    // of the shown field, 0..1 within the colour scale, -1..2 at most
  float contact = 0;  // pressure of the tool over the tissue's shear modulus, 0..1
  float cavity = 0;   // mean curvature times the tool's radius; > 0 in hollows
  float fixed = 0;    // share of imposed nodes in the support, 0..1
  Vec3f tissue;       // albedo, linear
};

/// The skin to draw: the model's surface, moved by the nodes, with smooth normals.
/// Where the surface at rest has an edge (a cylinder's rim), its vertices are doubled so
/// that the edge stays sharp.
class SkinMesh {
 public:
  /// @param whole_vertex  of a cut body (CutBody), whose snapshots tell of the whole one's skin; else empty
  explicit SkinMesh(const Body& model, std::span<const int> whole_vertex = {});

  /// The next snapshots are of this body, which has the same skin, but other nodes (setup/place.h).
  void goOnWith(const Body& model) { model_ = &model; }

  /// Follows a snapshot. @return the scale of the vertices' values
  ColourScale update(const Snapshot& snapshot, const View& view);

  const std::vector<SkinVertex>& vertices() const { return vertices_; }
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }  // of vertices()
  const std::vector<Vec3f>& positions() const { return positions_; }               // of the model's skin
  /// The model's skin vertex that this one of the whole body became, -1 where it was cut away.
  int leftOf(int whole_vertex) const;

 private:
  void splitEdges();
  void findNeighbours();
  void updateNormals();
  void updateCavities();
  void updateContact(const Snapshot& snapshot);
  void spread(std::vector<float>& values) const;

  const Body* model_;
  std::vector<SkinVertex> vertices_;
  std::vector<int> skin_vertex_;  // (vertices) the model's skin vertex behind each
  std::vector<std::array<int, 3>> triangles_;
  std::vector<int> left_;  // (whole skin vertex_count) the model's skin vertex of each, -1: cut away
  std::vector<int> neighbour_begin_, neighbour_;  // around each skin vertex, compressed rows
  std::vector<Vec3f> positions_;                  // (skin vertex_count) m
  std::vector<Vec3f> normals_;                    // (skin vertex_count) unit
  std::vector<float> cavity_, contact_;           // (skin vertex_count)
};

}  // namespace palpate::app
