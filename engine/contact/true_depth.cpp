#include "contact/true_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/samples/face_samples.h"
#include "discretization/surface/surface_geometry.h"

namespace palpate {
namespace {

/// How far below the best cosine to the mean normal a vertex counts, ever less, as under the tip: 26 degrees to both
/// sides of a foremost point. Skin is no finer than 20 degrees of a ball; counted in full or not at all, within 11,
/// vertices that come and go moved the depth to and fro by half a millimetre in a press of 7.
constexpr double kUnderTheTip = 0.1;

/// The skin's normal at rest while it is within 26 degrees of the contact's; from 37 on the tissue has turned.
/// @param at_rest, of_contact  unit
Vec3 normalOf(const Vec3& at_rest, const Vec3& of_contact) {
  const double turned = (1 - kUnderTheTip - at_rest.dot(of_contact)) / kUnderTheTip;
  return (at_rest + std::clamp(turned, 0.0, 1.0) * (of_contact - at_rest)).normalized();
}

}  // namespace

TrueDepth::TrueDepth(const SkinModel& skin, const ToolShape& tool) : skin_(skin), profile_(toolProfile(tool)) {
  for (const Vec3& outwards : vertexNormals(skin.surface)) inwards_.push_back(-outwards.cast<float>());
}

/// How far the tool reaches along a unit direction of its frame, m from its tip.
double TrueDepth::support(const Vec3& direction) const {
  const double across = std::hypot(direction.x(), direction.y());
  double most = -std::numeric_limits<double>::infinity();
  for (int k = 0; k < profile_.corner_count; ++k) {
    const MeridianPoint& corner = profile_.corner[static_cast<std::size_t>(k)];
    most = std::max(most, corner.r * across + corner.z * direction.z());
  }
  return most + profile_.rounding;
}

double TrueDepth::of(const Pose& tool, const ContactState& contact) const {
  Vec3 sum = Vec3::Zero();  // tool's frame
  forEachTouched(contact, [&](double f, const Float4&, const Vec3f& normal, const SkinPoint&) {
    sum += f * normal.cast<double>();
  });
  if (!(sum.norm() > 0)) return std::min(0.0, -gap(tool));
  const Vec3 push = sum.normalized();

  // The best aligned first: a tool that touches around its foremost point, as a hollow one would, has none there.
  double best = -1;
  forEachTouched(contact, [&](double, const Float4&, const Vec3f& normal, const SkinPoint&) {
    best = std::max(best, push.dot(normal.cast<double>()));
  });
  double weight = 0;
  Vec3 rest = Vec3::Zero(), at_rest = Vec3::Zero();
  forEachTouched(contact, [&](double f, const Float4&, const Vec3f& normal, const SkinPoint& point) {
    const double w = f * std::max(0.0, push.dot(normal.cast<double>()) - best + kUnderTheTip);
    weight += w;
    for (std::size_t a = 0; a < static_cast<std::size_t>(point.corners); ++a) {
      const auto v = static_cast<std::size_t>(point.vertex[a]);
      const double share = w * static_cast<double>(point.share[a]);
      rest += share * (skin_.surface.vertices[v] - tool.position);
      at_rest += share * inwards_[v].cast<double>();
    }
  });
  if (!(weight > 0)) return 0;
  const auto along = [&](const Vec3& n) { return support(tool.orientation.conjugate() * n) - rest.dot(n) / weight; };
  const Vec3 of_contact = tool.orientation * push;
  return std::max(0.0, std::min(along(of_contact), along(normalOf(at_rest.normalized(), of_contact))));
}

/// Clusters and regions that can't hold a nearer vertex are passed over.
double TrueDepth::gap(const Pose& tool) const {
  const std::vector<Vec3>& X = skin_.surface.vertices;
  const auto distance = [&](int v) {
    return toolDistance(profile_, tool.toLocal(X[static_cast<std::size_t>(v)])).distance;
  };
  double nearest = std::numeric_limits<double>::infinity();
  for (int r = 0; r < skin_.regionCount(); ++r) {
    const auto region = static_cast<std::size_t>(r);
    if (distance(skin_.region_representative[region]) - static_cast<double>(skin_.region_radius[region]) > nearest)
      continue;
    for (int c = skin_.region_begin[region]; c < skin_.region_begin[region + 1]; ++c) {
      const auto cluster = static_cast<std::size_t>(c);
      const double middle = distance(skin_.cluster_representative[cluster]);
      nearest = std::min(nearest, middle);
      if (middle - static_cast<double>(skin_.cluster_radius[cluster]) > nearest) continue;
      for (int k = skin_.cluster_begin[cluster]; k < skin_.cluster_begin[cluster + 1]; ++k)
        nearest = std::min(nearest, distance(skin_.cluster_vertex[static_cast<std::size_t>(k)]));
    }
  }
  return std::isfinite(nearest) ? nearest : 0;
}

}  // namespace palpate
