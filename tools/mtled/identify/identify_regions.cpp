#include "mtled/identify/identify_regions.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/build_info.h"
#include "base/number_text.h"
#include "base/parallel_for.h"
#include "contact/contact.h"
#include "discretization/surface/surface_geometry.h"
#include "io/find_asset.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/scene_file.h"
#include "io/text_file.h"
#include "mechanics/materials/material_law.h"
#include "mtled/identify/force_curve.h"
#include "mtled/identify/identify.h"
#include "mtled/identify/identify_remarks.h"
#include "mtled/identify/pressed_regions.h"
#include "mtled/report/pictures.h"
#include "mtled/run/progress.h"
#include "step/trust.h"

namespace palpate::tools {
namespace {

/// What is sought of each material: the one parameter that was named, or its law's first.
struct SoughtOfAll {
  std::vector<MaterialNumber> numbers;
  std::vector<SoughtParameter> parameters;
};

SoughtOfAll soughtOfAll(const IdentifyOptions& options, const Scene& scene) {
  if (options.parameters.size() > 1)
    throw InputError({}, "--regions seeks one parameter of each material", "name one with --parameter");
  SoughtOfAll sought;
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    const MaterialSpec& spec = scene.materials[m];
    const auto& parameters = spec.material.lawDescription().parameters;
    const std::string wanted = options.parameters.empty() ? parameters.front().name : options.parameters.front();
    const auto found =
        std::find_if(parameters.begin(), parameters.end(), [&wanted](const Parameter& p) { return wanted == p.name; });
    const std::string name = spec.name.empty() ? "material " + std::to_string(m + 1) : spec.name;
    if (found == parameters.end() || found->type == Parameter::Type::Vector)
      throw InputError(spec.place, inQuotes(name) + " has no number " + inQuotes(wanted),
                       "name another with --parameter");
    sought.numbers.push_back({static_cast<int>(m), wanted, 0});
    sought.parameters.push_back({name, found->range, spec.material.get(wanted).front()});
  }
  return sought;
}

/// The scene with what was found, as the next start. @return whether any of it is so far from where it began that the
/// set-up, which the start is part of (what node patches average, steps, the cloud's doubts), is another's
bool putIn(const Identified& found, SoughtOfAll& sought, Scene& scene) {
  constexpr double same = 0.03;  // of the value
  bool other = false;
  for (std::size_t k = 0; k < sought.numbers.size(); ++k) {
    const MaterialNumber& number = sought.numbers[k];
    other = other || std::abs(found.value[k] - sought.parameters[k].start) > same * std::abs(found.value[k]);
    sought.parameters[k].start = found.value[k];
    scene.materials[static_cast<std::size_t>(number.material)].material.set(number.name, found.value[k]);
  }
  return other;
}

Figure figureOfRegions(const std::string& scene, const std::string& parameter, const Identified& found) {
  Figure figure;
  figure.title = scene;
  figure.x_label = "Material, in the scene's order";
  figure.y_label = parameter;
  Series values{"identified", {}, found.value, SeriesStyle::Points};
  figure.series = {values, {"95 %: low", {}, found.low}, {"95 %: high", {}, found.high}};
  for (Series& series : figure.series)
    for (std::size_t k = 0; k < found.value.size(); ++k) series.x.push_back(static_cast<double>(k) + 1);
  return figure;
}

constexpr double least_force = 0.02;  // of the largest: less is noise where nothing is touched
constexpr double far_above = 0.5;     // tool radii from the skin: nearer the scene's may be a little lower

/// m, of a press: how far its tip is past where it touched. Not finite: the tool meets no skin that way.
double depthOf(const Model& model, const SettledPress& press) {
  const ToolSetUp& tool = model.tools.first();
  Pose far = tool.start.pose;
  const Vec3 axis = far.orientation * Vec3::UnitZ();
  const double back = 2 * boundingBox(model.skin.surface).diagonal().norm();
  far.position = press.tip + back * axis;
  return back - firstContactTravel(model.skin.surface, tool.shape, far);
}

/// What the presses say of where their forces and depths count from, and what they can't. Widens the intervals.
std::vector<std::string> offsetNotes(const Model& model, const std::vector<SettledPress>& presses,
                                     const std::vector<double>& forces, const std::vector<SoughtParameter>& sought,
                                     Identified& found) {
  constexpr double alike = 1.5;         // deepest over shallowest
  constexpr double stiffening = 1.5;    // of a round tool's force with its depth (Hertz), dF/F over dd/d
  constexpr double told_misfit = 1e-3;  // of the largest force: no measurement is better
  std::vector<double> depth, slope;
  for (const SettledPress& press : presses) {
    depth.push_back(depthOf(model, press));
    slope.push_back(depth.back() > 0 ? stiffening * press.force / depth.back() : 0);
  }
  const auto [least, most] = std::minmax_element(depth.begin(), depth.end());
  if (*most < alike * *least)
    return {
        format("the presses are all about as deep (%.3g to %.3g mm), which can't show that forces or depths count "
               "from another place than air and touch: what was found would be off by as much. Press half as deep, "
               "too, at some places",
               1e3 * *least, 1e3 * *most)};
  if (found.misfit < told_misfit * *std::max_element(forces.begin(), forces.end())) return {};
  std::vector<std::string> notes;
  Identified by_force = found, by_depth = found;
  const double force = widenForOffset(std::vector<double>(presses.size(), 1), sought, by_force),
               shift = widenForOffset(slope, sought, by_depth);
  if (force != 0)
    notes.push_back(
        format("forces that are all %.2g N too %s would explain what is left over: is 0 that of the tool in "
               "air? The intervals reach to what fits then",
               std::abs(force), force > 0 ? "small" : "large"));
  if (shift != 0)
    notes.push_back(
        format("tips that are all %.2g mm too %s would explain what is left over. The intervals reach to "
               "what fits then",
               1e3 * std::abs(shift), shift > 0 ? "deep" : "high"));
  for (std::size_t k = 0; k < found.value.size(); ++k) {
    found.low[k] = std::min(by_force.low[k], by_depth.low[k]);
    found.high[k] = std::max(by_force.high[k], by_depth.high[k]);
  }
  return notes;
}

}  // namespace

int identifyRegions(const IdentifyOptions& options) {
  constexpr int found_it = 0, not_found = 1, doubted = 3, most_set_ups = 4;
  constexpr double most_noise = 0.1;  // of the largest force: no scale for forces is as bad
  const std::string file = findScene(options.scene);
  Scene scene = readScene(file);
  SoughtOfAll sought = soughtOfAll(options, scene);
  const std::vector<SettledPress> presses = readPresses(options.measured);
  if (presses.size() <= sought.numbers.size())
    throw InputError({options.measured},
                     "there are " + std::to_string(presses.size()) + " presses for " +
                         std::to_string(sought.numbers.size()) + " materials",
                     "give more presses than materials; twice as many tell how certain the answer is");
  const auto largest =
      std::max_element(presses.begin(), presses.end(), [](const auto& a, const auto& b) { return a.force < b.force; });
  if (!(largest->force > 0))
    throw InputError({options.measured}, "no press has a force above 0",
                     "give forces on the tool, along its axis and out of the tissue");
  const auto hardest = static_cast<std::size_t>(largest - presses.begin());
  const std::string folder =
      options.out.empty() ? "out/" + std::filesystem::path(file).stem().string() + "_identify" : options.out;
  makeFolder(folder, "choose another place with --out");

  auto model = std::make_unique<Model>(loadModel(scene));
  const int threads = threadsOr(options.threads);
  PressedRegions regions(*model, presses, sought.numbers, threads);
  ProgressLine progress("identify");
  int maps = 0;
  std::vector<double> last;
  const auto residuals = [&](const std::vector<double>& values) {
    ++maps;
    progress.show(maps / (maps + 3.0), "map " + std::to_string(maps));
    std::vector<double> r = regions.forces(values);
    if (maps == 1) {  // as the scene stands
      if (!(*std::max_element(r.begin(), r.end()) > 0))
        throw InputError(
            {options.measured}, "no press touches the scene's body",
            "give the tip where the tool had come to rest, in the scene's coordinates; x_mm for millimetres");
      for (std::size_t k = 0; k < r.size(); ++k)
        if (!(r[k] > 0) && presses[k].force > least_force * largest->force &&
            !(depthOf(*model, presses[k]) > -far_above * model->scene.tools[0].shape.radius))
          throw InputError({options.measured, presses[k].line},
                           format("a press with a force of %.3g N touches nothing", presses[k].force),
                           "is its place right? Leave it out if not");
      MeasuredCurve strongest;
      strongest.force = {largest->force};
      checkUnits(strongest, options.measured, r[hardest]);
    }
    for (std::size_t k = 0; k < r.size(); ++k) r[k] -= presses[k].force;
    last = values;
    return r;
  };
  const auto derivatives = [&](const std::vector<double>& values) {
    if (values != last) residuals(values);
    progress.show(maps / (maps + 2.5), "its derivatives");
    return regions.derivatives();
  };
  Identified found = identify(sought.parameters, residuals, derivatives);
  for (int again = 0; again < most_set_ups && found.converged && putIn(found, sought, scene); ++again) {
    auto next = std::make_unique<Model>(loadModel(scene));
    regions.setUpAnew(*next);
    model = std::move(next);
    last.clear();
    found = identify(sought.parameters, residuals, derivatives);
  }

  std::vector<std::string> doubts;
  if (found.misfit > most_noise * largest->force)
    doubts.push_back(
        format("the scene can't follow these presses: %.3g %% of the largest force are left over; are "
               "tool, support and places those of the experiment?",
               100 * found.misfit / largest->force));
  const Identified by_noise = found;
  std::vector<double> forces;
  for (const SettledPress& press : presses) forces.push_back(press.force);
  const std::vector<std::string> notes = offsetNotes(*model, presses, forces, sought.parameters, found);
  const double too_large = regions.expectedError(hardest);
  widenForError(too_large, forces, sought.parameters, found);
  if (too_large > TrustLimits::expected_error)
    doubts.push_back(
        format("the scene's cloud makes its force some %.0f %% too large, and what was found that much too "
               "soft: ",
               100 * too_large) +
        doubtText(Doubt::Resolution));
  nlohmann::ordered_json report{{"program", buildInfo()},
                                {"scene", scene.name},
                                {"parameter", sought.numbers.front().name},
                                {"converged", found.converged},
                                {"told_apart", found.told_apart},
                                {"misfit_N", found.misfit},
                                {"misfit_of_largest_force", found.misfit / largest->force},
                                {"doubts", doubts},
                                {"notes", notes},
                                {"presses", presses.size()},
                                {"expected_force_error", too_large},
                                {"maps_solved", maps},
                                {"linear_solutions", regions.solutionCount()}};
  for (std::size_t k = 0; k < sought.parameters.size(); ++k) {
    const std::string& name = sought.parameters[k].name;
    report["regions"][name] = intervalOf(found, by_noise, k);
    std::cout << format("%-12s %.6g   (95 %%: %.6g .. %.6g)\n", name.c_str(), found.value[k], found.low[k],
                        found.high[k]);
  }
  std::cout << format("misfit       %.3g %% of the largest force, %.4g N\n", 100 * found.misfit / largest->force,
                      largest->force);
  std::cout << format("cloud        puts the scene's force off by some %.2g %%, which the intervals allow for\n",
                      100 * too_large);
  if (!found.converged) std::cout << "no convergence: begin from nearer values\n";
  if (!found.told_apart)
    std::cout << "note         the presses do not tell all regions apart: press over each, or join some\n";
  for (const std::string& doubt : doubts) std::cout << "DOUBTED      " << doubt << "\n";
  for (const std::string& note : notes) std::cout << "note         " << note << "\n";
  writeWholeFile(folder + "/identify.json", report.dump(2) + "\n");
  std::cout << "picture      "
            << writePicture(folder + "/identify.png", figureOfRegions(scene.name, sought.numbers.front().name, found))
            << std::endl;
  if (!found.converged) return not_found;
  if (!doubts.empty()) return doubted;
  return found.told_apart ? found_it : not_found;
}

}  // namespace palpate::tools
