#include "app/render/mesh_buffers.h"

#include <cstddef>

namespace palpate::app {
namespace {

static_assert(sizeof(SkinVertex) == 16 * sizeof(float) && sizeof(SolidVertex) == 7 * sizeof(float),
              "vertices go to the card as they stand in memory");

template <class Index>
void sendIndices(const std::vector<Index>& indices) {
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * sizeof(Index)), indices.data(),
               GL_STATIC_DRAW);
}

}  // namespace

void addAttribute(GLuint location, int size, std::size_t offset, std::size_t stride) {
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride * sizeof(float)),
                        reinterpret_cast<const void*>(offset * sizeof(float)));
}

MeshBuffers::MeshBuffers(const SkinMesh& skin) {
  glBindVertexArray(array_);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  sendIndices(skin.triangles());
  index_count_ = static_cast<GLsizei>(3 * skin.triangles().size());
  update(skin);
  glBindBuffer(GL_ARRAY_BUFFER, vertices_);
  for (GLuint k = 0; k < 3; ++k) addAttribute(k, 3, 3 * k, 16);
  addAttribute(3, 4, 9, 16);
  addAttribute(4, 3, 13, 16);
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

MeshBuffers::MeshBuffers(const SolidMesh& solid) {
  glBindVertexArray(array_);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_);
  sendIndices(solid.indices);
  index_count_ = static_cast<GLsizei>(solid.indices.size());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(solid.vertices.size() * sizeof(SolidVertex)),
               solid.vertices.data(), GL_STATIC_DRAW);
  addAttribute(0, 3, 0, 7);
  addAttribute(1, 3, 3, 7);
  addAttribute(2, 1, 6, 7);
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void MeshBuffers::update(const SkinMesh& skin) const {
  glBindBuffer(GL_ARRAY_BUFFER, vertices_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(skin.vertices().size() * sizeof(SkinVertex)),
               skin.vertices().data(), GL_STREAM_DRAW);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void MeshBuffers::draw() const {
  glBindVertexArray(array_);
  glDrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
}

void MeshBuffers::drawInstances(int count) const {
  glBindVertexArray(array_);
  glDrawElementsInstanced(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr, count);
}

}  // namespace palpate::app
