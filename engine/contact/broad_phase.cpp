#include "contact/broad_phase.h"

#include <algorithm>

namespace palpate {
namespace {

/// Largest stretch of the skin that the cluster bounds allow for.
constexpr double kStretch = 2.0;

/// Most vertices that a contact may have: 4096 keep a step below about half a millisecond.
constexpr int kMaxCapacity = 4096;

bool nearer(const ContactState::Candidate& a, const ContactState::Candidate& b) {
  return a.distance != b.distance ? a.distance < b.distance : a.vertex < b.vertex;
}

}  // namespace

ContactState makeContactState(const SkinModel& skin, const ToolShape&) {
  const std::size_t capacity = std::min(skin.vertexCount(), kMaxCapacity);
  ContactState contact;
  contact.vertex.resize(capacity);
  contact.force.resize(capacity);
  contact.normal.resize(capacity, Vec3f::Zero());
  contact.candidate.resize(capacity);
  contact.old_vertex.resize(capacity);
  contact.old_force.resize(capacity);
  contact.old_normal.resize(capacity, Vec3f::Zero());
  contact.row.resize(capacity);
  return contact;
}

void findContactCandidates(const SkinModel& skin, const Float4* u, const ToolShape& tool,
                           const Pose& tool_pose, double margin, ContactState& contact) {
  const Mat3 local_from_world = tool_pose.orientation.conjugate().toRotationMatrix();
  auto distance = [&](int v) {
    return toolDistance(tool, local_from_world * (skinPosition(skin, v, u) - tool_pose.position)).distance;
  };

  const double reach = margin + kTissueTravel * tool.radius;

  // While there is room the list is unordered; when full, a heap with the farthest on top.
  const auto begin = contact.candidate.begin();
  const int capacity = static_cast<int>(contact.candidate.size());
  int count = 0;
  contact.overflow = false;
  for (int c = 0; c < skin.clusterCount(); ++c) {
    const double extent = kStretch * static_cast<double>(skin.cluster_radius[c]);
    if (!(distance(skin.cluster_representative[c]) <= extent + reach)) continue;
    for (int k = skin.cluster_begin[c]; k < skin.cluster_begin[c + 1]; ++k) {
      const ContactState::Candidate found{distance(skin.cluster_vertex[k]), skin.cluster_vertex[k]};
      if (!(found.distance <= reach)) continue;
      if (count < capacity) {
        begin[count++] = found;
        continue;
      }
      if (!contact.overflow) std::make_heap(begin, begin + count, nearer);
      contact.overflow = true;
      if (!nearer(found, *begin)) continue;
      std::pop_heap(begin, begin + count, nearer);
      begin[count - 1] = found;
      std::push_heap(begin, begin + count, nearer);
    }
  }
  // The order of the list must not depend on the clusters: the solver sweeps in it.
  std::sort(begin, begin + count, [](const auto& a, const auto& b) { return a.vertex < b.vertex; });

  // Merge with the old list, which is sorted too.
  std::swap(contact.vertex, contact.old_vertex);
  std::swap(contact.force, contact.old_force);
  std::swap(contact.normal, contact.old_normal);
  int old = 0;
  for (int k = 0; k < count; ++k) {
    const int v = begin[k].vertex;
    while (old < contact.count && contact.old_vertex[old] < v) ++old;
    const bool stays = old < contact.count && contact.old_vertex[old] == v;
    contact.vertex[k] = v;
    contact.force[k] = stays ? contact.old_force[old] : Float4{};
    contact.normal[k] = stays ? contact.old_normal[old] : Vec3f(Vec3f::Zero());
  }
  contact.count = count;
}

}  // namespace palpate
