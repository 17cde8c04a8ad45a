#include "app/render/skin_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace palpate::app {
namespace {

// Faces that meet at more than this are an edge, not a coarsely sampled curve: an organ's
// thin margin stays smooth, a cylinder's rim (90 degrees) does not.
const float edge_cosine = std::cos(70.0F * EIGEN_PI / 180);

// Pressure at which the contact tint is full, in shear moduli: a firm press of soft tissue.
constexpr double full_contact_pressure = 1.0;

// A value far outside the colours' range bounds how near to it the range begins between two vertices.
constexpr float least_value = -1, most_value = 2;
constexpr double outside_share = 1e-4;  // of the range: less is rounding

Vec3f areaNormal(const std::vector<Vec3f>& x, const std::array<int, 3>& t) {
  return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
}

Vec3f unitOr(const Vec3f& v, const Vec3f& fallback) {
  const float length = v.norm();
  return length > 0 ? Vec3f(v / length) : fallback;
}

bool shareEdge(const std::array<int, 3>& a, const std::array<int, 3>& b) {
  int common = 0;
  for (const int v : a) common += std::count(b.begin(), b.end(), v) > 0;
  return common >= 2;
}

/// Which vertex each of the whole body's became: the first, where the section repeats it.
std::vector<int> verticesLeft(std::span<const int> whole_vertex, std::size_t vertex_count) {
  std::vector<int> left;
  if (whole_vertex.empty()) {
    left.resize(vertex_count);
    std::iota(left.begin(), left.end(), 0);
    return left;
  }
  for (std::size_t v = 0; v < whole_vertex.size(); ++v) {
    if (whole_vertex[v] < 0) continue;
    const auto whole = static_cast<std::size_t>(whole_vertex[v]);
    if (whole >= left.size()) left.resize(whole + 1, -1);
    if (left[whole] < 0) left[whole] = static_cast<int>(v);
  }
  return left;
}

}  // namespace

SkinMesh::SkinMesh(const Body& model, std::span<const int> whole_vertex)
    : model_(&model), triangles_(model.skin.surface.triangles) {
  for (const Vec3& X : model.skin.surface.vertices) positions_.push_back(X.cast<float>());
  left_ = verticesLeft(whole_vertex, positions_.size());
  splitEdges();
  findNeighbours();
  const std::vector<OrganSpec>& organs = model.scene.organs;
  const SkinModel& shape = model.skin;
  for (std::size_t s = 0; s < vertices_.size(); ++s) {
    const int v = skin_vertex_[s];
    vertices_[s].reference = positions_[v];
    double fixed = 0, all = 0;
    int heaviest = shape.begin[v];
    for (int k = shape.begin[v]; k < shape.begin[v + 1]; ++k) {
      const double w = std::max(0.0F, shape.N[k]);
      all += w;
      if (model.imposed[shape.node[k]] != 0) fixed += w;
      if (shape.N[k] > shape.N[heaviest]) heaviest = k;
    }
    const int organ = model.node_organ.empty() ? 0 : model.node_organ[shape.node[heaviest]];
    vertices_[s].tissue = organs[static_cast<std::size_t>(organ)].colour.cast<float>();
    vertices_[s].fixed = all > 0 ? static_cast<float>(fixed / all) : 0.0F;
  }
  normals_.assign(positions_.size(), Vec3f::UnitZ());
  cavity_.assign(positions_.size(), 0.0F);
  contact_.assign(positions_.size(), 0.0F);
}

void SkinMesh::splitEdges() {
  const auto& surface = model_->skin.surface.triangles;
  std::vector<std::vector<int>> around(positions_.size());  // triangles at each vertex
  std::vector<Vec3f> face_normal;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    for (const int v : surface[t]) around[v].push_back(static_cast<int>(t));
    face_normal.push_back(unitOr(areaNormal(positions_, surface[t]), Vec3f::Zero()));
  }
  for (int v = 0; v < static_cast<int>(around.size()); ++v) {
    // Faces around v that meet smoothly get one common vertex.
    const std::vector<int>& faces = around[v];
    std::vector<int> group(faces.size());
    std::iota(group.begin(), group.end(), 0);
    for (std::size_t a = 0; a < faces.size(); ++a)
      for (std::size_t b = a + 1; b < faces.size(); ++b)
        if (group[a] != group[b] && shareEdge(surface[faces[a]], surface[faces[b]]) &&
            face_normal[faces[a]].dot(face_normal[faces[b]]) > edge_cosine)
          std::replace(group.begin(), group.end(), group[b], group[a]);
    std::vector<int> vertex_of_group(faces.size(), -1);
    for (std::size_t a = 0; a < faces.size(); ++a) {
      int& s = vertex_of_group[group[a]];
      if (s < 0) {
        s = static_cast<int>(vertices_.size());
        vertices_.emplace_back();
        skin_vertex_.push_back(v);
      }
      for (int c = 0; c < 3; ++c)
        if (surface[faces[a]][c] == v) triangles_[faces[a]][c] = s;
    }
  }
}

void SkinMesh::findNeighbours() {
  std::vector<std::vector<int>> rows(positions_.size());
  for (const auto& t : model_->skin.surface.triangles)
    for (int c = 0; c < 3; ++c) rows[t[c]].push_back(t[(c + 1) % 3]);  // closed: each neighbour follows once
  neighbour_begin_.push_back(0);
  for (const auto& row : rows) {
    neighbour_.insert(neighbour_.end(), row.begin(), row.end());
    neighbour_begin_.push_back(static_cast<int>(neighbour_.size()));
  }
}

ColourScale SkinMesh::update(const Snapshot& snapshot, const View& view) {
  positions_ = deformed(model_->skin.surface.vertices, model_->skin, snapshot.u);
  updateNormals();
  updateCavities();
  updateContact(snapshot);
  const bool given = view.colour_map == ColourMap::Pressure && view.skin_values != nullptr &&
                     view.skin_values->size() == positions_.size();
  const std::vector<float> values =
      view.node_values != nullptr ? skinAverages(*model_, *view.node_values)
      : given                     ? *view.skin_values
                                  : skinValues(*model_, snapshot.u, positions_, view.colour_map, snapshot.materials);
  ColourScale scale = automaticScale(values, view.colour_map);
  if (!view.colour_auto && view.colour_map != ColourMap::Tissue && view.colour_max > view.colour_min) {
    scale.min = view.colour_min;
    scale.max = view.colour_max;
  }
  for (std::size_t s = 0; s < vertices_.size(); ++s) {
    const int v = skin_vertex_[s];
    vertices_[s].position = positions_[v];
    const double value = (values[v] - scale.min) / (scale.max - scale.min);
    vertices_[s].value = std::clamp(static_cast<float>(value), least_value, most_value);
    scale.below |= value < -outside_share;
    scale.above |= value > 1 + outside_share;
    vertices_[s].contact = contact_[v];
    vertices_[s].cavity = cavity_[v];
  }
  return scale;
}

void SkinMesh::updateNormals() {
  for (SkinVertex& s : vertices_) s.normal.setZero();
  std::fill(normals_.begin(), normals_.end(), Vec3f::Zero());
  const auto& surface = model_->skin.surface.triangles;
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const Vec3f normal = areaNormal(positions_, surface[t]);
    for (int c = 0; c < 3; ++c) {
      vertices_[triangles_[t][c]].normal += normal;
      normals_[surface[t][c]] += normal;
    }
  }
  for (SkinVertex& s : vertices_) s.normal = unitOr(s.normal, Vec3f::UnitZ());
  for (Vec3f& n : normals_) n = unitOr(n, Vec3f::UnitZ());
}

void SkinMesh::updateCavities() {
  // A sphere of curvature k bends away from its tangent plane by k e / 2 per distance e.
  const float radius = static_cast<float>(model_->scene.tools[0].shape.radius);
  for (std::size_t v = 0; v < positions_.size(); ++v) {
    float sum = 0;
    const int begin = neighbour_begin_[v], end = neighbour_begin_[v + 1];
    for (int k = begin; k < end; ++k) {
      const Vec3f edge = positions_[neighbour_[k]] - positions_[v];
      sum += 2 * normals_[v].dot(edge) / std::max(edge.squaredNorm(), 1e-20F);
    }
    cavity_[v] = end > begin ? radius * sum / static_cast<float>(end - begin) : 0.0F;
  }
  spread(cavity_);
}

int SkinMesh::leftOf(int whole_vertex) const {
  return whole_vertex >= 0 && whole_vertex < static_cast<int>(left_.size()) ? left_[whole_vertex] : -1;
}

void SkinMesh::updateContact(const Snapshot& snapshot) {
  std::fill(contact_.begin(), contact_.end(), 0.0F);
  if (snapshot.contact_count == 0) return;
  const double full = full_contact_pressure * model_->materials.front().shear_modulus;
  for (int k = 0; k < snapshot.contact_count; ++k) {
    const int v = leftOf(snapshot.contact_vertex[k]);
    if (v < 0) continue;
    const double pressure = toVec3(snapshot.contact_force[k]).norm() / model_->skin.area[v];
    contact_[v] = static_cast<float>(std::min(1.0, pressure / full));
  }
  spread(contact_);
  spread(contact_);
}

/// One round of averaging with the neighbours.
void SkinMesh::spread(std::vector<float>& values) const {
  const std::vector<float> old = values;
  for (std::size_t v = 0; v < old.size(); ++v) {
    const int begin = neighbour_begin_[v], end = neighbour_begin_[v + 1];
    if (begin == end) continue;
    float sum = 0;
    for (int k = begin; k < end; ++k) sum += old[neighbour_[k]];
    values[v] = 0.5F * old[v] + 0.5F * sum / static_cast<float>(end - begin);
  }
}

}  // namespace palpate::app
