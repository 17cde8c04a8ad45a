#include "discretization/surface/surface_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/input_error.h"
#include "base/number_text.h"
#include "base/parallel_for.h"
#include "discretization/surface/surface_geometry.h"
#include "discretization/surface/surface_parts.h"
#include "discretization/surface/surface_tree.h"

namespace palpate {

namespace {

// A face is refused as flat where its height is below this fraction of its longest edge:
// its normal would be rounding noise.
constexpr double flat_face_ratio = 1e-9;

// Faces pierce one another where an edge goes through by more than this fraction of the smaller one's size;
// below it they merely touch.
constexpr double pierce_ratio = 1e-9;

// Of a product of three lengths: what rounding may make of the volume that they span.
constexpr double volume_rounding = 1e-14;

std::string text(const Vec3& x) { return format("(%.6g, %.6g, %.6g) m", x.x(), x.y(), x.z()); }

std::string counted(int count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// The surface with its source: what the single checks share.
struct Subject {
  const TriangleSurface& surface;
  const SurfaceSource& source;

  int faceCount() const { return static_cast<int>(surface.triangles.size()); }
  SourceLocation facePlace(int t) const {
    return {source.file, source.triangle_line.empty() ? 0 : source.triangle_line[t], 0};
  }
  SourceLocation vertexPlace(int v) const {
    return {source.file, source.vertex_line.empty() ? 0 : source.vertex_line[v], 0};
  }
  /// "face 3 of 12": counted from 1, as OBJ counts.
  std::string face(int t) const { return "face " + std::to_string(t + 1) + " of " + std::to_string(faceCount()); }
  /// Where a vertex stands in space and, where known, in the file.
  std::string vertex(int v) const {
    const int line = vertexPlace(v).line;
    return text(surface.vertices[v]) + (line > 0 ? " [line " + std::to_string(line) + "]" : "");
  }
};

void checkNumbers(const Subject& s) {
  if (s.surface.triangles.empty()) {
    throw InputError({s.source.file, 0, 0}, "the surface has no faces", "export the organ as a triangle mesh");
  }
  const int vertex_count = static_cast<int>(s.surface.vertices.size());
  for (int v = 0; v < vertex_count; ++v) {
    if (!s.surface.vertices[v].allFinite()) {
      throw InputError(s.vertexPlace(v),
                       "vertex " + std::to_string(v + 1) + " is not finite: " + text(s.surface.vertices[v]),
                       "repair or export the surface again");
    }
  }
  for (int t = 0; t < s.faceCount(); ++t) {
    for (int v : s.surface.triangles[t]) {
      if (v < 0 || v >= vertex_count) {
        throw InputError(s.facePlace(t),
                         s.face(t) + " names vertex " + std::to_string(v + 1) + " of " + std::to_string(vertex_count),
                         "export the surface again");
      }
    }
  }
}

void checkAreas(const Subject& s) {
  for (int t = 0; t < s.faceCount(); ++t) {
    const auto& [a, b, c] = s.surface.triangles[t];
    const Vec3 &A = s.surface.vertices[a], &B = s.surface.vertices[b], &C = s.surface.vertices[c];
    const double longest = std::max({(B - A).norm(), (C - B).norm(), (A - C).norm()});
    const bool repeated = a == b || b == c || c == a;
    if (repeated || 2 * areaVector(s.surface, t).norm() <= flat_face_ratio * longest * longest) {
      throw InputError(s.facePlace(t),
                       s.face(t) + " has zero area" + (repeated ? " (two corners coincide)" : "") + ": corners " +
                           s.vertex(a) + ", " + s.vertex(b) + ", " + s.vertex(c),
                       "collapse its shortest edge or swap its longest one, e.g. with a mesh repair filter");
    }
  }
}

void checkEdges(const Subject& s, const std::vector<FaceEdge>& edges) {
  int open_count = 0;
  const FaceEdge* first_open = nullptr;
  forEachEdge(edges, [&](const FaceEdge* e, int count) {
    if (count == 1) {
      if (first_open == nullptr || e->triangle < first_open->triangle) first_open = e;
      ++open_count;
    }
    if (count > 2) {
      throw InputError(s.facePlace(e[2].triangle),
                       "the edge from " + s.vertex(e->low) + " to " + s.vertex(e->high) + " belongs to " +
                           std::to_string(count) + " faces (" + s.face(e->triangle) + ", " +
                           std::to_string(e[1].triangle + 1) + ", " + std::to_string(e[2].triangle + 1) + ")",
                       "a solid has two faces at each edge: remove doubled faces and inner walls");
    }
  });
  if (first_open != nullptr) {
    const FaceEdge& edge = *first_open;
    throw InputError(s.facePlace(edge.triangle),
                     "the surface has a hole: the edge of " + s.face(edge.triangle) + " from " + s.vertex(edge.low) +
                         " to " + s.vertex(edge.high) + " has no second face (" +
                         counted(open_count, "open edge", "open edges") + " in all)",
                     "close the hole, e.g. with a mesh editor's \"fill holes\"");
  }
}

void checkOrientation(const Subject& s, const SurfaceParts& parts) {
  std::vector<int> turned(parts.count, 0), size(parts.count, 0);
  for (int t = 0; t < s.faceCount(); ++t) {
    ++size[parts.part[t]];
    turned[parts.part[t]] += parts.turned[t];
  }
  for (int t = 0; t < s.faceCount(); ++t) {
    const int p = parts.part[t];
    if (parts.one_sided[p]) {
      throw InputError(s.facePlace(t), "the surface around " + s.face(t) + " is one-sided (like a Moebius strip)",
                       "export a surface that bounds a solid");
    }
    const bool majority_turned = 2 * turned[p] > size[p];
    if (parts.turned[t] != majority_turned) {
      const int minority = majority_turned ? size[p] - turned[p] : turned[p];
      const int corner = s.surface.triangles[t][0];
      throw InputError(s.facePlace(t),
                       s.face(t) + " at " + s.vertex(corner) + " is turned against its neighbours (" +
                           counted(minority, "such face", "such faces") + " in all)",
                       "reverse its vertex order, or let a mesh editor \"recalculate normals outside\"");
    }
  }
}

/// Six times the volume of a tetrahedron; 0 where that can't be told from rounding.
double sixfoldVolume(const Vec3& o, const Vec3& x, const Vec3& y, const Vec3& z) {
  const Vec3 ox = x - o, oy = y - o, oz = z - o;
  const double volume = ox.cross(oy).dot(oz);
  return std::abs(volume) > volume_rounding * ox.norm() * oy.norm() * oz.norm() ? volume : 0;
}

/// Whether pq goes through abc by more than `depth` (m): its ends that far from the plane, its line that far from the
/// lines of all three edges. Lengths, not volumes, are compared: a face that is long elsewhere hides nothing.
bool edgePierces(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c, double depth) {
  const double area = (b - a).cross(c - a).norm();  // twice the face's
  const double above = sixfoldVolume(a, b, c, p), below = sixfoldVolume(a, b, c, q);
  if (above * below >= 0 || std::min(std::abs(above), std::abs(below)) <= depth * area) return false;
  int side = 0;
  const auto passes = [&](const Vec3& from, const Vec3& to) {
    const double volume = sixfoldVolume(p, q, from, to);
    side += volume > 0 ? 1 : -1;
    return std::abs(volume) > depth * (q - p).cross(to - from).norm();
  };
  return passes(a, b) && passes(b, c) && passes(c, a) && std::abs(side) == 3;
}

}  // namespace

bool facesPierce(const TriangleSurface& surface, int s, int t) {
  const auto &f = surface.triangles[s], &g = surface.triangles[t];
  int shared = 0;
  for (int v : f) shared += std::find(g.begin(), g.end(), v) != g.end();
  if (shared >= 2) return false;  // neighbours across an edge
  const auto size = [&](int face) { return faceBox(surface, face).diagonal().norm(); };
  const double depth = pierce_ratio * std::min(size(s), size(t));
  const auto anyEdge = [&](const std::array<int, 3>& from, const std::array<int, 3>& through) {
    for (int k = 0; k < 3; ++k) {
      const int p = from[k], q = from[(k + 1) % 3];
      if (std::find(through.begin(), through.end(), p) != through.end()) continue;
      if (std::find(through.begin(), through.end(), q) != through.end()) continue;
      if (edgePierces(surface.vertices[p], surface.vertices[q], surface.vertices[through[0]],
                      surface.vertices[through[1]], surface.vertices[through[2]], depth)) {
        return true;
      }
    }
    return false;
  };
  return anyEdge(f, g) || anyEdge(g, f);
}

namespace {

/// Calls found(t, other) for pairs of faces that pierce one another, t < other, until it returns false.
template <class Found>
void forPiercingPairs(const TriangleSurface& surface, Found&& found) {
  const SurfaceTree tree(surface);
  std::vector<int> near;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    if (t % 4096 == 0) SetupWatch::check();
    near.clear();
    tree.facesNear(faceBox(surface, t), near);
    std::sort(near.begin(), near.end());
    for (int other : near)
      if (other > t && facesPierce(surface, t, other) && !found(t, other)) return;
  }
}

void checkPiercing(const Subject& s) {
  forPiercingPairs(s.surface, [&](int t, int other) -> bool {
    throw InputError(s.facePlace(t),
                     s.face(t) + " and face " + std::to_string(other + 1) + " pierce one another near " +
                         text(faceBox(s.surface, t).center()),
                     "unite overlapping parts (boolean union) or remove the self-intersection");
  });
}

/// How many other parts lie round part p, by the first of its faces that lies on none of them.
int partsAround(const Subject& s, const SurfaceParts& parts, const std::vector<SurfaceTree>& trees, int p) {
  const int most_tries = std::max(1, 100 / parts.count);
  for (int t = 0, tries = 0; t < s.faceCount() && tries < most_tries; ++t) {
    if (parts.part[t] != p) continue;
    ++tries;
    const auto& [a, b, c] = s.surface.triangles[t];
    const Vec3 &x = s.surface.vertices[a], &y = s.surface.vertices[b], &z = s.surface.vertices[c];
    const Vec3 out = 1e-4 * (y - x).cross(z - x) / (y - x).norm();  // tiny beside the face
    double around = 0;
    bool touches = false;
    for (int other = 0; other < static_cast<int>(trees.size()) && !touches; ++other) {
      if (other == p) continue;
      const double turns = std::round(trees[other].windingNumber((x + y + z) / 3 + out));
      touches = turns != std::round(trees[other].windingNumber((x + y + z) / 3 - out));
      around += turns;
    }
    if (!touches) return static_cast<int>(around);
  }
  return 0;
}

void checkNesting(const Subject& s, const SurfaceParts& parts) {
  const std::vector<TriangleSurface> pieces = separateParts(s.surface, parts);
  std::vector<int> first(parts.count, -1);
  for (int t = s.faceCount() - 1; t >= 0; --t) first[parts.part[t]] = t;
  std::vector<SurfaceTree> trees;
  if (parts.count > 1) {
    for (const TriangleSurface& piece : pieces) trees.emplace_back(piece);
  }
  for (int p = 0; p < parts.count; ++p) {
    const int around = partsAround(s, parts, trees, p), t = first[p];
    const bool outward = signedVolume(pieces[p]) > 0;
    if (around <= 0 && !outward) {
      throw InputError(s.facePlace(t),
                       (parts.count == 1 ? std::string("the surface") : "the part with " + s.face(t)) +
                           " is inside out: its faces are clockwise seen from outside",
                       "reverse all of its faces (\"flip normals\")");
    }
    if (around > 0 && outward) {
      throw InputError(s.facePlace(t), "the part with " + s.face(t) + " lies inside another part",
                       "remove it, or flip its normals if it is a cavity");
    }
    if (around > 1) {
      throw InputError(s.facePlace(t), "the part with " + s.face(t) + " lies inside several other parts",
                       "unite the parts (boolean union)");
    }
  }
}

}  // namespace

void checkSurface(const TriangleSurface& surface, const SurfaceSource& source) {
  const Subject subject{surface, source};
  checkNumbers(subject);
  checkAreas(subject);
  const std::vector<FaceEdge> edges = faceEdges(surface);
  checkEdges(subject, edges);
  const SurfaceParts parts = connectedParts(surface, edges);
  checkOrientation(subject, parts);
  checkPiercing(subject);
  checkNesting(subject, parts);
}

std::vector<int> piercingFaces(const TriangleSurface& surface, int most) {
  std::vector<int> faces;
  forPiercingPairs(surface, [&](int t, int other) {
    faces.insert(faces.end(), {t, other});
    return static_cast<int>(faces.size()) < most;
  });
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  return faces;
}

}  // namespace palpate
