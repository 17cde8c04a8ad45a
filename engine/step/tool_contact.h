#pragma once

#include "base/types.h"
#include "model/model.h"
#include "model/state.h"

namespace palpate {

/// How the tissue's forces on the tool act together. With f_c the force on the tissue at contact point x_c, n_c the
/// tool's outward normal there and t the tip:
///
///   torque = -sum_c (x_c - t) x f_c
///   normal = -N / |N|,   N = sum_c max(f_c . n_c, 0) n_c      from the tissue towards the tool
struct ToolContact {
  Vec3 torque = Vec3::Zero();  // N m, on the tool, about its tip
  Vec3 normal = Vec3::Zero();  // unit; 0: no contact
};

/// @param state  after a step; its contact forces are that step's
/// Real-time: no allocation, no lock, no throw; cost ~ 25 four-lane FMAs per vertex or sample's corner that carries
/// force. Test: simulation/tool_contact_test.cpp
/// @param tool  of scenes that have several
ToolContact toolContact(const Model& model, const State& state, int tool = 0);

/// Where the tools are in the body at rest: a tool that touches at the middle of what it touches, by force, as it lies
/// at rest; else where it is.
/// Real-time as toolContact.
ToolPostures posturesAtRest(const Model& model, const State& state);

/// rimForce (rim_force.h) after a step.
double rimForce(const Model& model, const State& state, int tool);

/// Calls `call(vertex, force)` for each force at a skin vertex, N on the tissue.
template <class Call>
void forEachVertexForce(const ContactState& contact, Call call) {
  for (int c = 0; c < contact.count; ++c) {
    const Float4& f = contact.force[static_cast<std::size_t>(c)];
    if (!isZero(f)) call(contact.vertex[static_cast<std::size_t>(c)], f);
  }
}

/// Likewise for the forces at samples of stretched faces, shared out to their corners.
template <class Call>
void forEachSampleForce(const FaceSamples& samples, Call call) {
  for (int s = 0; s < samples.count; ++s) {
    const Float4& f = samples.force[static_cast<std::size_t>(s)];
    if (isZero(f)) continue;
    const SkinPoint& point = samples.point[static_cast<std::size_t>(s)];
    for (int k = 0; k < point.corners; ++k) {
      const auto corner = static_cast<std::size_t>(k);
      const float share = point.share[corner];
      call(point.vertex[corner], Float4{share * f.x, share * f.y, share * f.z, 0});
    }
  }
}

/// Both: their sum is minus the tool's force, to rounding. A vertex may come more than once.
template <class Call>
void forEachContactForce(const ContactState& contact, Call call) {
  forEachVertexForce(contact, call);
  forEachSampleForce(contact.samples, call);
}

}  // namespace palpate
