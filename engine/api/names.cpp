#include <algorithm>

#include "api/border.h"
#include "api/handles.h"

using namespace palpate;
using namespace palpate::api;

namespace {

const std::vector<std::string>* namesIn(const palpate_model* model, std::int32_t kind) {
  const bool known = model != nullptr && kind >= PALPATE_MATERIAL && kind <= PALPATE_RIGID;
  return known ? &model->names[static_cast<std::size_t>(kind)] : nullptr;
}

/// Those that several have get a number: "sphere 1", "sphere 2".
std::vector<std::string> numbered(const std::vector<std::string>& names) {
  std::vector<std::string> result;
  for (auto name = names.begin(); name != names.end(); ++name)
    result.push_back(std::count(names.begin(), names.end(), *name) == 1
                         ? *name
                         : *name + " " + std::to_string(std::count(names.begin(), name, *name) + 1));
  return result;
}

}  // namespace

Names palpate::api::namesOf(const Model& model) {
  Names names;
  for (const MaterialSpec& material : model.scene.materials) {
    auto& known = names[PALPATE_MATERIAL];
    known.push_back(material.name.empty() ? "material " + std::to_string(known.size() + 1) : material.name);
  }
  std::vector<std::string> tools;
  for (const ToolSpec& tool : model.scene.tools)
    tools.emplace_back(tool.jaws() ? "jaws" : toolType(tool.shape.kind).name);
  names[PALPATE_TOOL] = numbered(tools);
  for (const BoundarySpec& boundary : model.scene.boundaries) names[PALPATE_REGION].push_back(boundary.name);
  for (const RigidBody& body : model.rigid.body) names[PALPATE_RIGID].push_back(body.name);
  return names;
}

extern "C" {

int32_t palpate_count(const palpate_model* model, int32_t kind, int32_t* count) {
  const auto* names = namesIn(model, kind);
  if (names == nullptr) return refuse(PALPATE_BAD_ARGUMENT, "model is NULL, or kind %d is none", kind);
  if (const int32_t code = nullAmong({{count, "count"}})) return code;
  *count = static_cast<std::int32_t>(names->size());
  return PALPATE_OK;
}

const char* palpate_name(const palpate_model* model, int32_t kind, int32_t index) {
  const auto* names = namesIn(model, kind);
  if (names == nullptr || index < 0 || index >= static_cast<std::int32_t>(names->size())) return nullptr;
  return (*names)[static_cast<std::size_t>(index)].c_str();
}

int32_t palpate_index(const palpate_model* model, int32_t kind, const char* name) {
  const auto* names = namesIn(model, kind);
  if (names == nullptr || name == nullptr) return -1;
  const auto found = std::find(names->begin(), names->end(), name);
  return found != names->end() ? static_cast<std::int32_t>(found - names->begin()) : -1;
}

}  // extern "C"
