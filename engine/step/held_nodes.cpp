#include "step/held_nodes.h"

#include "step/tool_contact.h"

namespace palpate {

bool touchesBesideHeld(const Model& model, std::span<const ContactState> tools, const SkinContactState& skins,
                       const RigidState& rigid) {
  const std::vector<std::uint8_t>& beside = model.beside_held;
  if (beside.empty()) return false;
  bool touches = false;
  for (const ContactState& contact : tools)
    forEachContactForce(contact, [&](int vertex, const Float4&) { touches |= beside[vertex] != 0; });
  for (int k = 0; k < skins.count && !touches; ++k) {
    if (isZero(skins.force[k])) continue;
    touches |= beside[skins.vertex[k]] != 0;
    for (const int corner : model.skin.surface.triangles[skins.face[k]]) touches |= beside[corner] != 0;
  }
  for (std::size_t p = 0; p < rigid.force.size() && !touches; ++p)
    touches |= beside[model.rigid.vertex[p]] != 0 && !isZero(rigid.force[p]);
  return touches;
}

}  // namespace palpate
