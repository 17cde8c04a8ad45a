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
#include "base/parallel_for.h"
#include "discretization/surface/surface_geometry.h"
#include "io/find_asset.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/scene_file.h"
#include "mechanics/materials/material_law.h"
#include "mtled/identify/coarse_to_fine.h"
#include "mtled/identify/identify_regions.h"
#include "mtled/identify/identify_remarks.h"
#include "mtled/report/pictures.h"
#include "mtled/run/progress.h"

namespace palpate::tools {
namespace {

constexpr std::size_t most_parameters = 2;
constexpr int found_it = 0, not_found = 1, doubted = 3;

/// A number of a material that is sought: a parameter, or an entry of one that is a list.
struct SoughtNumber {
  std::string parameter;
  std::size_t entry = 0;
};

/// What is sought, with the scene's values to begin from.
struct Sought {
  std::vector<SoughtNumber> number;         // (parameter_count)
  std::vector<SoughtParameter> parameters;  // likewise
  Material start;
};

/// The numbers of a material's law by their scene keys: "young"; "mu" of a list of one, "mu[0]" of a longer one.
Sought numbersOf(const Material& material) {
  Sought all;
  for (const Parameter& p : material.lawDescription().parameters) {
    const auto values = material.get(p.name);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::string name = values.size() > 1 ? std::string(p.name) + "[" + std::to_string(k) + "]" : p.name;
      all.number.push_back({p.name, k});
      all.parameters.push_back({name, p.range, values[k]});
    }
  }
  return all;
}

Sought soughtOf(const IdentifyOptions& options, const Scene& scene) {
  if (options.material < 0 || options.material >= static_cast<int>(scene.materials.size()))
    throw InputError(scene.place, "there is no material " + std::to_string(options.material),
                     "the first has the number 0");
  const Material& material = scene.materials[static_cast<std::size_t>(options.material)].material;
  const Sought all = numbersOf(material);
  std::vector<std::string> wanted = options.parameters, names;
  for (const SoughtParameter& p : all.parameters) names.push_back(p.name);
  if (wanted.empty()) wanted.push_back(names.front());
  if (wanted.size() > most_parameters)
    throw InputError({}, "a force curve does not tell more than two parameters", "name one or two with --parameter");
  Sought sought;
  sought.start = material;
  for (const std::string& name : wanted) {
    const auto found = std::find(names.begin(), names.end(), name);
    const auto k = static_cast<std::size_t>(found - names.begin());
    if (found == names.end())
      throw InputError(scene.place,
                       std::string(material.lawDescription().title) + " has no parameter " + inQuotes(name),
                       "there is " + listed(names, "and") + "; relaxation is taken as the scene gives it");
    if (std::count(wanted.begin(), wanted.end(), name) > 1)
      throw InputError({}, inQuotes(name) + " is named twice", "name each once");
    sought.number.push_back(all.number[k]);
    sought.parameters.push_back(all.parameters[k]);
  }
  return sought;
}

/// A scene, and how its tool is pressed in.
struct Press {
  std::string file;
  std::string material;  // "material[0]"
  PressWay way;
  int threads = 1;
};

/// The scene with these values, on a cloud that is coarser by a factor.
Model modelOf(const Press& press, const Sought& sought, const std::vector<double>& values, double coarser) {
  Material material = sought.start;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto present = material.get(sought.number[k].parameter);
    std::vector<double> changed(present.begin(), present.end());
    changed[sought.number[k].entry] = values[k];
    material.set(sought.number[k].parameter, changed);
  }
  std::vector<SceneChange> changes;
  for (const Parameter& p : material.lawDescription().parameters) {
    const bool is_list = p.type == Parameter::Type::Numbers;
    std::string text;
    for (const double value : material.get(p.name)) text += (text.empty() ? "" : ", ") + format("%.17g", value);
    const bool is_sought = std::any_of(sought.number.begin(), sought.number.end(),
                                       [&](const SoughtNumber& number) { return number.parameter == p.name; });
    if (is_sought) changes.push_back({press.material + "." + p.name, is_list ? "[" + text + "]" : text});
  }
  Scene scene = readScene(press.file, changes);
  if (coarser > 1) {
    scene.discretization.spacing *= coarser;
    for (RefineSpec& refine : scene.discretization.refine) refine.spacing *= coarser;
    scene.dynamics.time_step = 0;
    scene.set_up_values.clear();  // which are another scene's now
  }
  return loadModel(scene);
}

/// How much coarser a cloud of the scene may be for a search that the real one ends; 1: it is coarse enough itself.
double coarserBy(const Scene& scene) {
  constexpr double search_nodes = 1000, worth_it = 2;  // of the search's cloud; times as many that the scene has
  const double volume = signedVolume(organSurface(scene));
  double nodes = volume / (0.7 * std::pow(scene.discretization.spacing, 3));  // as checkCounts
  for (const RefineSpec& refine : scene.discretization.refine)
    nodes += 4.0 / 3 * M_PI * std::pow(refine.radius, 3) / (0.7 * std::pow(refine.spacing, 3));
  return nodes < worth_it * search_nodes ? 1 : std::cbrt(nodes / search_nodes);
}

/// Physics time in which the tool is pressed in, s. Tissue that relaxes is pressed in as fast as the measured was;
/// other tissue no slower than its own swinging asks for.
double pressSeconds(const MeasuredCurve& measured, bool relaxing, const std::string& file) {
  constexpr double slow = 2, fastest = 0.1;
  if (measured.seconds <= 0) return slow;
  if (relaxing && measured.seconds > longest_press)
    throw InputError({file},
                     format("the press took %.4g s, and at most %g s are simulated of tissue that relaxes",
                            measured.seconds, longest_press),
                     "are the times of time_s in s? --seconds says how long it took");
  return std::clamp(measured.seconds, fastest, relaxing ? longest_press : slow);
}

/// The scene's answers to values, at the measured depths.
class PressedScene {
 public:
  PressedScene(const Press& press, const Sought& sought, const MeasuredCurve& measured, const std::string& path)
      : press_(press), sought_(sought), measured_(measured), path_(path) {}

  /// @param coarser  than the scene's, the cloud's spacing
  std::vector<double> forces(const std::vector<double>& values, double coarser) {
    std::string detail;
    for (std::size_t k = 0; k < values.size(); ++k)
      detail += format(" %s %.5g", sought_.parameters[k].name.c_str(), values[k]);
    ++curves_;
    progress_.show(curves_ / (curves_ + 5.0),
                   "curve " + std::to_string(curves_) + (coarser > 1 ? " on a coarser cloud" : "") + ":" + detail);
    const ForceCurve curve = curveOf(values, coarser);
    if (coarser == 1) last_curve_ = curve;
    std::vector<double> forces;
    for (const double depth : measured_.depth) forces.push_back(forceAt(curve, depth));
    return forces;
  }

  /// Share of the force that goes while the tool is held as the measured one was; 0: it was not.
  double fallOf(const std::vector<double>& values) const {
    if (!(measured_.held_seconds > 0)) return 0;
    PressWay way = press_.way;
    way.held_seconds = measured_.held_seconds;
    return simulateForceCurve(modelOf(press_, sought_, values, 1), way, press_.threads).fall;
  }

  const ForceCurve& lastCurve() const { return last_curve_; }  // of the scene's own cloud

 private:
  ForceCurve curveOf(const std::vector<double>& values, double coarser) {
    const bool first = !units_checked_;
    const Model model = modelAt(values, coarser, first && coarser == 1);
    if (first) checkUnits(measured_, path_, model);
    const ForceCurve curve = simulateForceCurve(model, press_.way, press_.threads);
    if (first) checkUnits(measured_, path_, forceAt(curve, press_.way.deepest));
    units_checked_ = true;
    return curve;
  }

  Model modelAt(const std::vector<double>& values, double coarser, bool as_given) {
    try {
      return modelOf(press_, sought_, values, coarser);
    } catch (const InputError& error) {  // of what was tried, not of the user
      if (as_given) throw;
      throw std::runtime_error(error.what());
    }
  }

  const Press& press_;
  const Sought& sought_;
  const MeasuredCurve& measured_;
  const std::string& path_;
  ProgressLine progress_{"identify"};
  ForceCurve last_curve_;
  int curves_ = 0;
  bool units_checked_ = false;
};

/// The search, on a coarser cloud where one is worth it and feels what is sought.
CoarseToFine searched(PressedScene& scene, const Sought& sought, const MeasuredCurve& measured, double coarser) {
  const Answer fine = [&](const std::vector<double>& values) { return scene.forces(values, 1); };
  if (coarser > 1) {
    try {
      return identifyCoarseToFine(
          sought.parameters, measured.force,
          [&](const std::vector<double>& values) { return scene.forces(values, coarser); }, fine);
    } catch (const CoarseFailed&) {
    }
  }
  CoarseToFine result = identifyFine(sought.parameters, measured.force, fine);
  fine(result.found.value);
  return result;
}

/// What there is to doubt of the scene's own answer with what was found; "": nothing.
std::string doubtOfScene(const RunTrust& trust) {
  const Doubt doubt = trust.doubt();
  if (doubt == Doubt::None) return {};
  if (doubt != Doubt::Resolution)
    return format("from %.3g mm on the scene's own force is not to be trusted: ", 1e3 * trust.firstTime()) +
           doubtText(doubt);
  return format("the scene's cloud puts its force off by some %.0f %%, and what was found, too: ",
                100 * trust.expectedError()) +
         doubtText(doubt);
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
  if (options.regions) return identifyRegions(options);
  const std::string file = findScene(options.scene);
  const Scene scene = readScene(file);
  const Sought sought = soughtOf(options, scene);
  const MeasuredCurve measured = readForceCurve(options.measured);
  const bool relaxing = std::any_of(scene.materials.begin(), scene.materials.end(),
                                    [](const MaterialSpec& m) { return m.material.relaxation_count > 0; });
  if (scene.tools[0].jaws())
    throw InputError(scene.tools[0].place,
                     "the scene's first tool is jaws, and a curve is of one tool that is pressed in",
                     "give a scene with the tool of the experiment");
  const double seconds = options.seconds > 0 ? options.seconds : pressSeconds(measured, relaxing, options.measured);
  const bool in_time = measured.seconds > 0 || options.seconds > 0;
  const Press press{file,
                    "material[" + std::to_string(options.material) + "]",
                    {measured.deepest(), seconds},
                    threadsOr(options.threads)};
  const std::string folder =
      options.out.empty() ? "out/" + std::filesystem::path(file).stem().string() + "_identify" : options.out;
  makeFolder(folder, "choose another place with --out");

  const double coarser = coarserBy(scene);
  PressedScene pressed(press, sought, measured, options.measured);
  const CoarseToFine search = searched(pressed, sought, measured, coarser);
  Identified found = search.found;
  std::optional<double> fall;
  if (relaxing && in_time) fall = pressed.fallOf(found.value);
  Remarks remarks = judge(measured, fall, sought.parameters, found);
  const double of_cloud = pressed.lastCurve().trust.expectedError();
  widenForErrorAlong(of_cloud, measured.force, sought.parameters, found);
  if (const std::string doubt = doubtOfScene(pressed.lastCurve().trust); !doubt.empty())
    remarks.doubts.push_back(doubt);
  if (relaxing && !in_time)
    remarks.doubts.push_back(
        format("the scene's tissue relaxes, and the file has no times (time_s): it was pressed in "
               "%g s, which the interval takes for true; --seconds says how long it took",
               seconds));
  const double largest = *std::max_element(measured.force.begin(), measured.force.end());
  nlohmann::ordered_json report{{"program", buildInfo()},
                                {"scene", scene.name},
                                {"converged", found.converged},
                                {"told_apart", found.told_apart},
                                {"misfit_N", found.misfit},
                                {"misfit_of_largest_force", found.misfit / largest},
                                {"structured_misfit_N", found.structure},
                                {"doubts", remarks.doubts},
                                {"notes", remarks.notes},
                                {"rows", measured.depth.size()},
                                {"pressed_in_s", seconds},
                                {"expected_force_error", of_cloud},
                                {"curves_simulated", search.fine_solves},
                                {"curves_on_a_coarser_cloud", search.coarse_solves},
                                {"coarser_by", coarser}};
  for (std::size_t k = 0; k < sought.parameters.size(); ++k) {
    const std::string& name = sought.parameters[k].name;
    report["parameters"][name] = intervalOf(found, search.found, k);
    std::cout << format("%-12s %.6g   (95 %%: %.6g .. %.6g)\n", name.c_str(), found.value[k], found.low[k],
                        found.high[k]);
  }
  std::cout << format("misfit       %.3g %% of the largest force, %.4g N\n", 100 * found.misfit / largest, largest);
  std::cout << format("cloud        puts the scene's force off by some %.2g %%, which the interval allows for\n",
                      100 * of_cloud);
  if (!found.converged) std::cout << "no convergence: begin from nearer values, or seek one parameter\n";
  for (const std::string& doubt : remarks.doubts) std::cout << "DOUBTED      " << doubt << "\n";
  for (const std::string& note : remarks.notes) std::cout << "note         " << note << "\n";
  writeWholeFile(folder + "/identify.json", report.dump(2) + "\n");
  std::cout << "picture      "
            << writePicture(folder + "/identify.png", figureOf(scene.name, measured, pressed.lastCurve())) << std::endl;
  if (!found.converged) return not_found;
  if (!remarks.doubts.empty()) return doubted;
  return found.told_apart ? found_it : not_found;
}

}  // namespace palpate::tools
