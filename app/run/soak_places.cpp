#include "app/run/soak_places.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "app/render/pick.h"
#include "base/input_error.h"

namespace palpate::app {

namespace {

constexpr int tries_per_place = 50;
constexpr double depth_per_radius = 0.8;
constexpr double depth_per_thickness = 0.25;
constexpr double min_depth_per_radius = 0.15;  // less is no press
constexpr double slant_per_radius = 0.3;       // the skin under the middle may lie so much deeper than the first touch

}  // namespace

std::vector<SoakPlace> soakPlaces(const Body& model, int count, unsigned seed) {
  const TriangleSurface& surface = model.skin.surface;
  const double radius = model.scene.tools[0].shape.radius;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  // of the skin in the tool's frame
  std::vector<Vec3f> positions;
  for (const Vec3& X : surface.vertices) {
    const Vec3 local = model.tools.first().start.pose.toLocal(X);
    low = positions.empty() ? local : Vec3(low.cwiseMin(local));
    high = positions.empty() ? local : Vec3(high.cwiseMax(local));
    positions.push_back(X.cast<float>());
  }
  const double reach = (high - low).norm();

  std::mt19937 random(seed);
  const auto uniform = [&random](double a, double b) { return a + (b - a) * (random() / 4294967296.0); };
  std::vector<SoakPlace> places;
  for (int k = 0; k < tries_per_place * count && static_cast<int>(places.size()) < count; ++k) {
    SoakPlace place;
    place.slide = {uniform(low.x(), high.x()), uniform(low.y(), high.y())};
    const auto along = [&](double z, double direction) {  // the first skin that a ray along the axis meets
      Ray ray;
      ray.origin = model.tools.first().start.pose.toWorld({place.slide.x(), place.slide.y(), z});
      ray.direction = model.tools.first().start.pose.orientation * Vec3(0, 0, direction);
      const auto hit = pickSkin(surface, positions, ray);
      return hit ? z + direction * hit->distance : std::nan("");
    };
    const double top = along(high.z() + reach, -1), bottom = along(low.z() - reach, 1);
    if (!(top > bottom)) continue;
    Pose start = model.tools.first().start.pose;
    start.position = model.tools.first().start.pose.toWorld({place.slide.x(), place.slide.y(), 0});
    place.touch = firstContactTravel(surface, model.scene.tools[0].shape, start);
    if (!(std::abs(-top - place.touch) <= slant_per_radius * radius)) continue;
    place.depth = std::min(depth_per_radius * radius, depth_per_thickness * (top - bottom));
    if (place.depth >= min_depth_per_radius * radius) places.push_back(place);
  }
  if (places.empty())
    throw InputError(model.scene.place, "no place where a soak's tool could press",
                     "let the tool start above the organ, with its direction towards it");
  return places;
}

}  // namespace palpate::app
