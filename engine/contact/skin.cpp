#include "contact/skin.h"

#include <algorithm>
#include <numeric>

namespace palpate {
namespace {

/// Vertices per cluster: a cluster costs about as much to reject as a vertex to test.
constexpr int kClusterSize = 32;

/// Vertices per region of clusters: some 16 clusters cost as much as the regions of a large skin.
constexpr int kRegionSize = 16 * kClusterSize;

/// Bisects [first, last) across its widest extent until clusters are small enough; notes where regions begin.
void bisect(const std::vector<Vec3>& X, int first, int last, bool in_region, SkinModel& skin) {
  std::vector<int>& order = skin.cluster_vertex;
  if (!in_region && last - first <= kRegionSize) {
    bisect(X, first, last, true, skin);
    skin.region_begin.push_back(static_cast<int>(skin.cluster_begin.size()) - 1);
    return;
  }
  if (last - first <= kClusterSize) {
    skin.cluster_begin.push_back(last);
    return;
  }
  Box3 box;
  for (int k = first; k < last; ++k) box.extend(X[order[k]]);
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const int middle = (first + last) / 2;
  std::nth_element(order.begin() + first, order.begin() + middle, order.begin() + last,
                   [&](int a, int b) { return X[a][axis] != X[b][axis] ? X[a][axis] < X[b][axis] : a < b; });
  bisect(X, first, middle, in_region, skin);
  bisect(X, middle, last, in_region, skin);
}

/// The vertex nearest to the centre of some, and how far they are from it.
void addSphere(const std::vector<Vec3>& X, const int* first, const int* last, std::vector<int>& representatives,
               std::vector<float>& radii) {
  Vec3 centre = Vec3::Zero();
  for (auto v = first; v != last; ++v) centre += X[*v] / static_cast<double>(last - first);
  const int representative = *std::min_element(
      first, last, [&](int a, int b) { return (X[a] - centre).squaredNorm() < (X[b] - centre).squaredNorm(); });
  double radius = 0.0;
  for (auto v = first; v != last; ++v) radius = std::max(radius, (X[*v] - X[representative]).norm());
  representatives.push_back(representative);
  radii.push_back(static_cast<float>(radius));
}

void makeClusters(SkinModel& skin) {
  const std::vector<Vec3>& X = skin.surface.vertices;
  skin.cluster_vertex.resize(X.size());
  std::iota(skin.cluster_vertex.begin(), skin.cluster_vertex.end(), 0);
  skin.cluster_begin.assign(1, 0);
  skin.region_begin.assign(1, 0);
  if (!X.empty()) bisect(X, 0, static_cast<int>(X.size()), false, skin);

  int* const vertex = skin.cluster_vertex.data();
  for (std::size_t c = 0; c + 1 < skin.cluster_begin.size(); ++c) {
    int* const first = vertex + skin.cluster_begin[c];
    int* const last = vertex + skin.cluster_begin[c + 1];
    std::sort(first, last);
    addSphere(X, first, last, skin.cluster_representative, skin.cluster_radius);
  }
  for (std::size_t r = 0; r + 1 < skin.region_begin.size(); ++r)
    addSphere(X, vertex + skin.cluster_begin[skin.region_begin[r]],
              vertex + skin.cluster_begin[skin.region_begin[r + 1]], skin.region_representative, skin.region_radius);
}

}  // namespace

void setRows(const ShapeTable& shape, SkinModel& skin) {
  skin.begin = shape.begin;
  skin.node = shape.node;
  skin.N.assign(shape.N.begin(), shape.N.end());
}

SkinModel buildSkinModel(const TriangleSurface& surface, const ShapeTable& shape) {
  SkinModel skin;
  skin.surface = surface;
  skin.area.assign(surface.vertices.size(), 0.0);
  for (const auto& [a, b, c] : surface.triangles) {
    const Vec3 edge = surface.vertices[b] - surface.vertices[a];
    const double third = edge.cross(surface.vertices[c] - surface.vertices[a]).norm() / 6.0;
    for (int v : {a, b, c}) skin.area[v] += third;
  }
  setRows(shape, skin);
  makeClusters(skin);
  return skin;
}

double layerDepth(double tool_radius, double spacing) {
  // Of the radius. Larger: light touches read low (a sphere 0.03 R deep by about 1.5 %, in proportion) and penetration
  // shows. Smaller: more sweeps per step, and vertices knock as they enter, by about v sqrt(m_eff k a_v) where m_eff is
  // the mass that the vertex feels. From 0.0005 to 0.01 the force at 10 mm/s is smooth alike. A wide tool's layer is no
  // deeper than that of one for which the nodes are made: a ball of 0.3 m lost 17 %.
  constexpr double share = 0.002, spacings = 2;
  return share * std::min(tool_radius, spacings * spacing);
}

double layerModulus(double bulk_modulus, double shear_modulus) {
  return std::max(3 * shear_modulus, (bulk_modulus + 4 * shear_modulus / 3) / 10);
}

bool isInside(const SkinModel& skin, const Float4* u, const Vec3& point, std::vector<Vec3f>& position) {
  for (std::size_t v = 0; v < position.size(); ++v)
    position[v] = (skinPosition(skin, static_cast<int>(v), u) - point).cast<float>();
  // Whether the origin is to the left of the way from a to b, seen along z; on it for one of two opposite ways.
  const auto isLeft = [](const Vec3f& a, const Vec3f& b) {
    const double ab = static_cast<double>(a.x()) * b.y(), ba = static_cast<double>(b.x()) * a.y();
    return ab > ba || (ab == ba && (a.x() < b.x() || (a.x() == b.x() && a.y() < b.y())));
  };
  int around = 0;
  for (const auto& t : skin.surface.triangles) {
    const Vec3f &a = position[t[0]], &b = position[t[1]], &c = position[t[2]];
    const bool left = isLeft(a, b);
    if (isLeft(b, c) != left || isLeft(c, a) != left) continue;
    if ((a.dot((b - a).cross(c - a)) > 0) == left) around += left ? 1 : -1;  // it is above
  }
  return around != 0;
}

}  // namespace palpate
