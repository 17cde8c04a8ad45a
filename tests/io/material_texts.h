#pragma once

#include <string>

#include "base/number_text.h"
#include "io/scene_texts.h"
#include "mechanics/materials/material_law.h"

namespace palpate {

inline std::string keyLine(const Parameter& p, std::span<const double> values) {
  std::string text = std::string(p.name) + " = ";
  if (p.type == Parameter::Type::Number) return text + shortest(values[0]) + "\n";
  if (p.type == Parameter::Type::Pairs) {
    for (std::size_t k = 0; k < values.size(); k += 2)
      text += (k == 0 ? "[[" : ", [") + shortest(values[k]) + ", " + shortest(values[k + 1]) + "]";
    return text + "]\n";
  }
  for (std::size_t k = 0; k < values.size(); ++k) text += (k == 0 ? "[" : ", ") + shortest(values[k]);
  return text + "]\n";
}

/// Whether scenes say a parameter of all laws, and not their scheme.
inline bool isSceneKey(const Parameter& p) {
  for (const CommonMaterialParameter& common : commonMaterialParameters())
    if (!common.is_key && std::string_view(common.parameter.name) == p.name) return false;
  return true;
}

/// The minimal scene with this material, without its key `left_out`.
inline std::string sceneOf(const Material& m, const std::string& left_out = "") {
  std::string text = std::string("model = \"") + m.lawDescription().name + "\"\n";
  forEachParameter(m, [&](const Parameter& p, std::span<const double> values) {
    if (p.name != left_out && isSceneKey(p)) text += keyLine(p, values);
  });
  const std::size_t begin = minimal_scene.find("model = "), end = minimal_scene.find('[', begin);
  return minimal_scene.substr(0, begin) + text + minimal_scene.substr(end);
}

}  // namespace palpate
