#include "io/load_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "base/parallel_for.h"
#include "discretization/surface/solids.h"
#include "imaging/repair_surface.h"
#include "io/indent_script.h"
#include "io/surface_file.h"
#include "simulation/choose_time_step.h"
#include "simulation/discretize.h"
#include "simulation/mixtures.h"
#include "simulation/point_boundaries.h"
#include "simulation/scene_messages.h"

namespace palpate {

namespace {

constexpr double shortest_organ = 1e-3, longest_organ = 3;  // m; what is touched by hand lies well within

/// The key that sets the organ's size, and the question whether it is right.
std::pair<std::string, std::string> sizeKey(const Scene& scene) {
  if (scene.solid != Scene::Solid::Surface) return {"organ.solid", "are its lengths in m?"};
  if (scene.places.contains("organ.unit")) {
    const char* const unit = scene.surface_scale == 0.001 ? "mm" : scene.surface_scale == 0.01 ? "cm" : "m";
    return {"organ.unit", std::string("is unit = \"") + unit + "\" right?"};
  }
  return {"organ.scale", "is scale = " + number(scene.surface_scale) + " right?"};
}

/// Refuses a solid that is too finely divided before it is made, which would take long.
void checkSolid(const Scene& scene) {
  if (scene.solid == Scene::Solid::Surface) return;
  const double volume = scene.solid == Scene::Solid::Box        ? scene.size.prod()
                        : scene.solid == Scene::Solid::Cylinder ? M_PI * scene.radius * scene.radius * scene.height
                                                                : 4.0 / 3 * M_PI * scene.semi_axes.prod();
  // Flat faces take less than a hundredth of a round solid away, whose surface is no smaller than a ball's.
  const double least = 0.99 * (scene.upper_half ? volume / 2 : volume);
  checkCounts(scene, least, std::cbrt(36 * M_PI * least * least));
}

}  // namespace

std::string sizeWarning(const Scene& scene, const TriangleSurface& surface) {
  Eigen::AlignedBox3d box;
  for (const Vec3& x : surface.vertices) box.extend(x);
  const double length = box.sizes().maxCoeff();
  if (length >= shortest_organ && length <= longest_organ) return {};
  const auto [key, question] = sizeKey(scene);
  const std::string place = placeOf(scene, key).text();
  return (place.empty() ? "" : place + ": ") + "the organ is " +
         (length < 1 ? number(1e3 * length) + " mm" : number(length) + " m") + " long; " + question;
}

TriangleSurface organSurface(const Scene& scene) {
  checkSolid(scene);
  // Curved solids lose volume to flat faces; half the spacing leaves less than the cells do.
  const double edge = std::min(0.5 * scene.spacing, 0.5 * smallestToolRadius(scene));
  try {
    switch (scene.solid) {
      case Scene::Solid::Box:
        return boxSurface(scene.size, edge);
      case Scene::Solid::Cylinder:
        return cylinderSurface(scene.radius, scene.height, edge);
      case Scene::Solid::Ellipsoid:
        return scene.upper_half ? halfEllipsoidSurface(scene.semi_axes, edge) : ellipsoidSurface(scene.semi_axes, edge);
      case Scene::Solid::Surface:
        break;
    }
  } catch (const std::invalid_argument& error) {
    throw InputError(placeOf(scene, "discretization.spacing"), error.what(),
                     "raise discretization.spacing or tool.radius");
  }
  if (scene.repair_surface) {
    SurfaceFile file =
        readSurface(scene.surface_file, scene.surface_scale, placeOf(scene, "organ.surface"), SurfaceReading::Tolerant);
    return repairSurface(std::move(file.surface), std::move(file.source)).surface;
  }
  return readClosedSurface(scene.surface_file, scene.surface_scale, placeOf(scene, "organ.surface"));
}

namespace {

/// Progress that a SetupWatch may repeat within long stages, so that these, too, can be ended.
struct Stages {
  explicit Stages(const Progress& progress)
      : report([this, progress](const std::string& what, double fraction) {
          stage = what;
          behind = fraction;
          if (progress) progress(stage, behind);
        }) {}
  std::string stage = "surface";
  double behind = 0;
  const Progress report;
};

/// The scene as it is built on this organ.
Scene readyScene(const Scene& as_read, const TriangleSurface& organ,
                 const std::function<void(const std::string&)>& warn) {
  const bool has_points = std::any_of(as_read.boundaries.begin(), as_read.boundaries.end(),
                                      [](const BoundarySpec& b) { return b.points != nullptr; });
  Scene scene = has_points ? withPointBoundaries(as_read, SurfaceTree(organ), warn) : as_read;
  if (const std::string warning = sizeWarning(scene, organ); warn && !warning.empty()) warn(warning);
  for (const ToolSpec& tool : toolsOf(scene))
    if (warn && tool.jaws() && tool.friction == 0)
      warn(tool.place.text() + ": jaws without friction hold nothing; give them friction = 0.8");
  return scene;
}

/// A set-up that has begun: the surface is read, and what takes long from here on tells how far it is.
struct SetUp {
  SetUp(const Scene& as_read, const Progress& progress, const std::function<void(const std::string&)>& warn)
      : stages(progress), organ(surfaceOf(as_read)), scene(readyScene(as_read, organ, warn)) {}

  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }

  const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  const Stages stages;
  const SetupWatch watch{[this] { stages.report(stages.stage, stages.behind); }};
  const TriangleSurface organ;
  const Scene scene;

 private:
  TriangleSurface surfaceOf(const Scene& as_read) const {
    checkStepsAsked(as_read);
    stages.report("surface", 0);
    return organSurface(as_read);
  }
};

}  // namespace

void requireOneCloud(const Scene& scene) {
  if (scene.follow)
    throw InputError(placeOf(scene, "discretization.follow"),
                     "a cloud follows the tool in palpate and its recordings only", "give spacing in place of follow");
}

Model loadModel(const Scene& as_read, const Progress& progress, const ModelCache& cache,
                const std::function<void(const std::string&)>& warn) {
  requireOneCloud(as_read);
  const SetUp set_up(as_read, progress, warn);
  const Scene& scene = set_up.scene;
  const std::string key = preparationKey(scene, set_up.organ);
  BuildOptions options;
  options.progress = set_up.stages.report;
  if (!scene.set_up_values.empty()) {  // else nothing says what a preparation was made from
    options.find = [&] { return cache.find(key, materialsOf(scene).size(), scene.boundaries.size()); };
    options.keep = [&](const Preparation& preparation) { cache.keep(key, preparation); };
  }
  Model model = buildModel(scene, set_up.organ, options);
  addToolPaths(model);
  model.setup_seconds = set_up.seconds();
  return model;
}

FollowingModel loadFollowing(const Scene& as_read, const Progress& progress, const ModelCache& cache,
                             const std::function<void(const std::string&)>& warn) {
  const SetUp set_up(as_read, progress, warn);
  const Progress& report = set_up.stages.report;
  const PlaceStore store = placeStore(set_up.scene, cache);
  FollowingModel following;
  following.places = std::make_shared<const Places>(makePlaces(
      set_up.scene, set_up.organ, [&](const std::string& what, double share) { report(what, 0.8 * share); }, store));
  report("first place", 0.8);
  following.start = makePlace(*following.places, startPlace(*following.places), store);
  addToolPaths(following.start.model);
  following.start.model.setup_seconds = set_up.seconds();
  report("ready", 1);
  return following;
}

PlaceStore placeStore(const Scene& scene, const ModelCache& cache) {
  const ModelCache silent = cache.silent();
  const std::size_t materials = materialsOf(scene).size(), boundaries = scene.boundaries.size();
  return {[=](const std::string& key) { return silent.find(key, materials, boundaries); },
          [=](const std::string& key, const Preparation& preparation) { silent.keep(key, preparation); }};
}

}  // namespace palpate
