#pragma once

#include "contact/contact_state.h"

namespace palpate {

/// Up to this stretch of its edges (length over that at rest) a face is felt by its vertices alone.
constexpr float kStretchLimit = 1.5F;

/// From this stretch on a first sample takes part in full.
constexpr float kFullStretch = 2.25F;

/// Finds the contact points on stretched edges and faces that findContactCandidates would list if they were vertices,
/// and lists them in contact.samples by ascending id, keeping the forces of those that stay. Once per tick, after it.
///
/// Contact is felt at the skin's vertices. Where the skin is stretched they spread, until a tool fits between them. So
/// an edge that is stretched by s gets a sample in its middle, those halves that are still stretched by s / 2 get one
/// in theirs, and so on for three levels, up to s = 8 (12 between samples that are kStretchLimit apart); and faces in
/// their inside, where halved edges meet. A sample follows its corners linearly: it feels the skin that is drawn.
///
/// Nothing jumps as a sample comes in. Between kStretchLimit and kFullStretch its weight w goes from 0 to 1: the layer
/// there is w times as stiff, and the tool is as far from it as from its corners on average, less w times the rest.
/// (The distance to a convex tool is nowhere more than that average.)
/// @param margin  as for findContactCandidates
/// @pre  contact.vertex are the vertices near the tool. Edges near the tool grow by no more than a tenth between two
///       searches: a tool that is put on skin that is stretched already to several times its size is felt when it comes
///       to a vertex.
/// Sets contact.overflow if there are more than there is memory for.
/// Real-time: no allocation, no lock, no throw; where no edge is stretched, an interpolation for each listed vertex and
/// a comparison for each of its edges. Test: contact/face_samples_test.cpp.
void findFaceSamples(const SkinModel& skin, const Float4* u, const ToolShape& tool, const Pose& tool_pose,
                     double margin, ContactState& contact, ContactScratch& scratch);

/// How much further than its nearest point the nearest corner of a stretched face may be, m. Real-time.
double cornerReach(const FaceSamples& samples);

/// Bound on the stretch of edges near the tool. Real-time.
double expectedStretch(const FaceSamples& samples);

/// Where a point of the skin is now, m. Real-time.
Vec3 skinPosition(const SkinModel& skin, const SkinPoint& point, const Float4* u);

/// Calls use(size, force on the tissue, N; outward normal of the tool in its frame; point of the skin) for each vertex
/// and sample that carries force. Real-time.
template <class Use>
void forEachTouched(const ContactState& contact, const Use& use) {
  for (int c = 0; c < contact.count; ++c) {
    const auto k = static_cast<std::size_t>(c);
    const double f = toVec3(contact.force[k]).norm();
    if (f > 0) use(f, contact.force[k], contact.normal[k], SkinPoint{1, {contact.vertex[k]}, {1}});
  }
  const FaceSamples& samples = contact.samples;
  for (int c = 0; c < samples.count; ++c) {
    const auto k = static_cast<std::size_t>(c);
    const double f = toVec3(samples.force[k]).norm();
    if (f > 0) use(f, samples.force[k], samples.normal[k], samples.point[k]);
  }
}

/// Interpolates a nodal field at a point of the skin. Lane w is 0. Real-time.
Eigen::Vector4f interpolate(const SkinModel& skin, const SkinPoint& point, const Float4* field);

}  // namespace palpate
