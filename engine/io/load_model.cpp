#include "io/load_model.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "base/parallel_for.h"
#include "discretization/solids.h"
#include "io/surface_file.h"

namespace palpate {

TriangleSurface organSurface(const Scene& scene) {
  // Curved solids lose volume to flat faces; half the spacing leaves less than the cells do.
  const double edge = std::min(0.5 * scene.spacing, 0.5 * scene.tool.radius);
  try {
    switch (scene.solid) {
      case Scene::Solid::Box: return boxSurface(scene.size, edge);
      case Scene::Solid::Cylinder: return cylinderSurface(scene.radius, scene.height, edge);
      case Scene::Solid::Ellipsoid:
        return scene.upper_half ? halfEllipsoidSurface(scene.semi_axes, edge) : ellipsoidSurface(scene.semi_axes, edge);
      case Scene::Solid::Surface: break;
    }
  } catch (const std::invalid_argument& error) {
    const auto spacing = scene.places.find("discretization.spacing");
    throw InputError(spacing == scene.places.end() ? scene.place : spacing->second, error.what(),
                     "raise discretization.spacing or tool.radius");
  }
  const auto place = scene.places.find("organ.surface");
  return readClosedSurface(scene.surface_file, scene.surface_scale,
                           place == scene.places.end() ? scene.place : place->second);
}

Model loadModel(const Scene& scene, const Progress& progress, const ModelCache& cache) {
  const auto start = std::chrono::steady_clock::now();
  std::string stage = "surface";
  double behind = 0;
  const Progress tell = [&](const std::string& what, double fraction) {
    stage = what;
    behind = fraction;
    if (progress) progress(stage, behind);
  };
  tell(stage, behind);
  const SetupWatch watch([&] {  // long stages, too, can be ended
    if (progress) progress(stage, behind);
  });
  const SurfaceTree tree(organSurface(scene));
  const std::string key = preparationKey(scene, tree.surface());
  std::optional<Preparation> preparation = cache.find(key);
  if (!preparation) {
    preparation = prepare(scene, tree, tell);
    tell("keeping it for the next start", 0.94);
    cache.keep(key, *preparation);
  }
  Model model = finishModel(scene, tree, std::move(*preparation), tell);
  model.setup_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return model;
}

}  // namespace palpate
