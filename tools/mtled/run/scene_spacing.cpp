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

std::vector<ContactRegion> contactRegions(const Model& model, const ToolTrajectory& way) {
  const SurfaceTree skin(model.skin.surface);
  std::vector<ContactRegion> regions;
  for (const ToolBody& body : model.tools.body) {
    const double radius = body.shape.radius;
    Box3 box;
    std::vector<Vec3> places;
    for (const ToolPostures& tools : way) {
      const Vec3 tip = bodyPose(body, tools[static_cast<std::size_t>(body.tool)]).position;
      const auto closest = skin.closest(tip, radius);
      if (!(closest.distance < radius)) continue;
      places.push_back(closest.point);
      box.extend(closest.point);
    }
    if (places.empty()) continue;
    ContactRegion region{box.center(), 0};
    for (const Vec3& x : places) region.radius = std::max(region.radius, (x - region.centre).norm());
    region.radius += 2 * radius;
    regions.push_back(region);
  }
  return regions;
}

void refineWhere(Scene& scene, const std::vector<ContactRegion>& places, double outside, double inside) {
  const double present = scene.discretization.spacing;
  scaleSpacing(scene, outside);
  for (const ContactRegion& place : places) {
    RefineSpec refine;
    refine.centre = place.centre;
    refine.radius = place.radius;
    refine.spacing = inside * present;
    scene.discretization.refine.push_back(refine);
  }
}

}  // namespace palpate::tools
