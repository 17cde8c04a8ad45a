#include "mtled/identify/identify_command.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/build_info.h"
#include "base/nearest_word.h"
#include "base/number_text.h"
#include "io/find_asset.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/scene_file.h"
#include "mechanics/materials/material_law.h"
#include "mtled/identify/force_curve.h"
#include "mtled/identify/identify.h"
#include "mtled/pictures/pictures.h"
#include "mtled/run/progress.h"

namespace palpate::tools {
namespace {

constexpr std::size_t most_parameters = 2;

/// What is sought, with the scene's values to begin from.
std::vector<SoughtParameter> soughtOf(const IdentifyOptions& options, const Scene& scene) {
  if (options.material < 0 || options.material >= static_cast<int>(scene.materials.size()))
    throw InputError(scene.place, "there is no material " + std::to_string(options.material),
                     "the first has the number 0");
  const Material& material = scene.materials[static_cast<std::size_t>(options.material)].material;
  const MaterialLaw& law = material.lawDescription();
  std::vector<std::string> wanted = options.parameters, names;
  if (wanted.empty()) wanted.emplace_back(law.parameters.front().name);
  if (wanted.size() > most_parameters)
    throw InputError({}, "a force curve does not tell more than two parameters", "name one or two with --parameter");
  std::vector<SoughtParameter> sought;
  for (const std::string& name : wanted) {
    names.clear();
    const std::size_t before = sought.size();
    for (const Parameter& p : law.parameters) {
      if (p.type != Parameter::Type::Number) continue;
      names.emplace_back(p.name);
      if (name == p.name) sought.push_back({name, p.range, material.get(name).front()});
    }
    if (sought.size() == before)
      throw InputError(scene.place, std::string(law.title) + " has no " + inQuotes(name) + " that is one number",
                       names.empty() ? "" : "there is " + listed(names, "and"));
  }
  return sought;
}

/// The curve of the scene with these values.
ForceCurve curveOf(const IdentifyOptions& options, const std::string& file, const std::vector<SoughtParameter>& sought,
                   const std::vector<double>& values, double deepest) {
  std::vector<SceneChange> changes;
  for (std::size_t k = 0; k < sought.size(); ++k)
    changes.push_back(
        {"material[" + std::to_string(options.material) + "]." + sought[k].name, format("%.17g", values[k])});
  std::optional<Model> model;
  try {
    model = loadModel(readScene(file, changes));
  } catch (const InputError& error) {  // of the values that were tried, not of the user
    throw std::runtime_error(error.what());
  }
  return simulateForceCurve(*model, deepest, options.seconds);
}

Figure figureOf(const std::string& scene, const ForceCurve& measured, const ForceCurve& fitted) {
  Figure figure;
  figure.title = scene;
  figure.x_label = "Depth, mm";
  figure.y_label = "Force, N";
  Series points{"measured", {}, measured.force, SeriesStyle::Points}, line{"identified", {}, fitted.force};
  for (const double depth : measured.depth) points.x.push_back(1e3 * depth);
  for (const double depth : fitted.depth) line.x.push_back(1e3 * depth);
  figure.series = {points, line};
  return figure;
}

}  // namespace

int identifyCommand(const IdentifyOptions& options) {
  const std::string file = findScene(options.scene);
  const Scene scene = readScene(file);
  const std::vector<SoughtParameter> sought = soughtOf(options, scene);
  const ForceCurve measured = readForceCurve(options.measured);
  const std::string folder =
      options.out.empty() ? "out/" + std::filesystem::path(file).stem().string() + "_identify" : options.out;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) failWriting(folder, error.value(), "choose another place with --out");

  Identified found;
  {
    ProgressLine progress("identify");
    int evaluation = 0;
    found = identify(sought, [&](const std::vector<double>& values) {
      std::string detail;
      for (std::size_t k = 0; k < sought.size(); ++k) detail += format(" %s %.5g", sought[k].name.c_str(), values[k]);
      ++evaluation;
      progress.show(evaluation / (evaluation + 5.0), "curve " + std::to_string(evaluation) + ":" + detail);
      const ForceCurve curve = curveOf(options, file, sought, values, measured.deepest());
      std::vector<double> residuals;
      for (std::size_t r = 0; r < measured.depth.size(); ++r)
        residuals.push_back(forceAt(curve, measured.depth[r]) - measured.force[r]);
      return residuals;
    });
  }
  const ForceCurve fitted = curveOf(options, file, sought, found.value, measured.deepest());
  const double largest = *std::max_element(measured.force.begin(), measured.force.end());
  nlohmann::ordered_json report{{"program", buildInfo()},        {"scene", scene.name},
                                {"converged", found.converged},  {"told_apart", found.told_apart},
                                {"misfit_N", found.misfit},      {"misfit_of_largest_force", found.misfit / largest},
                                {"rows", measured.depth.size()}, {"curves_simulated", found.evaluations}};
  for (std::size_t k = 0; k < sought.size(); ++k) {
    report["parameters"][sought[k].name] = {
        {"value", found.value[k]}, {"low_95", found.low[k]}, {"high_95", found.high[k]}};
    std::cout << format("%-12s %.6g   (95 %%: %.6g .. %.6g)\n", sought[k].name.c_str(), found.value[k], found.low[k],
                        found.high[k]);
  }
  std::cout << format("misfit       %.3g %% of the largest force, %.4g N\n", 100 * found.misfit / largest, largest);
  if (!found.converged) std::cout << "no convergence: begin from nearer values, or seek one parameter\n";
  if (!found.told_apart)
    std::cout << "the curve does not tell the parameters apart: give one, or measure deeper or with another tool\n";
  writeWholeFile(folder + "/identify.json", report.dump(2) + "\n");
  std::cout << "picture      " << writePicture(folder + "/identify.png", figureOf(scene.name, measured, fitted))
            << std::endl;
  return found.converged && found.told_apart ? 0 : 1;
}

}  // namespace palpate::tools
