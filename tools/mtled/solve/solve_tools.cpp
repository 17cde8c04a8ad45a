#include "mtled/solve/solve_tools.h"

#include <algorithm>

#include "io/indent_script.h"
#include "step/tool_bodies.h"

namespace palpate::tools {

SolveTools::SolveTools(const Scene& scene, const std::string& named) {
  const std::vector<ToolSpec>& specs = scene.tools;
  several_ = specs.size() > 1 || specs[0].jaws();
  there_ = several_ || specs[0].place.line > 0;
  for (std::size_t t = 0; t < specs.size(); ++t) {
    if (t == 0 && !named.empty())
      script_.push_back(namedScript(named, specs[t].shape.radius));
    else if (!specs[t].script.empty())
      script_.emplace_back(readToolScript(specs[t].script, specs[t].shape.radius));
    else
      script_.emplace_back();
  }
}

double SolveTools::duration() const {
  double end = 0;
  for (const auto& script : script_)
    if (script) end = std::max(end, script->duration());
  return end;
}

bool SolveTools::moved() const {
  return std::any_of(script_.begin(), script_.end(), [](const auto& script) { return script.has_value(); });
}

ToolsAt SolveTools::at(const Model& model, double time) const {
  if (!there_ && !moved()) return {};
  ToolsAt at;
  at.count = static_cast<int>(script_.size());
  for (std::size_t t = 0; t < script_.size(); ++t) {
    const ToolPosture start = model.tools.tool[t].start;
    const double travel = model.tools.tool[t].first_contact_travel;
    at.posture[t] = start;
    if (!script_[t]) continue;
    at.posture[t].pose = poseAt(*script_[t], start.pose, travel, time);
    if (model.tools.tool[t].jaws) at.posture[t].opening = std::max(0.0, openingAt(*script_[t], start.opening, time));
  }
  return at;
}

void SolveTools::addTo(ByteKey& key) const {
  key.add(there_);
  for (std::size_t t = 0; t < script_.size(); ++t) {
    if (!script_[t]) continue;
    if (t > 0) key.add(t);
    key.add(script_[t]->from_touch, script_[t]->smooth);
    for (const auto& k : script_[t]->keyframes) {
      key.add(k.time, k.advance, k.slide);
      if (several_) key.add(k.opening);
    }
  }
}

std::string toolColumn(int tool) { return tool == 0 ? "tool" : "tool" + std::to_string(tool + 1); }

}  // namespace palpate::tools
