#include "simulation/scene_skull.h"

#include <algorithm>

#include "base/number_text.h"
#include "simulation/scene_messages.h"
#include "simulation/scene_regions.h"

namespace palpate {

Skull skullOf(const Scene& scene, const SurfaceTree& organ, const SkinModel& skin, double young_modulus) {
  const SkullSpec& spec = scene.skull;
  if (!spec.given) return {};
  SkullOptions options;
  options.clearance = spec.clearance;
  options.spacing = scene.spacing;
  options.young_modulus = young_modulus;
  options.of_organ = spec.surface == nullptr;
  if (!spec.open.empty())
    options.open = [&](const Vec3& x) {
      return std::any_of(spec.open.begin(), spec.open.end(), [&](const Region& r) { return contains(r, x, organ); });
    };
  if (options.of_organ) return buildSkull(organ, skin, options);
  const SurfaceTree surface(*spec.surface);
  for (const Vec3& x : skin.surface.vertices) {
    constexpr double most = 1e-3;  // m: what is less is pushed in
    const double outside = surface.signedDistance(x) - spec.clearance;
    if (outside <= most || (options.open && options.open(x))) continue;
    throw InputError(
        spec.place, "the organ reaches " + format("%.3g mm", 1e3 * outside) + " through the skull at " + coordinates(x),
        "is the skull's unit right? give a larger clearance, or an \"open\" region there");
  }
  return buildSkull(surface, skin, options);
}

}  // namespace palpate
