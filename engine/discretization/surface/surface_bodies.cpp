#include "discretization/surface/surface_bodies.h"

#include "discretization/surface/surface_parts.h"
#include "discretization/surface/surface_tree.h"

namespace palpate {
namespace {

/// The smallest shell that holds a cavity: its place among the parts, or -1.
int shellAround(const TriangleSurface& cavity, const std::vector<TriangleSurface>& parts,
                const std::vector<double>& volume) {
  const Box3 box = boundingBox(cavity);
  int found = -1;
  for (int p = 0; p < static_cast<int>(parts.size()); ++p) {
    const bool is_smaller = volume[p] > 0 && (found < 0 || volume[p] < volume[found]);
    if (!is_smaller || !boundingBox(parts[p]).contains(box)) continue;
    if (SurfaceTree(parts[p]).inside(cavity.vertices.front())) found = p;
  }
  return found;
}

}  // namespace

std::vector<int> SurfaceBodies::ofVertices(const TriangleSurface& surface) const {
  std::vector<int> body(surface.vertices.size(), -1);
  for (std::size_t t = 0; t < of_face.size(); ++t)
    for (const int v : surface.triangles[t]) body[static_cast<std::size_t>(v)] = of_face[t];
  return body;
}

SurfaceBodies bodiesOf(const TriangleSurface& surface) {
  const SurfaceParts parts = connectedParts(surface, faceEdges(surface));
  if (parts.count <= 1) return {parts.count, parts.part};
  const std::vector<TriangleSurface> pieces = separateParts(surface, parts);
  std::vector<double> volume;
  for (const TriangleSurface& piece : pieces) volume.push_back(signedVolume(piece));
  SurfaceBodies bodies;
  std::vector<int> body(pieces.size(), -1);
  for (std::size_t p = 0; p < pieces.size(); ++p)
    if (volume[p] > 0) body[p] = bodies.count++;
  for (std::size_t p = 0; p < pieces.size(); ++p) {
    if (volume[p] > 0) continue;
    const int shell = shellAround(pieces[p], pieces, volume);
    body[p] = shell < 0 ? bodies.count++ : body[static_cast<std::size_t>(shell)];
  }
  for (const int p : parts.part) bodies.of_face.push_back(body[static_cast<std::size_t>(p)]);
  return bodies;
}

std::vector<TriangleSurface> separated(const TriangleSurface& surface, const SurfaceBodies& bodies) {
  if (bodies.count == 1) return {surface};
  SurfaceParts by_body;
  by_body.count = bodies.count;
  by_body.part = bodies.of_face;
  return separateParts(surface, by_body);
}

void addSurface(const TriangleSurface& more, TriangleSurface& all) {
  const int vertices = static_cast<int>(all.vertices.size());
  all.vertices.insert(all.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const auto& [a, b, c] : more.triangles) all.triangles.push_back({a + vertices, b + vertices, c + vertices});
}

}  // namespace palpate
