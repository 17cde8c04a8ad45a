#include "batch/batch_tools.h"

#include <algorithm>
#include <array>

#include "step/tool_bodies.h"

namespace palpate {

ToolsAt between(const ToolsAt& from, const ToolsAt& to, double share) {
  ToolsAt at = to;
  for (int t = 0; t < to.count; ++t) {
    const auto k = static_cast<std::size_t>(t);
    at.posture[k] = between(from.posture[k], to.posture[k], share);
  }
  return at;
}

BatchTools::BatchTools(const Model& model) : model_(model) {
  for (int t = 0; t < model.tools.toolCount(); ++t)
    before_.posture[static_cast<std::size_t>(t)] = model.tools.tool[t].start;
  before_.count = model.tools.toolCount();
  now_.posture = before_.posture;
  for (int b = 0; b < model.tools.bodyCount(); ++b)
    contact_.push_back(makeContactState(model.skin, model.tools.body[b].shape));
  scratch_.assign(contact_.size(), ContactScratch(model.skin));
}

ContactForces BatchTools::solve(const ContactStep& step, Touching touching, ToolLoads& loads) {
  std::array<TouchingTool, max_tool_bodies> tools;
  const ToolSet& set = model_.tools;
  const auto count = static_cast<std::size_t>(bodyCount());
  for (std::size_t b = 0; b < count; ++b) {
    const ToolBody& body = set.body[b];
    const auto t = static_cast<std::size_t>(body.tool);
    const Pose pose = bodyPose(body, now_.posture[t]), before = bodyPose(body, before_.posture[t]);
    const double margin = 2 * largestTravel(body.shape, before, pose);
    findContactCandidates(model_.skin, step.u, body.shape, pose, margin, contact_[b], scratch_[b]);
    findFaceSamples(model_.skin, step.u, body.shape, pose, margin, contact_[b], scratch_[b]);
    tools[b] = {&body.shape, pose, before, set.tool[t].friction, &contact_[b], &scratch_[b]};
  }
  touching.tools = {tools.data(), count};
  const ContactForces forces = solveContacts(step, touching);
  for (std::size_t b = 0; b < count; ++b) addToLoad(set.body[b], tools[b], loads);
  if (present()) before_ = now_;
  return forces;
}

/// Those of the tools that are there, which come first.
int BatchTools::bodyCount() const {
  int count = 0;
  while (count < model_.tools.bodyCount() && model_.tools.body[count].tool < now_.count) ++count;
  return count;
}

double BatchTools::maxPenetration() const {
  double deepest = 0;
  for (int b = 0; b < bodyCount(); ++b)
    deepest = std::max(deepest, contact_[static_cast<std::size_t>(b)].max_penetration *
                                    model_.scene.tools[0].shape.radius / model_.tools.body[b].shape.radius);
  return deepest;
}

bool BatchTools::overflow() const {
  return std::any_of(contact_.begin(), contact_.end(), [](const ContactState& contact) { return contact.overflow; });
}

}  // namespace palpate
