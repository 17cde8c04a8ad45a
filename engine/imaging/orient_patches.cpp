#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "base/parallel_for.h"
#include "discretization/surface/surface_geometry.h"
#include "discretization/surface/surface_tree.h"
#include "imaging/mend_surface.h"
#include "imaging/surface_patches.h"

namespace palpate {
namespace {

// Rays in all, and of one patch and side.
constexpr int ray_budget = 300'000, least_rays = 4, most_rays = 2000;
// A ray starts this fraction of the surface's size off its face.
constexpr double ray_start = 1e-6;
// Of the rays of both sides: below it a patch is not seen from outside.
constexpr double hidden_share = 0.01;
// An open sheet is seen from both sides where the one lets so much of the other's rays through.
constexpr double sheet_share = 0.6;
// A patch lies inside where the winding number of the others is above this at most of so many of its points.
constexpr double inside_winding = 0.6, inside_share = 0.9;
constexpr int inside_points = 16;
/// A number in 0 .. 1 that depends on nothing but k; neighbouring k are far apart.
double spread(std::uint64_t k, double step) { return std::fmod(0.5 + static_cast<double>(k) * step, 1.0); }

/// Counts the rays that escape from each patch's front and back.
void castRays(const TriangleSurface& surface, const SurfaceTree& tree, std::vector<Patch>& patches) {
  double area = 0;
  for (const Patch& patch : patches) area += patch.area;
  const double size = boundingBox(surface).diagonal().norm();
  parallelFor(
      static_cast<int>(patches.size()),
      [&](int begin, int end) {
        std::vector<double> sum;
        for (int p = begin; p < end; ++p) {
          Patch& patch = patches[p];
          const double share = area > 0 ? patch.area / area : 0;
          const int least = std::clamp(ray_budget / 2 / static_cast<int>(patches.size()), 2, least_rays);
          patch.rays = std::clamp(static_cast<int>(share * most_rays), least, most_rays);
          sum.assign(1, 0);
          for (const int t : patch.faces) sum.push_back(sum.back() + areaVector(surface, t).norm());
          for (int k = 0; k < patch.rays; ++k) {
            // A face by its area, a point of it, a direction with the cosine of its angle to the normal as density.
            const double at = sum.back() * (k + 0.5) / patch.rays;
            const auto place = std::upper_bound(sum.begin() + 1, sum.end() - 1, at) - sum.begin() - 1;
            const int t = patch.faces[static_cast<std::size_t>(place)];
            const std::uint64_t draw = static_cast<std::uint64_t>(t) * 7 + static_cast<std::uint64_t>(k);
            const double r = std::sqrt(spread(draw, 0.7548776662466927)), s = spread(draw, 0.5698402909980532);
            const auto& [a, b, c] = surface.triangles[t];
            const Vec3 x =
                (1 - r) * surface.vertices[a] + r * (1 - s) * surface.vertices[b] + r * s * surface.vertices[c];
            const Vec3 n = areaVector(surface, t).stableNormalized(), e1 = n.unitOrthogonal(), e2 = n.cross(e1);
            const double sine = std::sqrt(0.98 * spread(draw, 0.8191725133961645));
            const double angle = 2 * std::numbers::pi * spread(draw, 0.6710436067037893);
            const Vec3 flat = sine * (std::cos(angle) * e1 + std::sin(angle) * e2);
            const Vec3 up = std::sqrt(1 - sine * sine) * n;
            if (!tree.firstHit(x + ray_start * size * n, flat + up)) ++patch.front;
            if (!tree.firstHit(x - ray_start * size * n, flat - up)) ++patch.back;
          }
        }
      },
      1);
}

/// The faces of all patches that stay, turned as their patches are.
TriangleSurface asTurned(const TriangleSurface& surface, const std::vector<Patch>& patches) {
  TriangleSurface result;
  result.vertices = surface.vertices;
  for (const Patch& patch : patches) {
    if (patch.removed) continue;
    for (const int t : patch.faces) {
      result.triangles.push_back(surface.triangles[t]);
      if (patch.turned) turnFace(result.triangles.back());
    }
  }
  return result;
}

/// Winding numbers of all patches, as they are turned, on both sides of faces.
class BothSides {
 public:
  BothSides(const TriangleSurface& surface, const std::vector<Patch>& patches)
      : surface_(surface), tree_(asTurned(surface, patches)), off_(1e-4 * boundingBox(surface).diagonal().norm()) {}

  /// In front of a face, as the file turns it, and behind it.
  std::pair<double, double> at(int t) const {
    const Vec3 x = faceMiddle(surface_, t), n = off_ * areaVector(surface_, t).stableNormalized();
    return {tree_.windingNumber(x + n), tree_.windingNumber(x - n)};
  }

  /// Of the other patches: a closed patch turned outward adds 1/2 to the mean of both sides, a sheet nothing.
  double ofOthers(const Patch& patch, int t) const {
    const auto [front, back] = at(t);
    return 0.5 * (front + back) - (patch.has_inside ? 0.5 : 0);
  }

 private:
  const TriangleSurface& surface_;
  SurfaceTree tree_;
  double off_;
};

/// Which patches with an inside lie inside others: of these the ones that face inward in the file, as far as the file
/// itself faces outward, are cavities; the others go. All others face outward.
void judgeNested(std::vector<Patch>& patches, const BothSides& sides) {
  double turned = 0, all = 0;
  for (Patch& patch : patches) {
    if (patch.removed) continue;
    if (patch.has_inside) {
      const int count = static_cast<int>(patch.faces.size()), points = std::min(count, inside_points);
      int inside = 0;
      for (int k = 0; k < points; ++k) {
        const int t = patch.faces[static_cast<std::size_t>(static_cast<long long>(count) * k / points)];
        inside += sides.ofOthers(patch, t) > inside_winding ? 1 : 0;
      }
      patch.nested = inside >= inside_share * points;
    }
    if (patch.nested || patch.hidden) continue;
    all += patch.area;
    if (patch.turned) turned += patch.area;
  }
  const bool inside_out = 2 * turned > all;
  for (Patch& patch : patches) {
    if (!patch.nested) continue;
    const bool inward = (patch.volume < 0) != inside_out;
    patch.removed = !inward;
    patch.hidden = true;
    patch.turned = patch.volume > 0;
  }
}

/// Sheets that are not seen from outside go where they are inside; in a deep fold they stay, with their front where the
/// winding number is lower.
void judgeHidden(std::vector<Patch>& patches, const BothSides& sides) {
  for (Patch& patch : patches) {
    if (!patch.hidden || patch.removed || patch.has_inside) continue;
    const int t = patch.faces[patch.faces.size() / 2];
    patch.removed = sides.ofOthers(patch, t) > inside_winding;
    const auto [front, back] = sides.at(t);
    patch.turned = front > back;
  }
}

/// Open sheets that are seen from both sides bound nothing: they go where something is left without them.
void judgeSheets(std::vector<Patch>& patches) {
  const auto isSheet = [](const Patch& p) {
    return !p.has_inside && !p.hidden && std::min(p.front, p.back) > sheet_share * std::max(p.front, p.back);
  };
  double sheets = 0, all = 0;
  for (const Patch& patch : patches) {
    all += patch.area;
    if (isSheet(patch)) sheets += patch.area;
  }
  constexpr double least_rest = 0.2;  // of the area
  if (sheets > (1 - least_rest) * all) return;
  for (Patch& patch : patches) patch.removed = patch.removed || isSheet(patch);
}

void judgePatches(const TriangleSurface& surface, std::vector<Patch>& patches) {
  if (patches.size() == 1 && patches[0].closed) {
    patches[0].turned = patches[0].volume < 0;
    return;
  }
  castRays(surface, SurfaceTree(surface), patches);
  for (Patch& patch : patches) {
    patch.hidden = patch.front + patch.back <= hidden_share * 2 * patch.rays;
    patch.turned = patch.has_inside ? patch.volume < 0 : !patch.hidden && patch.back > patch.front;
  }
  judgeSheets(patches);
  const BothSides sides(surface, patches);
  judgeNested(patches, sides);
  judgeHidden(patches, sides);
}

}  // namespace

void orientPatches(TriangleSurface& surface, SurfaceSource& source, RepairReport& report) {
  const std::size_t count = surface.triangles.size();
  std::vector<char> turned(count, 0), removed(count, 0);
  std::vector<Patch> patches = alikePatches(surface, turned);
  judgePatches(surface, patches);
  for (const Patch& patch : patches) {
    for (const int t : patch.faces) {
      if (patch.turned) {
        turnFace(surface.triangles[t]);
        turned[t] ^= 1;
      }
      removed[t] = patch.removed;
    }
    if (patch.removed) ++(patch.hidden ? report.inner_sheets : report.loose_sheets);
  }
  double inner = 0, outer = 0;
  for (const Patch& patch : patches) {
    if (patch.removed || patch.hidden || patch.rays == 0) continue;
    inner += patch.area * std::min(patch.front, patch.back) / patch.rays;
    outer += patch.area * std::max(patch.front, patch.back) / patch.rays;
  }
  report.see_through = outer > 0 ? inner / outer : 0;
  int turned_count = 0;
  keepFaces(surface, source, [&](int t) {
    if (!removed[t]) turned_count += turned[t];
    return !removed[t];
  });
  report.turned_faces += turned_count;
  report.inside_out = turned_count > 0 && turned_count == static_cast<int>(surface.triangles.size());
  dropUnusedVertices(surface, source);
}

}  // namespace palpate
