#pragma once

#include <vector>

#include "app/render/gl_object.h"
#include "app/render/mesh_buffers.h"
#include "app/render/shader_program.h"
#include "app/render/skin_mesh.h"
#include "app/render/view.h"
#include "model/body.h"
#include "realtime/channels/snapshot.h"

namespace palpate::app {

/// What explains the picture: nodes, integration points, a support, arrows of force, a pull.
class Overlays {
 public:
  Overlays(const Body& model, const std::string& shader_dir);

  /// As SkinMesh::goOnWith.
  void goOnWith(const Body& model) { model_ = &model; }

  /// Draws over the tissue; what it hides of points shows faintly through.
  /// @param skin  as drawn
  /// @param organ_radius  m; the longest arrow is a share of it
  void draw(const Snapshot& snapshot, const View& view, const SkinMesh& skin, double organ_radius,
            int framebuffer_height);

 private:
  struct Dot {
    Vec3f position;  // m
    Vec3f colour;    // linear
    float diameter;  // screen units
  };
  struct Arrow {
    Vec3f origin, along;  // m
    float radius;         // of the shaft, m
    Vec3f colour;         // linear
  };

  void addNodes(const Snapshot& snapshot);
  void addPoints(const Snapshot& snapshot);
  void addSupport(const Snapshot& snapshot, int point);
  void addPull(const View& view, const SkinMesh& skin, int framebuffer_height);
  void addToolForce(const Snapshot& snapshot, const View& view, double organ_radius, int framebuffer_height);
  void addContactForces(const Snapshot& snapshot, const View& view, const SkinMesh& skin, int framebuffer_height);
  void drawDots() const;
  void drawArrows(const std::vector<Arrow>& arrows, GLenum depth_test) const;
  void drawBubble() const;

  const Body* model_;
  ShaderProgram dot_program_, arrow_program_, bubble_program_;
  GLint opacity_, arrow_clear_, bubble_clear_, bubble_place_, bubble_tint_;
  GlVertexArray dot_array_;
  GlBuffer dot_buffer_, arrow_buffer_;
  MeshBuffers arrow_mesh_, sphere_mesh_;

  // Of the present picture.
  std::vector<Dot> dots_;
  std::vector<Arrow> arrows_, clear_arrows_;  // the latter show through what hides them
  Vec3f bubble_centre_ = Vec3f::Zero();
  float bubble_radius_ = 0;  // m; 0: none
};

}  // namespace palpate::app
