#include "setup/free_axes.h"

#include <algorithm>

#include "scene/scene_messages.h"

namespace palpate {

Vec3 freeAxes(const Body& body) {
  unsigned held = 0;
  for (const std::uint8_t imposed : body.imposed) held |= imposed;
  if (held == 0 && body.scene.rigid.empty()) return Vec3::Zero();
  return {held & 1U ? 0.0 : 1.0, held & 2U ? 0.0 : 1.0, held & 4U ? 0.0 : 1.0};
}

std::string looseWarning(const Body& body) {
  if (!body.scene.rigid.empty() || body.bodyCount() == 1) return {};
  std::vector<bool> held(static_cast<std::size_t>(body.bodyCount()), false);
  for (std::size_t i = 0; i < body.imposed.size(); ++i)
    if (body.imposed[i] != 0) held[static_cast<std::size_t>(body.bodyOfNode(static_cast<int>(i)))] = true;
  const auto loose = std::count(held.begin(), held.end(), false);
  if (loose == 0 || loose == static_cast<std::ptrdiff_t>(held.size())) return {};
  const auto first = static_cast<std::size_t>(std::find(held.begin(), held.end(), false) - held.begin());
  const int node = first == 0 ? 0 : body.end_node[first - 1];
  const OrganSpec& organ = body.scene.organs[static_cast<std::size_t>(
      body.node_organ.empty() ? 0 : std::max(0, body.node_organ[static_cast<std::size_t>(node)]))];
  return organ.place.text() + ": nothing holds " +
         (body.node_organ.empty() ? "a part of the organ" : inQuotes(organ.name)) +
         (loose > 1 ? " and " + std::to_string(loose - 1) + " more" : "") +
         ": what touches it pushes it away for good. Give it [[fixed]], or [[rigid]] to lie on";
}

}  // namespace palpate
