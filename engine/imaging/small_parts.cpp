#include <algorithm>
#include <map>
#include <numeric>

#include "base/parallel_for.h"
#include "discretization/surface/surface_geometry.h"
#include "discretization/surface/surface_parts.h"
#include "discretization/surface/surface_tree.h"
#include "imaging/mend_surface.h"
#include "imaging/surface_distance.h"

namespace palpate {
namespace {

// Parts touch where this share of the smaller one's surface lies closer to the other than a fraction of the size.
constexpr double contact_gap = 1e-4, contact_share = 2e-3;
// Points at which contact is looked for: of all parts, of one at most, and at least.
constexpr int contact_points = 200'000, most_contact_points = 2000, least_contact_points = 50;

/// Parts that were found to be one body.
class Union {
 public:
  explicit Union(int count) : above_(static_cast<std::size_t>(count)) { std::iota(above_.begin(), above_.end(), 0); }
  int find(int p) {
    while (above_[p] != p) p = above_[p] = above_[above_[p]];
    return p;
  }
  void join(int p, int q) {
    const int a = find(p), b = find(q);
    above_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> above_;  // (part_count) towards the first part of the body
};

double distanceToFace(const Vec3& x, const TriangleSurface& s, int t) {
  const auto& [a, b, c] = s.triangles[t];
  const Vec3 w = closestBarycentric(x, s.vertices[a], s.vertices[b], s.vertices[c]);
  return (w[0] * s.vertices[a] + w[1] * s.vertices[b] + w[2] * s.vertices[c] - x).norm();
}

void joinPiercing(const TriangleSurface& surface, const SurfaceTree& tree, const SurfaceParts& parts,
                  const std::vector<char>& asked, Union& bodies) {
  std::vector<int> near;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    if (t % 4096 == 0) SetupWatch::check();
    const int p = parts.part[t];
    if (!asked[p]) continue;
    near.clear();
    tree.facesNear(faceBox(surface, t), near);
    for (const int other : near)
      if (bodies.find(parts.part[other]) != bodies.find(p) && facesPierce(surface, t, other))
        bodies.join(p, parts.part[other]);
  }
}

/// True where some touch.
bool joinTouching(const TriangleSurface& surface, const SurfaceTree& tree, const SurfaceParts& parts,
                  const std::vector<char>& asked, Union& bodies) {
  const double gap = contact_gap * boundingBox(surface).diagonal().norm();
  const std::vector<TriangleSurface> pieces = separateParts(surface, parts);
  const auto looked_at = std::max<std::ptrdiff_t>(1, std::count(asked.begin(), asked.end(), 1));
  const int count = std::clamp(static_cast<int>(contact_points / looked_at), least_contact_points, most_contact_points);
  bool touching = false;
  std::vector<int> near;
  for (int p = 0; p < parts.count; ++p) {
    if (!asked[p]) continue;
    SetupWatch::check();
    std::map<int, int> found;  // points that touch another part
    for (const Vec3& x : pieces[p].triangles.empty() ? std::vector<Vec3>() : pointsOn(pieces[p], count).x) {
      near.clear();
      tree.facesNear(Box3(x - Vec3::Constant(gap), x + Vec3::Constant(gap)), near);
      std::vector<int> touched;
      for (const int t : near)
        if (bodies.find(parts.part[t]) != bodies.find(p) && distanceToFace(x, surface, t) <= gap)
          touched.push_back(parts.part[t]);
      std::sort(touched.begin(), touched.end());
      touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
      for (const int q : touched) ++found[q];
    }
    for (const auto& [q, points] : found) {
      if (points < std::max(2.0, contact_share * count)) continue;
      bodies.join(p, q);
      touching = true;
    }
  }
  return touching;
}

}  // namespace

Bodies joinedParts(const TriangleSurface& surface, const SurfaceParts& parts, const std::vector<char>& asked) {
  Bodies result;
  Union bodies(parts.count);
  if (parts.count > 1) {
    const SurfaceTree tree(surface);
    joinPiercing(surface, tree, parts, asked, bodies);
    result.touching = joinTouching(surface, tree, parts, asked, bodies);
  }
  for (int p = 0; p < parts.count; ++p)
    result.of_part.push_back(bodies.find(p) == p ? result.count++ : result.of_part[bodies.find(p)]);
  return result;
}

void dropSmallParts(TriangleSurface& surface, SurfaceSource& source, RepairReport& report, double thinnest) {
  std::vector<FaceEdge> pairs;
  forEachEdge(faceEdges(surface), [&](const FaceEdge* edge, int count) {
    if (count == 2) pairs.insert(pairs.end(), {edge[0], edge[1]});
  });
  const SurfaceParts parts = connectedParts(surface, pairs);
  const Vec3 centre = boundingBox(surface).center();
  std::vector<double> volume(parts.count, 0), area(parts.count, 0);
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const Vec3 a = areaVector(surface, t);
    volume[parts.part[t]] += a.dot(surface.vertices[surface.triangles[t][0]] - centre) / 3;
    area[parts.part[t]] += a.norm();
  }
  const double largest = parts.count > 0 ? *std::max_element(volume.begin(), volume.end()) : 0;
  if (!(largest > 0)) return;
  std::vector<char> small(parts.count, 0);
  for (int p = 0; p < parts.count; ++p) small[p] = volume[p] >= 0 && volume[p] < least_part_share * largest;
  std::vector<double> of_body = volume;  // of the body that a small part belongs to
  if (std::count(small.begin(), small.end(), 1) > 0) {
    const Bodies bodies = joinedParts(surface, parts, small);
    std::vector<double> all(bodies.count, 0);
    for (int p = 0; p < parts.count; ++p) all[bodies.of_part[p]] += std::max(0.0, volume[p]);
    for (int p = 0; p < parts.count; ++p) of_body[p] = all[bodies.of_part[p]];
  }
  double whole = 0, dropped = 0, thin = 0;
  std::vector<char> drops(parts.count, 0);
  for (int p = 0; p < parts.count; ++p) {
    whole += std::max(0.0, volume[p]);
    if (volume[p] < 0 ? -volume[p] < least_cavity_share * largest : of_body[p] < least_part_share * largest) {
      drops[p] = 1;
      dropped += std::abs(volume[p]);
      ++(volume[p] < 0 ? report.filled_bubbles : report.small_parts);
    } else if (small[p] && 2 * volume[p] < thinnest * area[p]) {  // a plate's thickness, half a bar's
      drops[p] = 1;
      thin += volume[p];
      ++report.thin_parts;
    }
  }
  // A cavity of a part that goes must go, too, or it bounds nothing: with all the part's faces further in than it
  // is small, it is below the least share as well.
  if (whole > 0) {
    report.small_volume_share += dropped / whole;
    report.thin_volume_share += thin / whole;
  }
  keepFaces(surface, source, [&](int t) { return !drops[parts.part[t]]; });
  dropUnusedVertices(surface, source);
}

}  // namespace palpate
