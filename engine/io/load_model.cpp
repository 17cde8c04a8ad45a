#include "io/load_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "base/parallel_for.h"
#include "base/turn.h"
#include "contact/first_contact_travel.h"
#include "discretization/surface/solids.h"
#include "discretization/surface/surface_bodies.h"
#include "discretization/surface/surface_tree.h"
#include "imaging/repair_surface.h"
#include "io/indent_script.h"
#include "io/surface_file.h"
#include "scene/scene_messages.h"
#include "scene/scene_regions.h"
#include "setup/choose_time_step.h"
#include "setup/discretize.h"
#include "setup/mixtures.h"
#include "setup/point_boundaries.h"
#include "step/rigid_stop.h"

namespace palpate {

namespace {

constexpr double shortest_organ = 1e-3, longest_organ = 3;  // m; what is touched by hand lies well within

/// Where an organ's key stands, or the organ.
SourceLocation placeOf(const Scene& scene, const OrganSpec& organ, const std::string& key) {
  for (const auto& [dotted, at] : scene.places) {
    const std::size_t dot = dotted.rfind('.');
    if (dotted.starts_with("organ") && dot != std::string::npos && dotted.substr(dot + 1) == key &&
        at.line >= organ.place.line)
      return at;
  }
  return organ.place.file.empty() ? scene.place : organ.place;
}

/// The key that sets the organ's size, and the question whether it is right.
std::pair<std::string, std::string> sizeKey(const Scene& scene) {
  if (scene.organs[0].solid != OrganSpec::Solid::Surface) return {"organ.solid", "are its lengths in m?"};
  if (scene.places.contains("organ.unit")) {
    const char* const unit = scene.organs[0].surface_scale == 0.001  ? "mm"
                             : scene.organs[0].surface_scale == 0.01 ? "cm"
                                                                     : "m";
    return {"organ.unit", std::string("is unit = \"") + unit + "\" right?"};
  }
  return {"organ.scale", "is scale = " + number(scene.organs[0].surface_scale) + " right?"};
}

/// Refuses a solid that is too finely divided before it is made, which would take long.
void checkSolid(const Scene& scene, const OrganSpec& organ) {
  if (organ.solid == OrganSpec::Solid::Surface) return;
  const double volume = organ.solid == OrganSpec::Solid::Box        ? organ.size.prod()
                        : organ.solid == OrganSpec::Solid::Cylinder ? M_PI * organ.radius * organ.radius * organ.height
                                                                    : 4.0 / 3 * M_PI * organ.semi_axes.prod();
  // The surface is no smaller than a ball's.
  const double least = organ.upper_half ? volume / 2 : volume;
  checkCounts(scene, least, std::cbrt(36 * M_PI * least * least));
}

/// In its own coordinates.
TriangleSurface surfaceOf(const Scene& scene, const OrganSpec& organ) {
  checkSolid(scene, organ);
  // Faces follow curved solids more closely than cells do, and small ones, too: with edges of a third of a radius their
  // vertices stand 1.4 % of it outside (solids.h).
  constexpr double of_radius = 1.0 / 3, most_faces = 50000;  // that flat ones get for it
  const double edge = std::min(0.5 * scene.discretization.spacing, 0.5 * smallestToolRadius(scene));
  const auto round = [&](double radius, double area) {
    return std::min(edge, std::max(of_radius * radius, std::sqrt(area / (std::sqrt(3.0) / 4 * most_faces))));
  };
  try {
    switch (organ.solid) {
      case OrganSpec::Solid::Box:
        return boxSurface(organ.size, edge);
      case OrganSpec::Solid::Cylinder:
        return cylinderSurface(organ.radius, organ.height,
                               round(organ.radius, 2 * M_PI * organ.radius * (organ.radius + organ.height)));
      case OrganSpec::Solid::Ellipsoid: {
        const Vec3& s = organ.semi_axes;
        const double fine = round(s.minCoeff(), 4 * M_PI * s.maxCoeff() * s.maxCoeff());
        return organ.upper_half ? halfEllipsoidSurface(s, fine) : ellipsoidSurface(s, fine);
      }
      case OrganSpec::Solid::Surface:
        break;
    }
  } catch (const std::invalid_argument& error) {
    throw InputError(placeOf(scene, "discretization.spacing"), error.what(),
                     "raise discretization.spacing or tool.radius");
  }
  const SourceLocation place = placeOf(scene, organ, "surface");
  if (organ.repair_surface) {
    SurfaceFile file = readSurface(organ.surface_file, organ.surface_scale, place, SurfaceReading::Tolerant);
    return repairSurface(std::move(file.surface), std::move(file.source)).surface;
  }
  return readClosedSurface(organ.surface_file, organ.surface_scale, place);
}

/// Organs touch at most. Where edges alone go through one another no vertex is inside; faces pierce then.
void refuseOverlap(const OrganSpec& one, const TriangleSurface& first, const OrganSpec& two,
                   const TriangleSurface& second) {
  constexpr double touching = 1e-4;  // m, by which flat faces of round bodies may be in one another
  if (!boundingBox(first).intersects(boundingBox(second))) return;
  double deepest = -touching;
  Vec3 where = Vec3::Zero();
  const auto look = [&](const TriangleSurface& surface, const TriangleSurface& other) {
    const SurfaceTree tree(other);
    const Box3 box = boundingBox(other);
    std::vector<Vec3> places = surface.vertices;
    for (const auto& [a, b, c] : surface.triangles)
      places.push_back((surface.vertices[a] + surface.vertices[b] + surface.vertices[c]) / 3);
    for (const Vec3& x : places)
      if (const double distance = box.contains(x) ? tree.signedDistance(x) : 0; distance < deepest)
        deepest = distance, where = x;
  };
  look(first, second);
  look(second, first);
  if (deepest < -touching)
    throw InputError(two.place,
                     "the organs " + inQuotes(one.name) + " and " + inQuotes(two.name) + " overlap by " +
                         number(-1e3 * deepest) + " mm at " + coordinates(where),
                     "move one by its \"position\"");
}

/// Turns it and moves it to where it lies.
void place(const OrganSpec& organ, TriangleSurface& surface) {
  if (organ.angle != 0 || !organ.position.isZero(0)) {
    const Mat3 turn = Eigen::AngleAxisd(organ.angle, organ.axis).toRotationMatrix();
    for (Vec3& x : surface.vertices) x = turn * x + organ.position;
  }
  constexpr double furthest = 1e4;  // of its size; at 1e5 single precision has 0.6 % of it, and forces are 15 % off
  const Box3 box = boundingBox(surface);
  const double size = box.diagonal().norm(), away = box.center().norm();
  if (away > furthest * size)
    throw InputError(organ.place,
                     "this organ of " + number(size) + " m lies " + number(away) +
                         " m from the origin, where its coordinates are not exact enough",
                     "move it nearer, by its \"position\" or in its file; or give the file's \"unit\"");
}

}  // namespace

std::string sizeWarning(const Scene& scene, const TriangleSurface& surface) {
  const double length = boundingBox(surface).sizes().maxCoeff();
  if (length >= shortest_organ && length <= longest_organ) return {};
  const auto [key, question] = sizeKey(scene);
  const std::string place = placeOf(scene, key).text();
  return (place.empty() ? "" : place + ": ") + "the organ is " +
         (length < 1 ? number(1e3 * length) + " mm" : number(length) + " m") + " long; " + question;
}

TriangleSurface organSurface(const Scene& scene) {
  const std::vector<OrganSpec>& organs = scene.organs;
  TriangleSurface all;
  std::vector<TriangleSurface> before;
  for (std::size_t k = 0; k < organs.size(); ++k) {
    TriangleSurface surface = surfaceOf(scene, organs[k]);
    place(organs[k], surface);
    if (organs.size() == 1) return surface;
    for (std::size_t j = 0; j < k; ++j) refuseOverlap(organs[j], before[j], organs[k], surface);
    before.push_back(surface);
    addSurface(surface, all);
    all.organ.resize(all.triangles.size(), static_cast<int>(k));
  }
  return all;
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

bool givesTools(const Scene& scene) {
  return std::any_of(scene.places.begin(), scene.places.end(),
                     [](const auto& place) { return place.first.rfind("tool", 0) == 0; });
}

/// What can't be meant of the tools, or is hardly meant.
void checkTools(const Scene& scene, const TriangleSurface& organ, const std::function<void(const std::string&)>& warn) {
  constexpr double same = 1e-6;   // m
  constexpr double far_off = 10;  // of the organ's size
  const std::vector<ToolSpec>& tools = scene.tools;
  const bool has_tool = givesTools(scene);
  for (std::size_t t = 0; t < tools.size(); ++t) {
    const ToolSpec& tool = tools[t];
    for (std::size_t other = 0; other < t; ++other)
      if (tool.jaws() == tools[other].jaws() && (tool.position - tools[other].position).norm() < same)
        throw InputError(tool.place, format("tools %zu and %zu start at one place", other + 1, t + 1),
                         "give each a position of its own");
    if (!warn) continue;
    if (tool.jaws() && tool.friction == 0)
      warn(tool.place.text() + ": jaws without friction hold nothing; give them friction = 0.8");
    const Pose start{tool.position, uprightOn(-tool.direction)};
    if (!has_tool || tool.jaws()) continue;
    const double travel = firstContactTravel(organ, tool.shape, start);
    if (std::isinf(travel))
      warn(tool.place.text() +
           ": straight on the tool never touches the organ; put its position before it, and let its direction point "
           "at it");
    else if (travel > far_off * boundingBox(organ).diagonal().norm())
      warn(tool.place.text() + ": the tool starts " + number(travel) + " m before the organ; is its position in m?");
  }
}

/// Materials that the organ has nothing of: a region that was meant to be elsewhere, or in another unit.
void checkMaterials(const Scene& scene, const SurfaceTree& organ, const std::function<void(const std::string&)>& warn) {
  constexpr int places = 12;  // along each axis
  const Box3 box = boundingBox(organ.surface());
  std::vector<Vec3> inside = organ.surface().vertices;
  for (int k = 0; k < places * places * places; ++k) {
    const Vec3 share(k % places + 0.5, k / places % places + 0.5, k / (places * places) + 0.5);
    const Vec3 x = box.min() + share.cwiseProduct(box.sizes()) / places;
    if (organ.inside(x)) inside.push_back(x);
  }
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    const MaterialSpec& material = scene.materials[m];
    if (material.everywhere || material.membership || material.place.text().empty()) continue;
    const Region& region = material.region;
    const Vec3 middle = region.kind == Region::Kind::Box        ? Vec3((region.min + region.max) / 2)
                        : region.kind == Region::Kind::Cylinder ? Vec3(region.point + region.height / 2 * region.normal)
                                                                : region.point;
    const bool has = organ.inside(middle) || std::any_of(inside.begin(), inside.end(),
                                                         [&](const Vec3& x) { return contains(region, x, organ); });
    if (!has)
      warn(material.place.text() + ": material " + std::to_string(m + 1) +
           (material.name.empty() ? "" : " (\"" + material.name + "\")") +
           " is nowhere in the organ, and has no effect: its region lies beside it; are its numbers in m, where the "
           "organ is after scaling?");
  }
}

/// Kilopascals that were given as pascals, grams in a cubic centimetre as kilograms in a cubic metre.
void checkUnits(const Scene& scene, const std::function<void(const std::string&)>& warn) {
  constexpr double softest = 5, stiffest = 1e7;    // Pa, shear modulus: vitreous humour has some 10, cartilage 1e6
  constexpr double lightest = 50, heaviest = 2e4;  // kg/m^3: of lung 200, of bone 2000, of steel 8000
  for (const MaterialSpec& material : scene.materials) {
    const std::string place = material.place.text(), before = place.empty() ? "" : place + ": ";
    const double shear = material.material.shear_modulus, density = material.material.density;
    if (shear < softest || shear > stiffest)
      warn(before + "a shear modulus of " + number(shear) + " Pa is " +
           (shear < softest ? "softer than any organ: are the moduli in Pa?"
                            : "stiffer than cartilage, and asks for many steps a tick: are the moduli in Pa? What does "
                              "not give may be a [[rigid]] body"));
    if (density < lightest || density > heaviest)
      warn(before + "a density of " + number(density) + " kg/m^3 is no tissue's: is it in kg/m^3?");
  }
}

/// The scene as it is built on this organ.
Scene readyScene(const Scene& as_read, const TriangleSurface& organ,
                 const std::function<void(const std::string&)>& warn) {
  const bool has_points = std::any_of(as_read.boundaries.begin(), as_read.boundaries.end(),
                                      [](const BoundarySpec& b) { return b.points != nullptr; });
  Scene scene = has_points ? withPointBoundaries(as_read, SurfaceTree(organ), warn) : as_read;
  if (const std::string warning = sizeWarning(scene, organ); warn && !warning.empty()) warn(warning);
  if (ToolSpec& tool = scene.tools[0]; !givesTools(scene) && tool.position == ToolSpec().position)  // above any organ
    tool.position.z() = std::max(tool.position.z(), boundingBox(organ).max().z() + 2 * tool.shape.radius);
  checkTools(scene, organ, warn);
  if (warn) checkUnits(scene, warn);
  if (warn && std::any_of(scene.materials.begin(), scene.materials.end(), [](const auto& m) { return !m.everywhere; }))
    checkMaterials(scene, SurfaceTree(organ), warn);
  return scene;
}

/// A set-up that has begun: the surface is read, and what takes long from here on tells how far it is.
struct SetUp {
  SetUp(const Scene& as_read, const Progress& progress, const std::function<void(const std::string&)>& warn)
      : stages(progress), organ(organOf(as_read)), scene(readyScene(as_read, organ, warn)) {}

  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }

  const std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  const Stages stages;
  const SetupWatch watch{[this] { stages.report(stages.stage, stages.behind); }};
  const TriangleSurface organ;
  const Scene scene;

 private:
  TriangleSurface organOf(const Scene& as_read) const {
    checkStepsAsked(as_read);
    stages.report("surface", 0);
    return organSurface(as_read);
  }
};

}  // namespace

namespace {

/// Where places of this scene are kept; nothing is told of what can't be kept or read.
PlaceStore placeStore(const Scene& scene, const ModelCache& cache) {
  if (!cache.keeps()) return {};
  const ModelCache silent = cache.silent();
  const std::size_t materials = materialsOf(scene).size(), boundaries = scene.boundaries.size();
  return {[=](const std::string& key) { return silent.find(key, materials, boundaries); },
          [=](const std::string& key, const Preparation& preparation) { silent.keep(key, preparation); }};
}

/// The place for where the tools are, as a body on its own.
Model loadPlace(const Scene& as_read, const Progress& progress, const ModelCache& cache,
                const std::function<void(const std::string&)>& warn,
                const std::function<ToolPostures(const Model&)>& at) {
  const std::shared_ptr<PlaceSource> source = loadFollowing(as_read, progress, cache, warn);
  const Place& start = *source->start();
  const PlaceIndex index = at ? placeUnder(source->places(), at(start.model)) : start.index;
  Model model = source->at(index)->model;
  if (index != start.index) {
    addToolPaths(model);
    model.setup_seconds = start.model.setup_seconds;
  }
  model.scene.dynamics.time_step = as_read.dynamics.time_step;
  return model;
}

}  // namespace

Model loadModel(const Scene& as_read, const Progress& progress, const ModelCache& cache,
                const std::function<void(const std::string&)>& warn,
                const std::function<ToolPostures(const Model&)>& at) {
  if (as_read.discretization.follow) return loadPlace(as_read, progress, cache, warn, at);
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
  if (givesTools(scene)) checkToolStarts(model);
  addToolPaths(model);
  model.setup_seconds = set_up.seconds();
  return model;
}

std::shared_ptr<PlaceSource> loadFollowing(const Scene& as_read, const Progress& progress, const ModelCache& cache,
                                           const std::function<void(const std::string&)>& warn) {
  const SetUp set_up(as_read, progress, warn);
  const Progress& report = set_up.stages.report;
  PlaceStore store = placeStore(set_up.scene, cache);
  const auto places = std::make_shared<const Places>(makePlaces(
      set_up.scene, set_up.organ, [&](const std::string& what, double share) { report(what, 0.8 * share); }, store));
  report("first place", 0.8);
  const auto start = std::make_shared<Place>(makePlace(*places, startPlace(*places), store));
  if (givesTools(set_up.scene)) checkToolStarts(start->model);
  addToolPaths(start->model);
  start->model.setup_seconds = set_up.seconds();
  report("ready", 1);
  return std::make_shared<PlaceSource>(places, start, std::move(store));
}

}  // namespace palpate
