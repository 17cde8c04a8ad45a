// What the tissue is made of, and how it can be changed while it runs.
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>
#include <vector>

#include "app/panels/panels.h"
#include "app/panels/widgets.h"
#include "mechanics/materials/material_law.h"

namespace palpate::app {

namespace {

constexpr double min_stiffness_percent = 10;  // softer tissue sinks under its own contact

std::string pressure(double pa) {
  if (std::abs(pa) >= 1e6) return format("%.4g MPa", 1e-6 * pa);
  if (std::abs(pa) >= 1e4) return format("%.4g kPa", 1e-3 * pa);
  return format("%.4g Pa", pa);
}

std::string replacedAll(const std::string& text, const std::string& from, const std::string& to) {
  std::string replaced;
  std::size_t begin = 0;
  for (std::size_t at; (at = text.find(from, begin)) != std::string::npos; begin = at + from.size())
    replaced.append(text, begin, at - begin).append(to);
  return replaced.append(text, begin);
}

/// "2.5 kPa", "1060 kg/m^3" with the small three
std::string valueText(const Parameter& parameter, double value) {
  const std::string unit = parameter.unit;
  if (unit == "Pa") return pressure(value);
  return unit.empty() ? format("%.4g", value) : format("%.4g %s", value, replacedAll(unit, "^3", "\xC2\xB3").c_str());
}

/// Whether the two sliders of elastic constants show it.
bool onSlider(const Parameter& parameter) {
  const std::string_view name = parameter.name;
  return name == "young" || name == "poisson";
}

/// A row for each parameter that has a label: the law's own, or those that all laws have.
/// @param sliders  whether sliders show the elastic constants
void drawParameters(const Theme& theme, const Material& material, bool common, bool sliders) {
  const std::size_t own_count = material.lawDescription().parameters.size();
  std::size_t number = 0;
  struct Row {
    std::string label, value;
  };
  std::vector<Row> terms;  // of the lists: one row holds an entry of each
  forEachParameter(material, [&](const Parameter& parameter, std::span<const double> values) {
    if ((number++ >= own_count) != common || *parameter.label == '\0' || (sliders && onSlider(parameter))) return;
    std::string label = parameter.label;
    if (!theme.has_greek) label = replacedAll(replacedAll(label, "\xCE\xBD", "nu"), "\xCE\xBC", "mu");
    if (parameter.type == Parameter::Type::Number) return row(label.c_str(), valueText(parameter, values[0]));
    if (parameter.type == Parameter::Type::Vector)
      return row(label.c_str(), format("%.3g, %.3g, %.3g", values[0], values[1], values[2]));
    if (parameter.type == Parameter::Type::Pairs) {
      std::string pairs;
      for (std::size_t k = 0; k < values.size(); k += 2)
        pairs += (pairs.empty() ? "" : ", ") + format("%.3g %% in %.3g s", 100 * values[k], values[k + 1]);
      if (!pairs.empty()) row(label.c_str(), pairs, colours::text, "shares of the shear stress, and their times");
      return;
    }
    terms.resize(values.size());
    for (std::size_t k = 0; k < values.size(); ++k) {
      const char* separator = terms[k].label.empty() ? "" : ", ";
      terms[k].label.append(separator).append(label).append(std::to_string(k + 1));
      terms[k].value.append(separator).append(valueText(parameter, values[k]));
    }
  });
  for (const Row& term : terms) row(term.label.c_str(), term.value);
}

void drawMaterial(const Theme& theme, const MaterialView& view) {
  const Material& material = view.material;
  const char* law = material.lawDescription().title;
  const int terms = material.term_count;
  row(view.name.empty() ? "Model" : view.name.c_str(),
      terms == 0 ? law : format("%s, %d term%s", law, terms, terms == 1 ? "" : "s"));
  drawParameters(theme, material, false, view.elastic_constants);
  row("Shear modulus", pressure(material.shear_modulus));
  row("Bulk modulus", pressure(material.bulk_modulus));
  drawParameters(theme, material, true, view.elastic_constants);
}

}  // namespace

namespace {

constexpr const char* step_bounds =
    "stiffer, and the time step of this scene would be too long: set it in the scene file";

/// A slider up to what the time step lets it be; where it stands there, why it goes no further.
bool boundedSlider(const Theme& theme, const char* name, double& value, double low, double high, double most,
                   const char* pattern, const std::string& reason) {
  auto shown = static_cast<float>(value);
  const bool moved =
      slider(name, shown, static_cast<float>(low), static_cast<float>(std::min(high, most)), pattern, reason);
  if (moved) value = std::min(static_cast<double>(shown), most);
  if (most < high && value > 0.99 * most) note(theme, std::string(name) + " is at its bound: " + step_bounds + ".");
  return moved;
}

/// True where the hand changed it; then `material` is what it is to be.
bool drawMaterialSliders(const Theme& theme, const PanelData& data, const MaterialView& view, Material& material) {
  if (!view.elastic_constants) {
    double percent = 100 * view.stiffness;
    if (!boundedSlider(theme, "Stiffness", percent, min_stiffness_percent, 400, 100 * view.most_stiffness,
                       "%.0f %% of scene", data.input_note))
      return false;
    material = stiffened(material, percent / (100 * view.stiffness));
    return true;
  }
  double young = 1e-3 * material.get("young")[0], poisson = material.get("poisson")[0];
  const bool softer = boundedSlider(theme, "Young's modulus", young, 1e-5 * min_stiffness_percent * view.scene_young,
                                    4e-3 * view.scene_young, 1e-3 * view.most_young, "%.2f kPa", data.input_note);
  if (softer) material.set("young", 1e3 * young);
  const bool squeezed =
      boundedSlider(theme, "Poisson's ratio", poisson, 0.3, 0.4995, view.most_poisson, "%.4f", data.input_note);
  if (squeezed && !softer) material.set("poisson", poisson);
  return softer || squeezed;
}

/// Hundreds of mixtures can't be set one by one: how far their step would let them go, and where they are set.
void drawMixedBound(const Theme& theme, const PanelData& data) {
  const double ratio = data.model.dt > 0 ? data.model.dt_critical / data.model.dt : 1;
  row("Bound by the step", format("%.1f times as stiff", ratio * ratio), colours::text,
      "a wave's speed grows with the root of the stiffness, and the step must not outlast it");
  note(theme,
       format("An image mixes these into %d materials: set them in the scene file.", data.materials.front().mixtures));
}

}  // namespace

void drawMaterialCard(const Theme& theme, const PanelData& data, const PanelState& state, UserActions& asked) {
  if (!beginCard(theme, "Material")) return;
  for (std::size_t k = 0; k < data.materials.size(); ++k) {
    const MaterialView& view = data.materials[k];
    if (data.searching() && k > 0) break;  // lumps are not told of
    if (k > 0) ImGui::Separator();
    if (state.engineer)
      drawMaterial(theme, view);
    else if (!view.name.empty())
      note(theme, view.name, colours::text);
    if (view.mixtures > 0) continue;
    ImGui::PushID(static_cast<int>(k));
    Material changed = view.material;
    if (drawMaterialSliders(theme, data, view, changed))
      asked.push_back({.kind = UserAction::SetMaterial, .value = static_cast<double>(k), .material = changed});
    ImGui::PopID();
  }
  if (!data.materials.empty() && data.materials.front().mixtures > 0) drawMixedBound(theme, data);
  if (button("Reset all", ImGui::GetContentRegionAvail().x)) asked.push_back({UserAction::ResetAll});
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("the tissue at rest, with the scene's own friction and stiffness; Reset keeps what was set here");
  ImGui::Spacing();
}

}  // namespace palpate::app
