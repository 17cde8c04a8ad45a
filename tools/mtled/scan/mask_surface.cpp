#include "mtled/scan/mask_surface.h"

#include <algorithm>
#include <cmath>

#include "base/input_error.h"
#include "discretization/surface/surface_check.h"
#include "discretization/surface/surface_geometry.h"
#include "discretization/surface/surface_parts.h"
#include "imaging/isosurface.h"
#include "imaging/mask_filter.h"
#include "imaging/remesh.h"
#include "mtled/scan/slices.h"

namespace palpate::tools {
namespace {

constexpr double volume_tolerance = 2e-3;  // of the mask's volume; 5e-3 are promised

/// The largest of a surface's parts.
TriangleSurface largestPart(const TriangleSurface& surface) {
  const std::vector<TriangleSurface> parts = separateParts(surface, connectedParts(surface, faceEdges(surface)));
  return *std::max_element(parts.begin(), parts.end(), [](const TriangleSurface& a, const TriangleSurface& b) {
    return signedVolume(a) < signedVolume(b);
  });
}

/// The zero level of distance - level, in even triangles.
TriangleSurface surfaceAt(const Image& distance, double level, double edge, const Box3& box) {
  const Field field = [&](const Vec3& X) {
    return static_cast<double>(linearValue(distance, distance.grid.indexOf(X))) - level;
  };
  const SampledField sampled = sampleField(field, box.min(), box.max(), 0.8 * edge);
  if (reachesBox(sampled)) throw InputError({}, "the organ reaches the border of its box", "enlarge the mask's image");
  const TriangleSurface rough = isosurface(sampled);
  if (rough.triangles.empty())
    throw InputError({}, "the organ is so thin that no surface is left around it when it is smoothed",
                     "give a finer mask, or smaller --smoothing and --spacing");
  return remesh(largestPart(rough), field, edge);
}

/// The surface with the mask's volume, found by moving the level as far as the volume lacks over the area.
MaskSurface withVolume(const Image& distance, double edge, const Box3& box, double volume) {
  constexpr int attempts = 6;
  MaskSurface best;
  double level = 0;
  for (int k = 0; k < attempts; ++k) {
    TriangleSurface surface = surfaceAt(distance, level, edge, box);
    const double found = signedVolume(surface), area = surfaceArea(surface);
    if (best.surface.triangles.empty() || std::abs(found - volume) < std::abs(best.volume - volume)) {
      best.surface = std::move(surface);
      best.volume = found;
      best.level = level;
    }
    if (std::abs(found - volume) < volume_tolerance * volume) break;
    level += (volume - found) / area;
  }
  return best;
}

double distance95(const TriangleSurface& surface, const Image& border) {
  std::vector<double> d;
  for (const Vec3& X : surface.vertices)
    d.push_back(std::abs(static_cast<double>(linearValue(border, border.grid.indexOf(X)))));
  auto at = d.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(d.size() - 1));
  std::nth_element(d.begin(), at, d.end());
  return *at;
}

}  // namespace

MaskSurface surfaceOf(const Mask& mask, double edge, double smoothing) {
  const double margin = 3 * edge + 4 * smoothing;
  const Mask near = croppedTo(mask, margin);
  const double volume = static_cast<double>(countOf(near)) * near.grid.voxelVolume();
  const Box3 box = boxOf(near, 3 * edge);
  const Image border = signedDistance(near);
  std::string problem;
  for (int attempt = 0; attempt < 3; ++attempt, smoothing *= 2) {
    Image distance = border;
    smooth(distance, smoothing);
    MaskSurface made = withVolume(distance, edge, box, volume);
    made.mask_volume = volume;
    made.smoothing = smoothing;
    made.distance_95 = distance95(made.surface, border);
    try {
      checkSurface(made.surface);
      if (std::abs(made.volume - volume) <= 5e-3 * volume) return made;
      problem = "its volume can't be met";
    } catch (const InputError& error) {
      problem = error.what();
    }
  }
  throw InputError({}, "no closed surface was found around the mask: " + problem,
                   "smooth the mask, or give a larger --smoothing or a smaller --spacing");
}

}  // namespace palpate::tools
