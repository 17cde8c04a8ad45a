#include "mtled/run/scene_spacing.h"

#include <algorithm>
#include <cmath>

#include "discretization/surface/surface_tree.h"
#include "setup/place.h"

namespace palpate::tools {

Scene uniformScene(Scene scene) {
  constexpr double of_fine = 1.3;
  if (!scene.discretization.follow) return scene;
  scene.discretization.follow = false;
  scene.discretization.spacing = of_fine * fineSpacing(scene);
  scene.discretization.at_tools = 0;
  if (!scene.places.contains("dynamics.mass_scaling")) scene.dynamics.mass_scaling = 0;
  scene.set_up_values.clear();
  return scene;
}

void scaleSpacing(Scene& scene, double factor) {
  if (scene.discretization.follow) {
    scene.discretization.at_tools = factor * fineSpacing(scene);
    scene.set_up_values.clear();  // they would be another scene's
    return;
  }
  scene.discretization.spacing *= factor;
  for (auto& refine : scene.discretization.refine) refine.spacing *= factor;
}

ContactRegion contactRegion(const Model& model, const ToolTrajectory& way) {
  const SurfaceTree skin(model.skin.surface);
  const double radius = model.scene.tools[0].shape.radius;
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  std::vector<Vec3> places;
  for (const Pose& pose : way) {
    const auto closest = skin.closest(pose.position, radius);
    if (!(closest.distance < radius)) continue;
    places.push_back(closest.point);
    low = low.cwiseMin(closest.point);
    high = high.cwiseMax(closest.point);
  }
  if (places.empty()) return {};
  ContactRegion place{(low + high) / 2, 0};
  for (const Vec3& x : places) place.radius = std::max(place.radius, (x - place.centre).norm());
  place.radius += 2 * radius;
  return place;
}

void refineWhere(Scene& scene, const ContactRegion& place, double outside, double inside) {
  const double present = scene.discretization.spacing;
  scaleSpacing(scene, outside);
  RefineSpec refine;
  refine.centre = place.centre;
  refine.radius = place.radius;
  refine.spacing = inside * present;
  scene.discretization.refine.push_back(refine);
}

}  // namespace palpate::tools
