#include "app/render/cut_body.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "approximation/shape_functions.h"
#include "discretization/cells/delaunay.h"
#include "setup/body_points.h"

namespace palpate::app {
namespace {

using Point2 = Eigen::Vector2d;

/// Coordinates in the plane: (u, v, normal) is right-handed.
struct PlaneFrame {
  Vec3 origin, u, v, normal;

  explicit PlaneFrame(const CutPlane& plane) : origin(plane.point), normal(plane.normal.normalized()) {
    u = normal.unitOrthogonal();
    v = normal.cross(u);
  }
  double height(const Vec3& x) const { return normal.dot(x - origin); }
  Point2 flat(const Vec3& x) const { return {u.dot(x - origin), v.dot(x - origin)}; }
  Vec3 lifted(const Point2& p) const { return origin + p.x() * u + p.y() * v; }
};

/// A clipped surface, still open along the plane.
struct Clipped {
  TriangleSurface surface;
  std::vector<int> old_vertex;          // (vertices) in the whole surface; -1: new, on the plane
  std::vector<std::array<int, 2>> rim;  // edges along the plane
};

Clipped clip(const TriangleSurface& whole, const PlaneFrame& plane, double edge) {
  // Vertices nearer than this to the plane are taken to lie in it: cutting beside them would give
  // triangles without area.
  const double near = 1e-4 * edge;
  Clipped clipped;
  std::vector<double> height;
  for (const Vec3& X : whole.vertices) height.push_back(std::abs(plane.height(X)) < near ? 0 : plane.height(X));
  std::vector<int> kept(whole.vertices.size(), -1);
  const auto keep = [&](int v) {
    if (kept[v] < 0) {
      kept[v] = static_cast<int>(clipped.surface.vertices.size());
      clipped.surface.vertices.push_back(whole.vertices[v]);
      clipped.old_vertex.push_back(v);
    }
    return kept[v];
  };
  std::map<std::array<int, 2>, int> crossing;
  const auto cross = [&](int a, int b) {
    const auto [entry, fresh] =
        crossing.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(clipped.surface.vertices.size()));
    if (fresh) {
      const double t = height[a] / (height[a] - height[b]);
      clipped.surface.vertices.push_back(whole.vertices[a] + t * (whole.vertices[b] - whole.vertices[a]));
      clipped.old_vertex.push_back(-1);
    }
    return entry->second;
  };
  for (const auto& t : whole.triangles) {
    if (height[t[0]] >= 0 && height[t[1]] >= 0 && height[t[2]] >= 0) continue;
    std::vector<int> corners;
    std::vector<bool> in_plane;
    for (int c = 0; c < 3; ++c) {
      const int a = t[c], b = t[(c + 1) % 3];
      if (height[a] <= 0) {
        corners.push_back(keep(a));
        in_plane.push_back(height[a] == 0);
      }
      if (height[a] * height[b] < 0) {
        corners.push_back(cross(a, b));
        in_plane.push_back(true);
      }
    }
    const std::size_t count = corners.size();
    for (std::size_t k = 2; k < count; ++k)
      clipped.surface.triangles.push_back({corners[0], corners[k - 1], corners[k]});
    for (std::size_t k = 0; k < count; ++k)
      if (in_plane[k] && in_plane[(k + 1) % count]) clipped.rim.push_back({corners[k], corners[(k + 1) % count]});
  }
  return clipped;
}

/// Even-odd rule.
bool inside(const std::vector<std::array<Point2, 2>>& rim, const Point2& p) {
  bool in = false;
  for (const auto& [a, b] : rim)
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      in = !in;
  return in;
}

double distance(const std::vector<std::array<Point2, 2>>& rim, const Point2& p) {
  double least = 1e300;
  for (const auto& [a, b] : rim) {
    const double length2 = std::max((b - a).squaredNorm(), 1e-300);
    const double t = std::clamp((p - a).dot(b - a) / length2, 0.0, 1.0);
    least = std::min(least, (a + t * (b - a) - p).norm());
  }
  return least;
}

/// Delaunay triangles of points in a plane: with one apex over it, the tetrahedra's bases, since a
/// sphere through a base meets the plane in the base's circle.
std::vector<std::array<int, 3>> planeDelaunay(const std::vector<Point2>& points) {
  std::vector<Vec3> X;
  Eigen::AlignedBox2d box;
  for (const Point2& p : points) {
    X.emplace_back(p.x(), p.y(), 0);
    box.extend(p);
  }
  const int apex = static_cast<int>(X.size());
  X.emplace_back(box.center().x(), box.center().y(), box.diagonal().norm());
  std::vector<std::array<int, 3>> triangles;
  for (const auto& cell : delaunay(X)) {
    std::array<int, 3> base{};
    int count = 0;
    for (const int v : cell)
      if (v != apex && count < 3) base[count++] = v;
    if (std::count(cell.begin(), cell.end(), apex) != 1) continue;
    const Point2 a = points[base[1]] - points[base[0]], b = points[base[2]] - points[base[0]];
    if (a.x() * b.y() - a.y() * b.x() < 0) std::swap(base[1], base[2]);
    triangles.push_back(base);
  }
  return triangles;
}

/// Closes the surface along the plane with triangles of about `edge` in size. They have vertices of
/// their own on the rim, so that it is drawn as a sharp edge, however flat it is.
void addSection(Clipped& clipped, const PlaneFrame& plane, double edge) {
  if (clipped.rim.size() < 3) return;
  std::vector<std::array<Point2, 2>> rim;
  std::vector<int> vertex;  // of the surface, per point
  std::vector<Point2> points;
  Eigen::AlignedBox2d box;
  for (const auto& [a, b] : clipped.rim) {
    rim.push_back({plane.flat(clipped.surface.vertices[a]), plane.flat(clipped.surface.vertices[b])});
    vertex.push_back(a);
    vertex.push_back(b);
  }
  std::sort(vertex.begin(), vertex.end());
  vertex.erase(std::unique(vertex.begin(), vertex.end()), vertex.end());
  for (int& v : vertex) {
    const Vec3 X = clipped.surface.vertices[v];
    const int old = clipped.old_vertex[v];
    points.push_back(plane.flat(X));
    box.extend(points.back());
    v = static_cast<int>(clipped.surface.vertices.size());
    clipped.surface.vertices.push_back(X);
    clipped.old_vertex.push_back(old);
  }
  const double row = 0.5 * std::sqrt(3.0) * edge;
  for (int j = 0; box.min().y() + j * row < box.max().y(); ++j)
    for (int i = 0; box.min().x() + (i - 1) * edge < box.max().x(); ++i) {
      const Point2 p = box.min() + Point2((i + 0.5 * (j % 2)) * edge, j * row);
      if (!inside(rim, p) || distance(rim, p) < 0.6 * edge) continue;
      points.push_back(p);
      vertex.push_back(static_cast<int>(clipped.surface.vertices.size()));
      clipped.surface.vertices.push_back(plane.lifted(p));
      clipped.old_vertex.push_back(-1);
    }
  for (const auto& t : planeDelaunay(points))
    if (inside(rim, (points[t[0]] + points[t[1]] + points[t[2]]) / 3))
      clipped.surface.triangles.push_back({vertex[t[0]], vertex[t[1]], vertex[t[2]]});
}

template <class Rows>
void appendRow(SkinModel& to, const Rows& from, int row) {
  for (int k = from.begin[row]; k < from.begin[row + 1]; ++k) {
    to.node.push_back(from.node[k]);
    to.N.push_back(static_cast<float>(from.N[k]));
  }
  to.begin.push_back(static_cast<int>(to.node.size()));
}

/// Old vertices keep their rows; new ones get theirs from the nodes around them.
void addRows(const Body& model, const Clipped& clipped, SkinModel& skin) {
  std::vector<Vec3> points;
  std::vector<int> row(clipped.old_vertex.size(), -1);
  for (std::size_t v = 0; v < row.size(); ++v)
    if (clipped.old_vertex[v] < 0) {
      row[v] = static_cast<int>(points.size());
      points.push_back(clipped.surface.vertices[v]);
    }
  const ShapeTable table = shapeAt(model, points);
  skin.begin.assign(1, 0);
  for (std::size_t v = 0; v < row.size(); ++v) {
    if (row[v] < 0)
      appendRow(skin, model.skin, clipped.old_vertex[v]);
    else
      appendRow(skin, table, row[v]);
  }
}

}  // namespace

CutBody cutBody(const Body& model, const CutPlane& plane) {
  const PlaneFrame frame(plane);
  double length = 0;
  for (const auto& t : model.skin.surface.triangles)
    length += (model.skin.surface.vertices[t[1]] - model.skin.surface.vertices[t[0]]).norm();
  const double edge = length / static_cast<double>(std::max<std::size_t>(1, model.skin.surface.triangles.size()));
  Clipped clipped = clip(model.skin.surface, frame, edge);
  if (clipped.surface.triangles.empty()) throw std::invalid_argument("the cut plane leaves nothing of the body");
  addSection(clipped, frame, edge);

  CutBody cut;
  cut.scene = model.scene;
  cut.X = model.X;
  cut.node_organ = model.node_organ;
  cut.support_radius = model.support_radius;
  cut.imposed = model.imposed;
  cut.point_X = model.point_X;
  cut.point_volume = model.point_volume;
  cut.point_material = model.point_material;
  cut.point_shape = model.point_shape;
  cut.materials = model.materials;
  cut.tools = model.tools;
  addRows(model, clipped, cut.skin);
  cut.skin.area.assign(clipped.surface.vertices.size(), 0.0);
  for (const auto& t : clipped.surface.triangles) {
    const Vec3& a = clipped.surface.vertices[t[0]];
    const double third = (clipped.surface.vertices[t[1]] - a).cross(clipped.surface.vertices[t[2]] - a).norm() / 6;
    for (const int v : t) cut.skin.area[v] += third;
  }
  cut.skin.surface = std::move(clipped.surface);
  cut.whole_vertex = std::move(clipped.old_vertex);
  return cut;
}

}  // namespace palpate::app
