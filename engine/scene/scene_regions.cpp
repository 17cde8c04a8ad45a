#include "scene/scene_regions.h"

namespace palpate {

bool contains(const Region& region, const Vec3& x, const SurfaceTree& organ) {
  constexpr double tolerance = 1e-9;  // m; nodes that were put on a plane are on it
  if (region.kind != Region::Kind::Shell) return region.contains(x, tolerance);
  return region.contains(x, tolerance, organ.closest(x, region.distance + 2 * tolerance).distance);
}

int materialAt(const Scene& scene, const Vec3& x, const SurfaceTree& organ) {
  for (int m = static_cast<int>(scene.materials.size()) - 1; m > 0; --m)
    if (!scene.materials[m].membership &&
        (scene.materials[m].everywhere || contains(scene.materials[m].region, x, organ)))
      return m;
  return 0;
}

}  // namespace palpate
