#include "app/panels/reference_curve.h"

#include <cmath>
#include <filesystem>
#include <string_view>

#include "base/input_error.h"
#include "contact/tools/tool_list.h"
#include "io/force_rows.h"

namespace palpate::app {

ReferenceCurve readReferenceCurve(const std::string& file) {
  constexpr std::size_t most_points = 4000;  // more would not be seen
  ReferenceCurve reference;
  reference.label = std::filesystem::path(file).filename().string();
  for (const ForceRow& row : readForceRows(file, false))
    reference.curve.push_back({static_cast<float>(1e3 * row.depth), static_cast<float>(row.force)});
  if (reference.curve.size() < 2) throw InputError({file}, "fewer than two points", "give a row for each depth");
  if (reference.curve.size() > most_points) {
    const std::size_t every = reference.curve.size() / most_points + 1;
    std::vector<PlotPoint> thinned;
    for (std::size_t k = 0; k < reference.curve.size(); k += every) thinned.push_back(reference.curve[k]);
    reference.curve = std::move(thinned);
  }
  return reference;
}

std::optional<ReferenceCurve> hertzCurve(const Body& model, const Material& material, double depth_mm) {
  if (model.scene.materials.size() != 1 || material.fibre_modulus > 0 ||
      std::string_view(toolType(model.scene.tools[0].shape.kind).name) != "sphere")
    return {};
  constexpr int points = 60;
  const double K = material.bulk_modulus, mu = material.shear_modulus, R = model.scene.tools[0].shape.radius;
  const double young = 9 * K * mu / (3 * K + mu), poisson = (3 * K - 2 * mu) / (2 * (3 * K + mu));
  ReferenceCurve hertz;
  hertz.label = "Hertz";
  for (int k = 0; k <= points; ++k) {
    const double d = 1e-3 * depth_mm * k / points;
    const double F = 4.0 / 3 * young / (1 - poisson * poisson) * std::sqrt(R * d) * d;
    hertz.curve.push_back({static_cast<float>(1e3 * d), static_cast<float>(F)});
  }
  return hertz;
}

}  // namespace palpate::app
