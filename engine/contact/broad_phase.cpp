#include "contact/broad_phase.h"

#include <algorithm>

#include "contact/samples/face_samples.h"

namespace palpate {
namespace {

/// Largest stretch of the skin that the cluster bounds allow for.
constexpr double kStretch = 2.0;

/// Most vertices that a contact may have: 8192 keep a step below about a millisecond.
constexpr int kMaxCapacity = 8192;

/// What is dropped counts where it is this near, in kTissueTravel: further off nothing touches before the next search,
/// but for tissue that comes at 0.1 m/s or more.
constexpr double kNearShare = 0.25;

/// Most samples of stretched faces. They are about as far apart as the skin's vertices are at rest: under a tool whose
/// skin has edges of 0.35 R about 100, of 0.1 R about 750.
constexpr int kSampleCapacity = 1024;

bool nearer(const ContactScratch::Candidate& a, const ContactScratch::Candidate& b) {
  return a.distance != b.distance ? a.distance < b.distance : a.vertex < b.vertex;
}

}  // namespace

ContactState makeContactState(const SkinModel& skin, const ToolShape&) {
  const std::size_t capacity = std::min(skin.vertexCount(), kMaxCapacity);
  ContactState contact;
  contact.vertex.resize(capacity);
  contact.force.resize(capacity);
  contact.normal.resize(capacity, Vec3f::Zero());
  contact.side.resize(capacity, Vec3f::Zero());

  FaceSamples& samples = contact.samples;
  samples.id.resize(kSampleCapacity);
  samples.force.resize(kSampleCapacity);
  for (auto* sides : {&samples.normal, &samples.side}) sides->resize(kSampleCapacity, Vec3f::Zero());
  samples.point.resize(kSampleCapacity);
  samples.area.resize(kSampleCapacity);
  samples.lift.resize(kSampleCapacity);
  return contact;
}

ContactScratch::ContactScratch(const SkinModel& skin) {
  const std::size_t capacity = std::min(skin.vertexCount(), kMaxCapacity),
                    larger = std::max<std::size_t>(capacity, kSampleCapacity);
  candidate.resize(capacity);
  sample.resize(2 * kSampleCapacity);
  old_id.resize(larger);
  old_force.resize(larger);
  for (auto* sides : {&old_normal, &old_side}) sides->resize(larger, Vec3f::Zero());
  const auto vertices = static_cast<std::size_t>(skin.vertexCount());
  position.resize(vertices, Vec3f::Zero());
  mark.resize(vertices);
  marked.resize(vertices);
  row.resize(capacity + kSampleCapacity);
}

void ContactScratch::keepOld(int count, const std::vector<int>& id, const std::vector<Float4>& force,
                             const std::vector<Vec3f>& normal, const std::vector<Vec3f>& side) {
  std::copy_n(id.begin(), count, old_id.begin());
  std::copy_n(force.begin(), count, old_force.begin());
  std::copy_n(normal.begin(), count, old_normal.begin());
  std::copy_n(side.begin(), count, old_side.begin());
}

void findContactCandidates(const SkinModel& skin, const Float4* u, const ToolShape& tool, const Pose& tool_pose,
                           double margin, ContactState& contact, ContactScratch& scratch) {
  const Mat3 local_from_world = tool_pose.orientation.conjugate().toRotationMatrix();
  const ToolProfile profile = toolProfile(tool);
  auto distance = [&](int v) {
    return toolDistance(profile, local_from_world * (skinPosition(skin, v, u) - tool_pose.position)).distance;
  };

  // Of a stretched face that is in reach at least a corner is listed.
  const double reach = margin + kTissueTravel * tool.radius + cornerReach(contact.samples);
  const double stretch = std::max(kStretch, expectedStretch(contact.samples));

  // While there is room the list is unordered; when full, a heap with the farthest on top.
  const auto begin = scratch.candidate.begin();
  const int capacity = static_cast<int>(scratch.candidate.size());
  int count = 0;
  contact.overflow = false;
  const auto isNear = [&](int representative, float radius) {
    return distance(representative) <= stretch * static_cast<double>(radius) + reach;
  };
  const auto add = [&](int v) {
    const ContactScratch::Candidate found{distance(v), v};
    if (!(found.distance <= reach)) return;
    if (count < capacity) {
      begin[count++] = found;
      return;
    }
    if (!contact.overflow) std::make_heap(begin, begin + count, nearer);
    contact.overflow = true;
    if (!nearer(found, *begin)) return;
    std::pop_heap(begin, begin + count, nearer);
    begin[count - 1] = found;
    std::push_heap(begin, begin + count, nearer);
  };
  // Calls each(k) for k in [first, last) while the rows of the vertices vertex[k] further on are on their way.
  const auto forRows = [&](const std::vector<int>& vertex, int first, int last, auto each) {
    constexpr int ahead = 6;
    for (int k = first; k < std::min(first + ahead, last); ++k) prefetchVertex(skin, vertex[k]);
    for (int k = first; k < last; ++k) {
      if (k + ahead < last) prefetchVertex(skin, vertex[k + ahead]);
      each(k);
    }
  };
  forRows(skin.region_representative, 0, skin.regionCount(), [&](int r) {
    if (!isNear(skin.region_representative[r], skin.region_radius[r])) return;
    forRows(skin.cluster_representative, skin.region_begin[r], skin.region_begin[r + 1], [&](int c) {
      if (!isNear(skin.cluster_representative[c], skin.cluster_radius[c])) return;
      forRows(skin.cluster_vertex, skin.cluster_begin[c], skin.cluster_begin[c + 1],
              [&](int k) { add(skin.cluster_vertex[k]); });
    });
  });
  if (contact.overflow) contact.overflow = begin->distance <= reach - (1 - kNearShare) * kTissueTravel * tool.radius;
  // The order of the list must not depend on the clusters: the solver sweeps in it.
  std::sort(begin, begin + count, [](const auto& a, const auto& b) { return a.vertex < b.vertex; });

  // Merge with the old list, which is sorted too.
  scratch.keepOld(contact.count, contact.vertex, contact.force, contact.normal, contact.side);
  int old = 0;
  for (int k = 0; k < count; ++k) {
    const int v = begin[k].vertex;
    while (old < contact.count && scratch.old_id[old] < v) ++old;
    const bool stays = old < contact.count && scratch.old_id[old] == v;
    contact.vertex[k] = v;
    contact.force[k] = stays ? scratch.old_force[old] : Float4{};
    contact.normal[k] = stays ? scratch.old_normal[old] : Vec3f(Vec3f::Zero());
    contact.side[k] = stays ? scratch.old_side[old] : Vec3f(Vec3f::Zero());
  }
  contact.count = count;
}

}  // namespace palpate
