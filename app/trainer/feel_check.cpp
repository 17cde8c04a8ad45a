#include "app/trainer/feel_check.h"

#include <filesystem>
#include <fstream>
#include <vector>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/key.h"
#include "base/number_text.h"
#include "io/output_file.h"
#include "model/model_hash.h"

namespace palpate::app {

namespace {

constexpr double depth_per_radius = 0.8;

/// The ratios that were kept for this model, or none.
std::vector<double> keptRatios(const std::string& file, std::size_t count) {
  std::ifstream lines(file);
  std::vector<double> ratios;
  for (double ratio = 0; lines >> ratio;) ratios.push_back(ratio);
  if (ratios.size() != count) ratios.clear();
  return ratios;
}

void keepRatios(const std::string& file, const std::vector<double>& ratios) {
  std::string text;
  for (const double ratio : ratios) text += shortest(ratio) + "\n";
  try {
    std::filesystem::create_directories(std::filesystem::path(file).parent_path());
    writeWholeFile(file, text);
  } catch (const std::exception&) {  // the next start takes a second more
  }
}

SourceLocation placeOf(const Scene& scene, const Lump& lump) {
  for (const MaterialSpec& spec : scene.materials)
    if (!spec.everywhere && spec.region.point == lump.centre) return spec.place;
  return scene.place;
}

}  // namespace

double workingDepth(const Scene& scene) { return depth_per_radius * scene.tools[0].shape.radius; }

std::optional<Unfelt> outsideLump(const Model& model) {
  const std::vector<Lump> lumps = lumpsOf(model);
  for (std::size_t k = 0; k < lumps.size(); ++k)
    if (!lumps[k].isInside())
      return Unfelt{placeOf(model.scene, lumps[k]),
                    format("lump %d %s", static_cast<int>(k) + 1, misplaced(lumps[k]).c_str()),
                    "move it below the skin"};
  return {};
}

std::optional<Unfelt> unfeltLump(const TaskBody& body, const std::string& cache_folder,
                                 const std::function<void(double)>& progress) {
  const Model& model = *body.model;
  const std::vector<Lump> lumps = lumpsOf(model);
  if (auto outside = outsideLump(model)) return outside;
  const std::string file = cache_folder.empty()
                               ? std::string()
                               : cache_folder + "/" + hex16(modelHash(model)) + hex16(fnv1a(buildInfo())) + ".felt";
  std::vector<double> ratios = file.empty() ? std::vector<double>() : keptRatios(file, lumps.size());
  if (ratios.empty() && !lumps.empty()) {
    for (const LumpFeel& feel : feelLumps(body, workingDepth(model.scene), progress)) ratios.push_back(feel.ratio());
    if (!file.empty()) keepRatios(file, ratios);
  }
  for (std::size_t k = 0; k < ratios.size(); ++k) {
    if (ratios[k] >= least_feel) continue;
    const Lump& lump = lumps[k];
    return Unfelt{
        placeOf(model.scene, lump),
        format("lump %d (%.0f mm across, %.1f mm below the skin, %.1f times as stiff) can't be felt: pressed %.1f mm "
               "deep the tissue is %.2f times as stiff above it as beside it, and %.2f is needed",
               static_cast<int>(k) + 1, 2e3 * lump.radius, 1e3 * lump.top, lump.stiffness,
               1e3 * workingDepth(model.scene), ratios[k], least_feel),
        "make it larger, stiffer or less deep; of lumps at random try another seed or a lower level"};
  }
  return {};
}

void requireFelt(const TaskBody& body, const std::string& cache_folder, const std::function<void(double)>& progress) {
  if (const std::optional<Unfelt> unfelt = unfeltLump(body, cache_folder, progress))
    throw InputError(unfelt->place, unfelt->problem, unfelt->advice);
}

}  // namespace palpate::app
