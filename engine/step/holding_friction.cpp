#include "step/holding_friction.h"

#include <algorithm>
#include <cmath>

#include "discretization/cells/background_cells.h"
#include "step/tool_contact.h"

namespace palpate {

HoldingFriction::HoldingFriction(const Model& model) {
  if (!model.hasCellVolume()) return;
  std::vector<double> area(model.X.size(), 0);
  const SkinModel& skin = model.skin;
  for (std::size_t v = 0; v < skin.area.size(); ++v)
    for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e) area[skin.node[e]] += skin.N[e] * skin.area[v];
  inverse_area_.assign(area.size(), 0);
  for (const auto& facet : boundaryFacets(model.cells))
    for (const int node : facet)
      if (area[node] > 0) inverse_area_[node] = static_cast<float>(1 / area[node]);
}

void HoldingFriction::find(const Model& model, std::span<const ContactState> tools,
                           const std::array<double, max_tools>& of_tools, const SkinContactState& skins,
                           const RigidState& rigid, AlignedVector<float>& friction) {
  if (inverse_area_.empty()) return;
  if (any_) std::fill(friction.begin(), friction.end(), 0.0F);
  any_ = false;
  const SkinModel& skin = model.skin;
  const auto add = [&](int vertex, const Float4& f, double share) {
    const float size = static_cast<float>(share) * std::sqrt(f.x * f.x + f.y * f.y + f.z * f.z);
    for (int e = skin.begin[vertex]; e < skin.begin[vertex + 1]; ++e)
      friction[skin.node[e]] += skin.N[e] * size * inverse_area_[skin.node[e]];
    any_ = true;
  };
  for (std::size_t b = 0; b < tools.size(); ++b)
    if (const double coefficient = of_tools[static_cast<std::size_t>(model.tools.body[b].tool)]; coefficient > 0)
      forEachContactForce(tools[b], [&](int vertex, const Float4& f) { add(vertex, f, coefficient); });
  for (int k = 0; k < skins.count; ++k) {
    if (isZero(skins.force[k])) continue;
    const auto& corners = skin.surface.triangles[skins.face[k]];
    const auto of = [&](int vertex) { return static_cast<double>(model.bodies.friction[model.bodies.body[vertex]]); };
    const double coefficient = std::max(of(skins.vertex[k]), of(corners[0]));
    if (coefficient <= 0) continue;
    add(skins.vertex[k], skins.force[k], coefficient);
    for (const int corner : corners) add(corner, skins.force[k], coefficient / 3);
  }
  for (const RigidBody& body : model.rigid.body)
    for (int p = body.begin; p < body.end && body.friction > 0; ++p)
      if (!isZero(rigid.force[p])) add(model.rigid.vertex[p], rigid.force[p], body.friction);
  if (!any_) return;
  for (std::size_t k = 0; k < model.side_node.size(); ++k) friction[model.X.size() + k] = friction[model.side_node[k]];
}

}  // namespace palpate
