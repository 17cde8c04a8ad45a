#include "discretization/surface/solids.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <tuple>

#include "discretization/surface/patch_mesh.h"
#include "discretization/surface/surface_geometry.h"

namespace palpate {

namespace {

using std::numbers::pi;

// Rows of near-equilateral triangles stand sqrt(3)/2 edges apart; a little more where
// neighbouring rows do not have the same count.
constexpr double row_distance = 0.9;

void requirePositive(const char* what, double value) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw std::invalid_argument(std::string(what) + " must be a positive length");
  }
}

// Refuses what would fill the memory: a typing error in the scene, such as millimetres for metres.
void requireSensibleCount(double area, double edge) {
  constexpr double max_faces = 4e6;
  const double face = std::sqrt(3.0) / 4.0 * edge * edge;
  if (!(area / face < max_faces)) {
    throw std::invalid_argument("the edge length is too small for the solid: more than 4 million faces");
  }
}

int divisions(double length, double step, int least) {
  return std::max(least, static_cast<int>(std::lround(length / step)));
}

/// Arc length along the ellipse (a cos t, b sin t), by the midpoint rule: from a fraction of it to t.
class EllipseArc {
 public:
  EllipseArc(double a, double b, double from = 0, double to = 2 * pi) : from_(from), to_(to) {
    length_.assign(samples + 1, 0.0);
    for (int i = 1; i <= samples; ++i) {
      const double middle = parameter(i - 0.5);
      length_[i] = length_[i - 1] + std::hypot(a * std::sin(middle), b * std::cos(middle)) * (to - from) / samples;
    }
  }
  double length() const { return length_.back(); }

  /// Parameter at a fraction of the arc's length.
  double at(double fraction) const {
    const double target = fraction * length();
    const auto above = std::upper_bound(length_.begin() + 1, length_.end() - 1, target);
    const int i = static_cast<int>(above - length_.begin());
    return parameter(i - 1 + (target - length_[i - 1]) / (length_[i] - length_[i - 1]));
  }

 private:
  static constexpr int samples = 1440;
  double parameter(double sample) const { return from_ + (to_ - from_) * sample / samples; }

  double from_, to_;
  std::vector<double> length_;
};

/// A ring of vertices on an ellipse parallel to the xy plane. `count` points, shifted by `phase` steps.
std::vector<int> addRing(PatchMesh& mesh, double a, double b, double z, int count, double phase, int patch) {
  const EllipseArc arc(a, b);
  std::vector<int> ring;
  for (int i = 0; i < count; ++i) {
    const double t = arc.at((i + phase) / count);
    ring.push_back(mesh.addVertex({a * std::cos(t), b * std::sin(t), z}, patch));
  }
  return ring;
}

/// Fills the flat ellipse inside `rim` by shrinking rings; its faces point up or down.
void addDisc(PatchMesh& mesh, const std::vector<int>& rim, double a, double b, double z, double edge, bool upward,
             int patch) {
  const int rings = divisions(0.5 * (a + b), row_distance * edge, 1);
  std::vector<int> outer = rim;
  for (int k = rings - 1; k >= 0; --k) {
    std::vector<int> inner;
    if (k == 0) {
      inner.push_back(mesh.addVertex({0, 0, z}, patch));
    } else {
      const double share = static_cast<double>(k) / rings;
      const int count = divisions(share * static_cast<double>(rim.size()), 1.0, 5);
      inner = addRing(mesh, share * a, share * b, z, count, 0.5 * (k % 2), patch);
    }
    upward ? mesh.bridgeRings(outer, inner, patch) : mesh.bridgeRings(inner, outer, patch);
    outer = std::move(inner);
  }
}

/// The point of an ellipsoid near x, by Newton steps along the gradient of sum (x_k / s_k)^2 - 1.
Vec3 projectToEllipsoid(Vec3 x, const Vec3& semi_axes) {
  constexpr int max_steps = 50;
  for (int step = 0; step < max_steps; ++step) {
    const Vec3 scaled = x.cwiseQuotient(semi_axes);
    const double excess = scaled.squaredNorm() - 1;
    if (std::abs(excess) < 1e-14) break;
    const Vec3 gradient = 2 * scaled.cwiseQuotient(semi_axes);
    x -= excess / gradient.squaredNorm() * gradient;
  }
  return x;
}

/// Flat faces cut the corners of a round solid: stretches it, in the given directions, to the solid's own volume.
TriangleSurface stretched(TriangleSurface surface, double volume, bool along_z) {
  const double ratio = volume / signedVolume(surface), factor = along_z ? std::cbrt(ratio) : std::sqrt(ratio);
  for (Vec3& x : surface.vertices) x = x.cwiseProduct(Vec3(factor, factor, along_z ? factor : 1));
  return surface;
}

/// Rings of an ellipsoid from the lower pole, or for the upper half from the rim at z = 0, to the upper pole.
TriangleSurface ellipsoid(const Vec3& s, double edge, bool upper_half) {
  for (int k = 0; k < 3; ++k) requirePositive("an ellipsoid's semi-axis", s[k]);
  requirePositive("the edge length", edge);
  requireSensibleCount(4 * pi * s.maxCoeff() * (s.sum() - s.maxCoeff()) / 2, edge);
  constexpr int dome = 0, base = 1;
  PatchMesh mesh;
  const EllipseArc meridian(0.5 * (s.x() + s.y()), s.z(), upper_half ? 0 : -pi / 2, pi / 2);
  const int rows = divisions(meridian.length(), row_distance * edge, upper_half ? 2 : 4);
  std::vector<int> below;
  for (int k = 0; k <= rows; ++k) {
    const double latitude = meridian.at(static_cast<double>(k) / rows);
    const double r = std::cos(latitude), z = s.z() * std::sin(latitude);
    std::vector<int> ring;
    if (k == rows || (k == 0 && !upper_half)) {
      ring.push_back(mesh.addVertex({0, 0, k == 0 ? -s.z() : s.z()}, dome));
    } else {
      const bool rim = k == 0;
      const int count = divisions(EllipseArc(s.x() * r, s.y() * r).length(), edge, 5);
      ring =
          addRing(mesh, s.x() * r, s.y() * r, rim ? 0.0 : z, count, 0.5 * (k % 2), rim ? PatchMesh::held_vertex : dome);
    }
    if (k > 0) mesh.bridgeRings(below, ring, dome);
    if (k == 0 && upper_half) addDisc(mesh, ring, s.x(), s.y(), 0, edge, false, base);
    below = std::move(ring);
  }
  mesh.relax(
      [&](int patch, const Vec3& x) { return patch == base ? Vec3(x.x(), x.y(), 0) : projectToEllipsoid(x, s); });
  return stretched(std::move(mesh.surface), (upper_half ? 2.0 : 4.0) / 3 * pi * s.prod(), true);
}

}  // namespace

TriangleSurface boxSurface(const Vec3& size, double edge) {
  for (int k = 0; k < 3; ++k) requirePositive("a box's size", size[k]);
  requirePositive("the edge length", edge);
  requireSensibleCount(2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x()), edge);
  const Vec3 corner(-0.5 * size.x(), -0.5 * size.y(), 0);
  const std::array<int, 3> n = {divisions(size.x(), edge, 1), divisions(size.y(), edge, 1),
                                divisions(size.z(), edge, 1)};
  PatchMesh mesh;

  // Points of the twelve edges, by their place in the lattice of divisions, shared by two or three faces.
  std::map<std::array<int, 3>, int> edge_vertices;
  const auto edgeVertex = [&](const std::array<int, 3>& at) {
    const auto [entry, fresh] = edge_vertices.try_emplace(at, -1);
    if (fresh) {
      Vec3 x = corner;
      for (int k = 0; k < 3; ++k) x[k] += size[k] * at[k] / n[k];
      entry->second = mesh.addVertex(x, PatchMesh::held_vertex);
    }
    return entry->second;
  };

  for (int face = 0; face < 6; ++face) {
    // Axes u and v span the face so that u x v points outward.
    const int axis = face / 2;
    const bool far = face % 2 == 1;
    const int u = far ? (axis + 1) % 3 : (axis + 2) % 3, v = far ? (axis + 2) % 3 : (axis + 1) % 3;
    std::vector<int> below;
    for (int row = 0; row <= n[v]; ++row) {
      std::array<int, 3> at{};
      at[axis] = far ? n[axis] : 0;
      at[v] = row;
      const bool border = row == 0 || row == n[v];
      // Every other inner row has a point more: staggered rows make the triangles equilateral.
      const int count = border ? n[u] : n[u] + row % 2;
      std::vector<int> points;
      for (int i = 0; i <= count; ++i) {
        if (border || i == 0 || i == count) {
          at[u] = border ? i : (i == 0 ? 0 : n[u]);
          points.push_back(edgeVertex(at));
        } else {
          Vec3 x = corner;
          x[axis] += far ? size[axis] : 0.0;
          x[u] += size[u] * i / count;
          x[v] += size[v] * row / n[v];
          points.push_back(mesh.addVertex(x, face));
        }
      }
      if (row > 0) mesh.bridgeRows(below, points, face);
      below = std::move(points);
    }
  }
  mesh.relax([&](int face, Vec3 x) {
    x[face / 2] = corner[face / 2] + (face % 2 == 1 ? size[face / 2] : 0.0);
    return x;
  });
  return mesh.surface;
}

TriangleSurface cylinderSurface(double radius, double height, double edge) {
  requirePositive("a cylinder's radius", radius);
  requirePositive("a cylinder's height", height);
  requirePositive("the edge length", edge);
  requireSensibleCount(2 * pi * radius * (radius + height), edge);
  constexpr int base = 0, side = 1, top = 2;
  const int count = divisions(2 * pi * radius, edge, 6);
  const int rows = divisions(height, row_distance * edge, 1);
  PatchMesh mesh;
  std::vector<int> below;
  for (int row = 0; row <= rows; ++row) {
    const bool rim = row == 0 || row == rows;
    std::vector<int> ring =
        addRing(mesh, radius, radius, height * row / rows, count, 0.5 * (row % 2), rim ? PatchMesh::held_vertex : side);
    if (row == 0) addDisc(mesh, ring, radius, radius, 0, edge, false, base);
    if (row > 0) mesh.bridgeRings(below, ring, side);
    if (row == rows) addDisc(mesh, ring, radius, radius, height, edge, true, top);
    below = std::move(ring);
  }
  mesh.relax([&](int patch, const Vec3& x) {
    if (patch != side) return Vec3(x.x(), x.y(), patch == base ? 0.0 : height);
    const double scale = radius / std::hypot(x.x(), x.y());
    return Vec3(scale * x.x(), scale * x.y(), x.z());
  });
  return stretched(std::move(mesh.surface), pi * radius * radius * height, false);
}

TriangleSurface ellipsoidSurface(const Vec3& semi_axes, double edge) { return ellipsoid(semi_axes, edge, false); }

TriangleSurface halfEllipsoidSurface(const Vec3& semi_axes, double edge) { return ellipsoid(semi_axes, edge, true); }

}  // namespace palpate
