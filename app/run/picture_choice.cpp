#include "app/run/picture_choice.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <span>
#include <utility>
#include <vector>

namespace palpate::app {

namespace {

struct NamedView {
  const char* name;
  double azimuth_deg, elevation_deg;
};
constexpr std::array named_views{NamedView{"front", -90, 0}, NamedView{"back", 90, 0},  NamedView{"left", 180, 0},
                                 NamedView{"right", 0, 0},   NamedView{"top", -90, 89}, NamedView{"bottom", -90, -89}};

constexpr std::array named_fields{std::pair{"tissue", ColourMap::Tissue},
                                  std::pair{"displacement", ColourMap::Displacement},
                                  std::pair{"von_mises", ColourMap::VonMises}, std::pair{"J", ColourMap::J},
                                  std::pair{"pressure", ColourMap::Pressure}};

constexpr std::array named_overlays{std::pair{"nodes", &View::show_nodes},  std::pair{"points", &View::show_points},
                                    std::pair{"force", &View::show_forces}, std::pair{"contact", &View::show_contact},
                                    std::pair{"fixed", &View::show_fixed},  std::pair{"tool", &View::show_tool}};

std::vector<std::string> splitAt(const std::string& text, char separator) {
  std::vector<std::string> all;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(separator, begin);
    all.push_back(text.substr(begin, end - begin));
    if (end == std::string::npos) return all;
    begin = end + 1;
  }
}

/// Finite numbers, or none where one of them is no number.
std::vector<double> numbersOf(const std::vector<std::string>& texts) {
  std::vector<double> values;
  for (const std::string& text : texts) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0' || !std::isfinite(value)) return {};
    values.push_back(value);
  }
  return values;
}

std::string unknownOverlay(const std::string& list) {
  if (list.empty()) return {};
  for (const std::string& name : splitAt(list, ',')) {
    bool known = false;
    for (const auto& [overlay, member] : named_overlays) known |= name == overlay;
    if (!known) return name;
  }
  return {};
}

}  // namespace

std::string readPictureChoice(const std::string& camera, const std::string& view, const std::string& field,
                              const std::string& range, PictureChoice& choice) {
  if (!camera.empty() && !view.empty()) return "--camera and --view both say where to look from; give one of them";
  if (!camera.empty()) {
    const std::vector<double> values = numbersOf(splitAt(camera, ','));
    if (values.size() < 2 || values.size() > 3 || std::abs(values[1]) > 90 || (values.size() == 3 && values[2] <= 0))
      return "--camera: '" + camera + "' is not AZIMUTH,ELEVATION[,DISTANCE] in degrees (up to 90) and m, e.g. -60,25";
    choice.azimuth_deg = values[0];
    choice.elevation_deg = values[1];
    if (values.size() == 3) choice.distance_m = values[2];
  }
  if (!view.empty()) {
    for (const NamedView& one : named_views)
      if (view == one.name) {
        choice.azimuth_deg = one.azimuth_deg;
        choice.elevation_deg = one.elevation_deg;
      }
    if (!choice.azimuth_deg) return "--view: '" + view + "' is not front, back, left, right, top or bottom";
  }
  if (!field.empty()) {
    bool known = false;
    for (const auto& [name, map] : named_fields)
      if (field == name) {
        choice.field = map;
        known = true;
      }
    if (!known) return "--field: '" + field + "' is not tissue, displacement, von_mises, J or pressure";
  }
  if (!range.empty()) {
    const std::vector<double> values = numbersOf(splitAt(range, ':'));
    if (values.size() != 2 || !(values[0] < values[1]))
      return "--range: '" + range + "' is not LOW:HIGH in m, Pa or 1, e.g. 0:0.01";
    if (choice.field == ColourMap::Tissue) return "--range is for the colours of --field; add --field displacement";
    choice.low = values[0];
    choice.high = values[1];
  }
  for (const std::string* list : {&choice.show, &choice.hide})
    if (const std::string name = unknownOverlay(*list); !name.empty())
      return "'" + name + "' is no overlay; --show and --hide take nodes, points, force, contact, fixed, tool";
  return {};
}

bool PictureChoice::showsInside() const {
  View view;
  applyChoice(*this, view);
  return cut || view.showsInside();
}

void applyChoice(const PictureChoice& choice, View& view) {
  view.camera.azimuth_deg = choice.azimuth_deg.value_or(view.camera.azimuth_deg);
  view.camera.elevation_deg = choice.elevation_deg.value_or(view.camera.elevation_deg);
  view.camera.distance = choice.distance_m.value_or(view.camera.distance);
  view.colour_map = choice.field;
  view.ghost = choice.ghost;
  if (choice.low && choice.high) {
    view.colour_auto = false;
    view.colour_min = *choice.low;
    view.colour_max = *choice.high;
  }
  for (const auto& [list, shown] : {std::pair{choice.show, true}, std::pair{choice.hide, false}}) {
    if (list.empty()) continue;
    for (const std::string& name : splitAt(list, ','))
      for (const auto& [overlay, member] : named_overlays)
        if (name == overlay) view.*member = shown;
  }
}

}  // namespace palpate::app
