#include "scene/scene_rigid.h"

#include <algorithm>
#include <cmath>

#include "base/number_text.h"
#include "discretization/surface/feature_edges.h"
#include "discretization/surface/solids.h"
#include "discretization/surface/surface_gaps.h"
#include "scene/scene_messages.h"
#include "scene/scene_regions.h"

namespace palpate {
namespace {

RigidShape surfaceOf(const Scene& scene, const RigidSpec& spec, const SurfaceTree& organ) {
  SurfaceSide side;
  side.inside = spec.encloses;
  side.clearance = spec.clearance;
  if (!spec.open.empty())
    side.open = [&](const Vec3& x) {
      return std::any_of(spec.open.begin(), spec.open.end(), [&](const Region& r) { return contains(r, x, organ); });
    };
  return spec.of_organ ? surfaceShape(organ, side, scene.discretization.spacing)
                       : surfaceShape(SurfaceTree(*spec.surface), side, scene.discretization.spacing);
}

/// The true gap at rest, m, where the grid knows only what is near.
double gapAtRest(const RigidSpec& spec, const RigidShape& shape, const std::optional<SurfaceTree>& surface,
                 const Vec3& x, const SurfaceTree& organ) {
  Vec3 normal;
  if (!surface) return shape.gapAt(x, normal);
  if (std::any_of(spec.open.begin(), spec.open.end(), [&](const Region& r) { return contains(r, x, organ); }))
    return RigidShape::away;
  const double outside = surface->signedDistance(x);
  return spec.encloses ? spec.clearance - outside : outside - spec.clearance;
}

/// The sharp edges of a body narrower than the skin's points are apart where nodes are as a scene has them elsewhere.
std::vector<std::array<Vec3, 2>> edgesOf(const RigidSpec& spec, const RigidShape& shape, double spacing) {
  constexpr double narrow = 0.5;      // spacings: the points' distance
  constexpr double thin_share = 0.1;  // of the skin
  constexpr std::size_t most = 64;    // more have no edge that cuts
  std::vector<std::array<Vec3, 2>> edges;
  TriangleSurface surface;
  if (spec.surface) {
    surface = *spec.surface;
  } else if (shape.kind == RigidShape::Kind::Box) {
    surface = boxSurface(2 * shape.half, 2 * shape.half.maxCoeff());
    const Vec3 middle = boundingBox(surface).center();
    for (Vec3& x : surface.vertices) x += shape.point - middle;
  } else {
    return edges;
  }
  if (spec.encloses || spec.of_organ || !(thicknessOf(SurfaceTree(surface), thin_share) < narrow * spacing))
    return edges;
  for (const auto& chain : findFeatureEdges(surface).chains)
    for (std::size_t k = 0; k + 1 < chain.points.size(); ++k)
      edges.push_back(std::array<Vec3, 2>{chain.points[k], chain.points[k + 1]});
  if (edges.size() > most) edges.clear();
  return edges;
}

/// Refuses an organ that reaches into a body.
void checkGap(const RigidSpec& spec, const RigidShape& shape, const SurfaceTree& organ, const SkinModel& skin) {
  constexpr double most = 1e-3;  // m: what is less is pushed out
  if (spec.of_organ) return;
  std::optional<SurfaceTree> surface;
  if (spec.surface) surface.emplace(*spec.surface);
  double deepest = most;
  Vec3 place = Vec3::Zero();
  for (const Vec3& x : skin.surface.vertices)
    if (const double depth = -gapAtRest(spec, shape, surface, x, organ); depth > deepest) deepest = depth, place = x;
  if (deepest <= most) return;
  const std::string depth = format("%.3g mm", 1e3 * deepest), where = coordinates(place);
  if (spec.encloses)
    throw InputError(spec.place, "the organ reaches " + depth + " through the " + spec.name + " at " + where,
                     "is its unit right? give a larger clearance, or an \"open\" region there");
  throw InputError(spec.place,
                   "the organ reaches " + depth + " into the rigid body " + inQuotes(spec.name) + " at " + where,
                   "move one of them; up to 1 mm is pushed out");
}

}  // namespace

RigidShape solidOf(const Region& region) {
  using Kind = RigidShape::Kind;
  RigidShape shape;
  shape.point = region.point;
  shape.normal = region.normal;
  shape.radius = region.radius;
  shape.height = region.height;
  switch (region.kind) {
    case Region::Kind::Box:
      shape.kind = Kind::Box;
      shape.point = 0.5 * (region.min + region.max);
      shape.half = 0.5 * (region.max - region.min);
      break;
    case Region::Kind::Sphere:
      shape.kind = Kind::Sphere;
      break;
    case Region::Kind::Cylinder:
      shape.kind = Kind::Cylinder;
      break;
    default:
      shape.kind = Kind::HalfSpace;
  }
  return shape;
}

double largestSpeed(const RigidSpec& spec) {
  const BoundaryMotion& motion = spec.motion;
  if (!motion.moves()) return 0;
  Box3 box(spec.region.point);
  if (spec.region.kind == Region::Kind::Box) box = Box3(spec.region.min, spec.region.max);
  if (spec.surface)
    box = boundingBox(*spec.surface);
  else
    box = Box3(box.min() - Vec3::Constant(spec.region.radius + spec.region.height),
               box.max() + Vec3::Constant(spec.region.radius + spec.region.height));
  double arm = 0;  // m, of the corner that is furthest from the axis
  for (int c = 0; c < 8; ++c)
    arm = std::max(arm, motion.axis.cross(box.corner(static_cast<Box3::CornerType>(c)) - motion.axis_point).norm());
  const double way = motion.translation.norm() + std::abs(motion.angle) * arm;
  constexpr double smooth_peak = 1.875;  // of the mean speed, at the middle of the 3-4-5 polynomial
  const LoadCurve& curve = motion.curve;
  double rate = (curve.kind == LoadCurve::Kind::Smooth ? smooth_peak : 1) / motion.duration;  // 1/s
  if (curve.kind == LoadCurve::Kind::Table) rate = 0;
  for (std::size_t k = 1; k < curve.time.size(); ++k)
    rate = std::max(rate, std::abs(curve.fraction[k] - curve.fraction[k - 1]) / (curve.time[k] - curve.time[k - 1]));
  return rate * way;
}

RigidBodies rigidBodiesOf(const Scene& scene, const SurfaceTree& organ, const SkinModel& skin,
                          const std::vector<int>& of_body, const SpacingField& spacing) {
  RigidBodies bodies;
  for (const RigidSpec& spec : scene.rigid) {
    RigidBody body;
    body.name = spec.name;
    body.friction = spec.friction;
    body.motion = spec.motion;
    body.encloses = spec.encloses;
    body.shape = spec.of_organ || spec.surface ? surfaceOf(scene, spec, organ) : solidOf(spec.region);
    body.edge = edgesOf(spec, body.shape, scene.discretization.spacing);
    checkGap(spec, body.shape, organ, skin);
    const auto gap = spec.of_organ ? std::optional<double>(spec.clearance) : std::nullopt;
    addRigidBody(std::move(body), skin, of_body, spacing, gap, bodies);
  }
  return bodies;
}

}  // namespace palpate
