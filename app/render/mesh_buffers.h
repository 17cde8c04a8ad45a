#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "app/render/gl_object.h"
#include "app/render/skin_mesh.h"
#include "app/render/solid_mesh.h"

namespace palpate::app {

/// Indexed triangles on the graphics card.
class MeshBuffers {
 public:
  /// A skin whose vertices are sent anew for each picture: attributes 0 position, 1 normal,
  /// 2 reference, 3 (value, contact, cavity, fixed), 4 tissue.
  explicit MeshBuffers(const SkinMesh& skin);

  /// A constant solid: attributes 0 position, 1 normal, 2 finish.
  explicit MeshBuffers(const SolidMesh& solid);

  void update(const SkinMesh& skin) const;

  void draw() const;
  void drawInstances(int count) const;

  /// For further attributes, one per instance.
  GLuint vertexArray() const { return array_; }

 private:
  GlVertexArray array_;
  GlBuffer vertices_, indices_;
  GLsizei index_count_ = 0;
};

/// Adds a float attribute of `size` components at `offset` floats, `stride` floats apart, to the
/// bound vertex array, from the bound GL_ARRAY_BUFFER.
void addAttribute(GLuint location, int size, std::size_t offset, std::size_t stride);

}  // namespace palpate::app
