#include "simulation/contact_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "simulation/scene_messages.h"
#include "simulation/tool_contact.h"
#include "simulation/trust.h"

namespace palpate {
namespace {

constexpr double error_constant = 0.05;  // c
constexpr double largest_error = 9.99;

double planeModulus(const Material& m) {
  const double K = m.bulk_modulus, mu = m.shear_modulus;
  return 4 * mu * (3 * K + mu) / (3 * K + 4 * mu);
}

/// The node that counts most at a skin vertex.
int nodeAt(const SkinModel& skin, int vertex) {
  const auto first = skin.N.begin() + skin.begin[static_cast<std::size_t>(vertex)],
             last = skin.N.begin() + skin.begin[static_cast<std::size_t>(vertex) + 1];
  return skin.node[static_cast<std::size_t>(std::max_element(first, last) - skin.N.begin())];
}

double spacingAt(const Body& body, int node) {
  return body.support_radius[static_cast<std::size_t>(node)] / body.scene.support_factor;
}

}  // namespace

double expectedForceError(const ContactPatch& patch) {
  if (!(patch.radius > 0)) return 0;
  const double ratio = patch.spacing / patch.radius;
  return std::min(error_constant * ratio * ratio, largest_error);
}

double spacingFor(double contact_radius, double error) { return contact_radius * std::sqrt(error / error_constant); }

double contactRadius(const ToolProfile& tip, double force, double plane_modulus, double spacing) {
  const auto forceAt = [&](double a) {
    const double ratio = spacing / a;
    return 8.0 / 3 * plane_modulus * a * tipProfile(tip, a) * (1 + error_constant * ratio * ratio);
  };
  double low = 0, high = tip.radius;
  for (int k = 0; k < 24; ++k) {
    const double middle = 0.5 * (low + high);
    (forceAt(middle) < force ? low : high) = middle;
  }
  return high;
}

ContactPatch contactPatch(const Body& body, std::span<const Material> materials, const ToolShape& tool,
                          const ContactState& contact) {
  Vec3 sum = Vec3::Zero();
  double largest = 0;
  int strongest = -1;
  forEachContactForce(contact, [&](int vertex, const Float4& f) {
    const Vec3 force = toVec3(f);
    sum += force;
    if (const double size = force.squaredNorm(); size > largest) {
      largest = size;
      strongest = vertex;
    }
  });
  if (strongest < 0) return {};
  const int node = nodeAt(body.skin, strongest);
  const Material& material = materials[static_cast<std::size_t>(body.node_material[static_cast<std::size_t>(node)])];
  const double spacing = spacingAt(body, node), force = sum.norm();
  return {contactRadius(toolProfile(tool), force, planeModulus(material), spacing), spacing, force};
}

ContactPatch fullContact(const Body& body) {
  const Vec3 touched =
      body.tool_start.position - body.first_contact_travel * (body.tool_start.orientation * Vec3::UnitZ());
  double least = std::numeric_limits<double>::infinity();
  int node = 0;
  for (int i = 0; i < body.nodeCount(); ++i)
    if (const double d = (body.X[static_cast<std::size_t>(i)] - touched).squaredNorm(); d < least) {
      least = d;
      node = i;
    }
  return {body.scene.tool.radius, spacingAt(body, node), 0};
}

std::string resolutionWarning(const Body& body) {
  const ContactPatch full = fullContact(body);
  const double error = expectedForceError(full);
  if (error <= TrustLimits::expected_error) return {};
  return placeOf(body.scene, "discretization.spacing").text() +
         format(
             ": where the tool meets the organ the nodes are %.3g mm apart, and a tool of %.3g mm radius will feel "
             "some %.0f %% too much; a spacing of %.2g mm there (spacing, or refine) keeps that below %.0f %%, and "
             "`mtled fit` finds the best cloud for a rate",
             1e3 * full.spacing, 1e3 * full.radius, 100 * error,
             1e3 * spacingFor(full.radius, TrustLimits::expected_error), 100 * TrustLimits::expected_error);
}

std::vector<int> nodeMaterials(const Preparation& p) {
  std::vector<int> material(p.X.size(), 0);
  std::vector<double> share(p.X.size(), 0);
  const int count = p.point_material.empty() ? 0 : *std::max_element(p.point_material.begin(), p.point_material.end());
  std::vector<double> sum(p.X.size());
  for (int m = 0; m <= count; ++m) {
    std::fill(sum.begin(), sum.end(), 0.0);
    for (int q = 0; q < p.pointCount(); ++q) {
      if (p.point_material[static_cast<std::size_t>(q)] != m) continue;
      for (int e = p.point_shape.begin[q]; e < p.point_shape.begin[q + 1]; ++e)
        sum[static_cast<std::size_t>(p.point_shape.node[e])] +=
            std::abs(p.point_shape.N[e]) * p.point_volume[static_cast<std::size_t>(q)];
    }
    for (std::size_t i = 0; i < sum.size(); ++i)
      if (sum[i] > share[i]) {
        share[i] = sum[i];
        material[i] = m;
      }
  }
  return material;
}

}  // namespace palpate
