#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "approximation/shape_functions.h"
#include "imaging/fuzzy_c_means.h"
#include "imaging/phantom.h"
#include "imaging/warp.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "mtled/scan/case_scene.h"
#include "mtled/scan/import_scan.h"
#include "mtled/scan/phantom_command.h"
#include "mtled/scan/slices.h"
#include "mtled/verify/cases/cases.h"
#include "mtled/verify/multilevel_spline.h"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

/// A folder for the files between the steps.
class Scratch {
 public:
  Scratch() : path_(fs::temp_directory_path() / ("mtled-brain-shift-" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

/// Mean over voxels and classes of how far memberships are from the phantom's tissue.
double membershipError(const FuzzyClasses& found, const Phantom& phantom) {
  double sum = 0;
  for (std::size_t v = 0; v < phantom.mask.value.size(); ++v)
    for (std::size_t c = 0; c < 3 && phantom.mask.value[v]; ++c)
      sum += std::abs(found.membership[c].value[v] - phantom.fraction[c].value[v]);
  return sum / (3 * static_cast<double>(countOf(phantom.mask)));
}

void judgeMemberships(const CaseContext& context, CaseResult& result) {
  ResultTable table{"Memberships of three tissues, 40 % bias", {"noise", "mean absolute error", "iterations"}, {}, ""};
  double worst = 0;
  std::vector<double> noises{0.03, 0.09};
  if (!context.quick) noises = {0.03, 0.05, 0.07, 0.09};
  for (const double noise : noises) {
    PhantomOptions options;
    options.voxels = context.quick ? 128 : 160;
    options.noise = noise;
    const Phantom phantom = makePhantom(options);
    const FuzzyClasses found = fuzzyCMeans(phantom.scan, phantom.mask);
    const double error = membershipError(found, phantom);
    worst = std::max(worst, error);
    table.rows.push_back({formattedPercent(noise), formatted(error), std::to_string(found.iterations)});
  }
  result.tables.push_back(table);
  result.bounds.push_back({"Memberships, mean absolute error at the worst noise", worst, 0.05, true, "", ""});
}

/// The phantom as files, imported. @return  its scene
Scene importedScene(const Phantom& phantom, const Scratch& scratch, int nodes) {
  writeForImport(phantom, scratch.file(""));
  ImportScanOptions import;
  import.scan = scratch.file("scan.nii.gz");
  import.mask = scratch.file("mask.nii.gz");
  import.electrodes = scratch.file("electrodes.csv");
  import.frame = "ras";
  import.nodes = nodes;
  import.out = scratch.file("case");
  import.open = false;
  if (importScan(import) != 0) throw std::runtime_error("interrupted");
  Scene scene = readScene(scratch.file("case/scene.toml"));
  scene.name = "brain shift";
  return scene;
}

/// Points inside the organ, on a lattice.
std::vector<Vec3> probesIn(const SurfaceTree& organ) {
  constexpr double step = 12 * mm, from_surface = 4 * mm;
  const Box3 box = boundingBox(organ.surface());
  std::vector<Vec3> probes;
  for (double z = box.min().z(); z < box.max().z(); z += step)
    for (double y = box.min().y(); y < box.max().y(); y += step)
      for (double x = box.min().x(); x < box.max().x(); x += step)
        if (organ.signedDistance({x, y, z}) < -from_surface) probes.emplace_back(x, y, z);
  return probes;
}

double quantile(std::vector<double> values, double share) {
  auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Largest distance between where an electrode's point of the surface is and where it was sent, m.
double electrodeMiss(const StaticSolution& s) {
  std::vector<Vec3> X, u;
  for (const BoundarySpec& b : s.model->scene.boundaries)
    if (b.region.kind == Region::Kind::Point) {
      X.push_back(b.region.point);
      u.push_back(b.translation);
    }
  const std::vector<Vec3> found = s.at(X);
  double worst = X.empty() ? NAN : 0;
  for (std::size_t k = 0; k < X.size(); ++k) worst = std::max(worst, (found[k] - u[k]).norm());
  return worst;
}

/// The transform that image programs make of the nodes' displacements, beside the field itself.
void compareWithSpline(const Model& model, const StaticSolution& s, const BackwardField& field, CaseResult& result) {
  using Seconds = std::chrono::duration<double>;
  const std::vector<Vec3> u = s.at(model.X);
  std::vector<Vec3> x, back;
  Box3 box;
  for (std::size_t i = 0; i < u.size(); ++i) {
    x.push_back(model.X[i] + u[i]);
    back.push_back(-u[i]);
    box.extend(x.back());
  }
  const Vec3 margin = Vec3::Constant(model.scene.discretization.spacing);
  const Box3 around(box.min() - margin, box.max() + margin);
  ResultTable table{"The inverse as a multilevel B-spline of the nodes (Lee, Wolberg and Shin 1997)",
                    {"finest lattice", "levels", "mean", "99 % within", "largest", "time"},
                    {},
                    "Distance from the sampled inverse of the whole field at every 97th voxel of the brain; its own is "
                    "below."};
  const ImageGrid& grid = field.body.grid;
  for (const double edges : {2.0, 1.0, 0.5, 0.25}) {
    const auto start = std::chrono::steady_clock::now();
    const MultilevelSpline spline(x, back, around, edges * model.scene.discretization.spacing);
    std::vector<double> off;
    double sum = 0;
    std::size_t inside = 0;
    for (int k = 0; k < grid.size[2]; ++k)
      for (int j = 0; j < grid.size[1]; ++j)
        for (int i = 0; i < grid.size[0]; ++i) {
          const std::size_t v = grid.at(i, j, k);
          if (!field.body.value[v] || inside++ % 97 != 0) continue;
          off.push_back((spline.at(grid.worldOf(i, j, k)) - field.to_rest.value[v].cast<double>()).norm());
          sum += off.back();
        }
    if (off.empty()) return;
    const Seconds seconds = std::chrono::steady_clock::now() - start;
    table.rows.push_back({formatted(edges * model.scene.discretization.spacing, "m"),
                          std::to_string(spline.levelCount()), formatted(sum / static_cast<double>(off.size()), "m"),
                          formatted(quantile(off, 0.99), "m"),
                          formatted(*std::max_element(off.begin(), off.end()), "m"), formatted(seconds.count(), "s")});
  }
  result.tables.push_back(table);
}

/// Warps the scan by the finest solution, checks the field and draws.
void judgeWarp(const CaseContext& context, const Phantom& phantom, const StaticSolution& s, CaseResult& result) {
  const Model& model = *s.model;
  const MmlsDeformation whole(model.X, model.support_radius, s.uAsVectors(),
                              {model.scene.discretization.basis_degree, model.scene.discretization.mmls_weight},
                              organSurface(model.scene));
  const SampledDeformation sampled(whole, model.scene.discretization.spacing / 3);
  const InverseDeformation inverse(sampled);
  const BackwardField field = backwardField(sampled, inverse, phantom.scan.grid);
  const WarpCheck check = checkField(field, whole, inverse, context.quick ? 2000 : 10000);
  result.bounds.push_back({"Sampled inverse beside Newton's method on the whole field, mean", check.mean, 0.02e-3, true,
                           "m", std::to_string(check.count) + " voxels by lot"});
  result.bounds.push_back({"The same, largest", check.max, 0.1e-3, true, "m", ""});
  compareWithSpline(model, s, field, result);
  if (!context.pictures) return;
  const Image after = warped(phantom.scan, field, Between::Cubic, 0);
  Image difference = after;
  for (std::size_t v = 0; v < after.value.size(); ++v)
    difference.value[v] = std::abs(after.value[v] - phantom.scan.value[v]);
  const auto [low, high] = windowOf(phantom.scan, phantom.mask);
  const Box3 box = boxOf(phantom.mask, 0.012);
  const Vec3 place = 0.5 * (phantom.after[phantom.after.size() / 2] + box.center());
  const FuzzyClasses tissue = fuzzyCMeans(phantom.scan, phantom.mask);
  context.pictures->write(context.folder + "/brain_shift_slices.png",
                          drawSlices({{&phantom.scan, &phantom.mask, nullptr},
                                      {&after, &field.body, nullptr},
                                      {&difference, &field.body, nullptr}},
                                     box, place, low, high));
  result.figures.push_back({"brain_shift_slices.png",
                            "Before, after and their difference; the brain's border in orange. Vacated space is black: "
                            "there is no old brain in it."});
  context.pictures->write(context.folder + "/brain_shift_tissue.png",
                          drawSlices({{&tissue.membership[0], nullptr, nullptr},
                                      {&tissue.membership[1], nullptr, nullptr},
                                      {&tissue.membership[2], nullptr, nullptr}},
                                     box, place, 0, 1));
  result.figures.push_back({"brain_shift_tissue.png", "Memberships of fluid, grey and white matter: black 0, white 1"});
  BodyPicture picture;
  picture.title = "Displacement under the electrode grid";
  picture.azimuth_deg = 20;
  picture.elevation_deg = 35;
  addBodyPicture(context, "brain_shift_body.png", "The deformed brain, where the grid pushes it in", picture, s,
                 result);
}

}  // namespace

CaseResult brainShiftCase(const CaseContext& context) {
  CaseResult result;
  result.name = "brain_shift";
  result.title = "Brain shift: from a scan to the shifted scan (paper section 5)";
  result.reference =
      "A phantom by formula (engine/imaging/phantom.cpp), whose tissue is known; the finest of three clouds; Newton's "
      "method on the whole field.";
  result.text =
      "A brain with folds, ventricles and fluid, T1, Rician noise and 40 % bias, is classified by fuzzy c-means, "
      "imported "
      "and pressed by an electrode grid; the scan is warped by the solution. This is verification, not validation: no "
      "patient's data is here.";
  context.progress(0, "memberships");
  judgeMemberships(context, result);

  PhantomOptions options;
  options.voxels = context.quick ? 64 : 128;
  options.rows = 4;
  options.columns = 5;
  const Phantom phantom = makePhantom(options);
  const Scratch scratch;
  const std::vector<int> counts = context.quick ? std::vector<int>{300, 700} : std::vector<int>{700, 2000, 5000};
  Scene scene = importedScene(phantom, scratch, counts.back());
  const SurfaceTree organ(organSurface(scene));
  const std::vector<Vec3> probes = probesIn(organ);
  const double volume = signedVolume(organ.surface());
  std::vector<std::vector<Vec3>> u;
  std::vector<StaticSolution> solutions;
  double miss = 0;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    scene.discretization.spacing = spacingFor(volume, counts[k]);
    const double all = static_cast<double>(counts.size()) + 1;
    solutions.push_back(solveCase(scene, evenTimes(4), partOf(context, static_cast<double>(k) + 0.5, all), 1e-3));
    if (!solutions.back().steps.back().converged) {
      result.bounds.push_back({"Equilibrium with " + std::to_string(counts[k]) + " nodes", 0, 1, false, "", ""});
      return result;
    }
    u.push_back(solutions.back().at(probes));
    miss = std::max(miss, electrodeMiss(solutions.back()));
  }
  ResultTable table{"Three clouds of one brain",
                    {"nodes", "points", "spacing", "95 % of the points within", "largest displacement inside", "time"},
                    {},
                    std::to_string(probes.size()) + " points, beside the finest."};
  double coarsest = 0;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    std::vector<double> off;
    double largest = 0;
    for (std::size_t p = 0; p < probes.size(); ++p) {
      off.push_back((u[k][p] - u.back()[p]).norm());
      largest = std::max(largest, u[k][p].norm());
    }
    const bool finest = k + 1 == counts.size();
    if (!finest) coarsest = std::max(coarsest, quantile(off, 0.95));
    table.rows.push_back({std::to_string(solutions[k].model->nodeCount()),
                          std::to_string(solutions[k].model->pointCount()),
                          formatted(solutions[k].model->scene.discretization.spacing, "m"),
                          finest ? "" : formatted(quantile(off, 0.95), "m"), formatted(largest, "m"),
                          formatted(solutions[k].seconds, "s")});
  }
  result.tables.push_back(table);
  result.bounds.push_back(
      {"95 % of the points, from the finest cloud", coarsest, 0.8e-3, true, "m", "less than a voxel of a scan"});
  result.bounds.push_back(
      {"Electrodes, distance from where they were measured", miss, 1e-9, true, "m", "imposed exactly"});
  context.progress(0.9, "warp");
  judgeWarp(context, phantom, solutions.back(), result);
  return result;
}

}  // namespace palpate::tools
