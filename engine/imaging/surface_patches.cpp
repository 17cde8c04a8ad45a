#include "imaging/surface_patches.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "discretization/surface/surface_geometry.h"
#include "discretization/surface/surface_parts.h"

namespace palpate {
namespace {

// A patch nearly closes, so that it has an inside, where its area vectors cancel but for this share: half a ball has
// 0.5.
constexpr double nearly_closed = 0.25;

/// Faces that belong together, and which of them are turned against each other.
class Joined {
 public:
  explicit Joined(std::size_t count) : above_(count), turned_(count, 0) { std::iota(above_.begin(), above_.end(), 0); }

  /// The face that stands for t's patch, and whether t is turned against it.
  std::pair<int, bool> find(int t) {
    bool turned = false;
    int top = t;
    for (; above_[top] != top; top = above_[top]) turned ^= turned_[top] != 0;
    for (bool way = turned; above_[t] != top && t != top;) {  // shortens the way for the next time
      const int next = above_[t];
      const bool step = turned_[t] != 0;
      above_[t] = top;
      turned_[t] = way;
      way ^= step;
      t = next;
    }
    return {top, turned};
  }

  /// False where they are joined already, otherwise than `against` says.
  bool join(int s, int t, bool against) {
    const auto [top_s, turned_s] = find(s);
    const auto [top_t, turned_t] = find(t);
    if (top_s == top_t) return (turned_s != turned_t) == against;
    above_[std::max(top_s, top_t)] = std::min(top_s, top_t);
    turned_[std::max(top_s, top_t)] = (turned_s != turned_t) != against;
    return true;
  }

 private:
  std::vector<int> above_;    // (face count) towards the face that stands for the patch, the lowest
  std::vector<char> turned_;  // (face count) against above_
};

}  // namespace

Vec3 faceMiddle(const TriangleSurface& surface, int t) {
  const auto& [a, b, c] = surface.triangles[t];
  return (surface.vertices[a] + surface.vertices[b] + surface.vertices[c]) / 3;
}

std::vector<Patch> alikePatches(TriangleSurface& surface, std::vector<char>& face_turned) {
  const int count = static_cast<int>(surface.triangles.size());
  std::vector<std::array<FaceEdge, 2>> pairs;
  std::vector<char> open(surface.triangles.size(), 0);  // faces with an edge that is no pair's, or that contradicts
  forEachEdge(faceEdges(surface), [&](const FaceEdge* edge, int faces) {
    if (faces == 2) return pairs.push_back({edge[0], edge[1]});
    for (int k = 0; k < faces; ++k) open[edge[k].triangle] = 1;
  });
  Joined joined(surface.triangles.size());
  for (const bool against : {false, true}) {
    for (const auto& [a, b] : pairs) {
      if ((a.forward == b.forward) != against) continue;
      if (!joined.join(a.triangle, b.triangle, against)) open[a.triangle] = open[b.triangle] = 1;
    }
  }
  std::vector<Patch> patches;
  std::vector<int> number(surface.triangles.size(), -1), turned;
  for (int t = 0; t < count; ++t) {
    const auto [top, against] = joined.find(t);
    if (number[top] < 0) {
      number[top] = static_cast<int>(patches.size());
      patches.emplace_back();
      turned.push_back(0);
    }
    Patch& patch = patches[number[top]];
    patch.faces.push_back(t);
    patch.closed = patch.closed && !open[t];
    turned[number[top]] += against ? 1 : 0;
  }
  for (std::size_t p = 0; p < patches.size(); ++p) {
    Patch& patch = patches[p];
    const bool most = 2 * turned[p] > static_cast<int>(patch.faces.size());
    Vec3 sum = Vec3::Zero(), centre = Vec3::Zero();
    for (const int t : patch.faces) {
      if (joined.find(t).second != most) {
        turnFace(surface.triangles[t]);
        face_turned[t] = 1;
      }
      const Vec3 area = areaVector(surface, t);
      sum += area;
      centre += area.norm() * faceMiddle(surface, t);
      patch.area += area.norm();
    }
    if (patch.area > 0) centre /= patch.area;
    for (const int t : patch.faces)
      patch.volume += areaVector(surface, t).dot(surface.vertices[surface.triangles[t][0]] - centre) / 3;
    patch.has_inside = patch.closed || sum.norm() < nearly_closed * patch.area;
  }
  return patches;
}

}  // namespace palpate
