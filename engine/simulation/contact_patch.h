#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "contact/contact_state.h"
#include "contact/tool.h"
#include "mechanics/materials/material.h"
#include "simulation/body.h"

namespace palpate {

/// How large a tool's contact is, and how fine the cloud below it.
struct ContactPatch {
  double radius = 0;   // m, of a round contact with that force; 0: no contact
  double spacing = 0;  // m, mean distance of neighbouring nodes below the largest force
  double force = 0;    // N, on the body
};

/// How much too large a tool's force is expected to be, as a share of it, because the nodes are no closer:
///
///   e = c (h / a)^2,   h the nodes' spacing, a the contact's radius
///
/// What the nodes can't follow of the dent makes the tissue stiffer, and the approximation is of second order.
/// c was measured on scenes drawn by lot against clouds of a third of the spacing (engine/mechanics/README.md); the
/// true error is within a factor of two of e in 9 of 10. At most 9.99; 0 without contact.
double expectedForceError(const ContactPatch& patch);

/// The coarsest spacing with which a contact of that radius is expected to have no more than `error`, m.
double spacingFor(double contact_radius, double error);

/// Radius of the contact of a tool's tip, a, m, at most the tool's own:
///
///   F = 8/3 E' a z(a) (1 + e(a)),   z the tip's height at distance a from its axis
///
/// For a ball on a half-space and h = 0 that is Hertz's. The last factor takes away what the force has too much of.
/// It follows from the force because where a coarse skin touches says less; of other bodies than half-spaces it is off
/// by a cubic root of what their force is.
/// @param force          F, N
/// @param plane_modulus  E' = E / (1 - nu^2), Pa
/// @param spacing        h, m
/// Real-time: no allocation, no lock, no throw.
double contactRadius(const ToolProfile& tip, double force, double plane_modulus, double spacing);

/// @param materials  in force
/// @param contact    of that tool's body, after a step
/// Real-time: no allocation, no lock, no throw. Test: simulation/contact_patch_test.cpp
ContactPatch contactPatch(const Body& body, std::span<const Material> materials, const ToolShape& tool,
                          const ContactState& contact);

/// The largest error expected of a tool's body that carries at least a tenth of the largest one's force.
/// @param contactOf  the contact of body b < body_count
template <class ContactOf>
double largestExpectedError(const Body& body, std::span<const Material> materials, int body_count,
                            ContactOf contactOf) {
  std::array<ContactPatch, max_tool_bodies> patch;
  double largest = 0, error = 0;
  for (int b = 0; b < body_count; ++b) {
    const ToolShape& shape = body.tools.empty() ? body.scene.tool : body.tools.body[static_cast<std::size_t>(b)].shape;
    patch[static_cast<std::size_t>(b)] = contactPatch(body, materials, shape, contactOf(b));
    largest = std::max(largest, patch[static_cast<std::size_t>(b)].force);
  }
  for (const ContactPatch& p : patch)
    if (p.force > 0 && p.force >= 0.1 * largest) error = std::max(error, expectedForceError(p));
  return error;
}

/// What is expected with the tool's full width in contact where it first meets the skin, and the spacing there: the
/// best that the scene can do as it is loaded.
ContactPatch fullContact(const Body& body);

/// A sentence for whoever loads a scene that can't resolve its tool: what it costs, and the spacing that would do;
/// "" where it can.
std::string resolutionWarning(const Body& body);

/// E' of each node's material is looked up by it: the material with the largest share in the node's support.
std::vector<int> nodeMaterials(const Preparation& preparation);

}  // namespace palpate
