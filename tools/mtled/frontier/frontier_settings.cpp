#include "mtled/frontier/frontier_settings.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/number_text.h"
#include "setup/interface_nodes.h"

namespace palpate::tools {
namespace {

std::string times(const char* what, double factor) { return format("%s x %g", what, factor); }

std::string value(const char* what, double number) { return format("%s %g", what, number); }

}  // namespace

std::vector<FrontierSetting> frontierSettings(const Scene& scene, const std::vector<ContactRegion>& places, bool quick,
                                              int cores) {
  std::vector<FrontierSetting> settings;
  const auto add = [&](const char* group, const std::string& name,
                       std::function<void(Scene&)> turn) -> FrontierSetting& {
    settings.push_back({group, name, std::move(turn)});
    return settings.back();
  };
  add("present", "as it is", [](Scene&) {});

  for (const double factor : {2.0, 1.6, 1.3, 0.85})
    add("spacing", times("spacing", factor), [factor](Scene& s) { scaleSpacing(s, factor); });

  for (const auto& [outside, inside] : {std::pair{1.6, 0.8}, {2.0, 1.0}, {2.0, 0.7}, {1.3, 0.6}})
    if (!places.empty())
      add("refined at the tool", times("outside", outside) + ", " + times("inside", inside),
          [=, o = outside, i = inside](Scene& s) { refineWhere(s, places, o, i); });

  if (scene.discretization.quadrature.points_per_cell != 4 || scene.discretization.quadrature.accuracy > 0)
    add("quadrature, basis, support", "4 points a cell", [](Scene& s) {
      s.discretization.quadrature = {4, 1, 0, 8, 4};
    });
  if (scene.discretization.quadrature.points_per_cell != 1 || scene.discretization.quadrature.cells_per_point > 1 ||
      scene.discretization.quadrature.accuracy > 0)
    add("quadrature, basis, support", "1 point a cell", [](Scene& s) {
      s.discretization.quadrature = {1, 1, 0, 8, 4};
    });
  for (const double cells : {1.5, 2.0})
    if (cells != scene.discretization.quadrature.cells_per_point && (!quick || cells == 2))
      add("quadrature, basis, support", shortest(cells) + " cells a point", [cells](Scene& s) {
        s.discretization.quadrature = {1, cells, 0, 8, 4};
      });
  if (!quick)
    add("quadrature, basis, support", "adaptive, tau 0.1", [](Scene& s) {
      s.discretization.quadrature = {1, 1, 0.1, 8, 1};
    });
  add("quadrature, basis, support", scene.discretization.basis_degree == 2 ? "linear basis" : "quadratic basis",
      [](Scene& s) { s.discretization.basis_degree = 3 - s.discretization.basis_degree; });
  for (const double factor : {1.6, 2.2})
    if (factor != scene.discretization.support_factor)
      add("quadrature, basis, support", value("support", factor),
          [factor](Scene& s) { s.discretization.support_factor = factor; });

  const auto flip = [&](const char* name, bool Formulation::*feature) {
    add("features", std::string(name) + (scene.discretization.formulation.*feature ? " off" : " on"),
        [feature](Scene& s) { s.discretization.formulation.*feature = !(s.discretization.formulation.*feature); });
  };
  flip("consistent gradients", &Formulation::consistent_gradients);
  flip("node patches", &Formulation::node_patches);
  flip("cells' volume", &Formulation::cell_volume);
  if (hasSharpInterfaces(scene)) flip("sharp interfaces", &Formulation::sharp_interfaces);
  if (scene.discretization.formulation.node_patches && scene.discretization.formulation.own_bulk > 0)
    add("features", "patch stabilization off", [](Scene& s) { s.discretization.formulation.own_bulk = 0; });
  if (!quick)
    add("features", "the paper's scheme", [](Scene& s) { s.discretization.formulation = Formulation::paper(); });

  const bool rounded = scene.dynamics.gradient_precision == GradientPrecision::Int16;
  add("precision", rounded ? "float32 gradients" : "int16 gradients", [rounded](Scene& s) {
    s.dynamics.gradient_precision = rounded ? GradientPrecision::Float32 : GradientPrecision::Int16;
  });
  add("precision", "double", [](Scene&) {}).in_double = true;

  for (const double safety : {0.3, 0.9})
    add("time step, damping", value("step_safety", safety), [safety](Scene& s) {
      s.dynamics.time_step = 0;
      s.dynamics.step_safety = safety;
    });
  for (const double factor : {0.5, 2.0})
    if (!quick)
      add("time step, damping", times("damping", factor), [factor](Scene& s) { s.dynamics.damping *= factor; });

  // Where a few small cells limit the step, a little mass spares steps.
  for (const double share : {0.02, 0.1})
    if (share != scene.dynamics.mass_scaling && (!quick || share == 0.1))
      add("mass scaling", value("mass_scaling", share), [share](Scene& s) { s.dynamics.mass_scaling = share; });
  if (!places.empty())
    add("mass scaling", "outside x 1.3, inside x 0.6, mass_scaling 0.1", [=](Scene& s) {
      refineWhere(s, places, 1.3, 0.6);
      s.dynamics.mass_scaling = 0.1;
    });

  for (const int threads : {1, cores})
    if (threads != scene.dynamics.threads && (settings.back().threads != threads))
      add("threads", std::to_string(threads) + (threads == 1 ? " thread" : " threads"), [](Scene&) {}).threads =
          threads;
  return settings;
}

}  // namespace palpate::tools
