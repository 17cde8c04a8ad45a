#include "mtled/scan/warp_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <future>
#include <iostream>
#include <nlohmann/json.hpp>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "base/parallel_for.h"
#include "imaging/nifti.h"
#include "imaging/warp.h"
#include "io/image_file.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/scene_file.h"
#include "io/text_file.h"
#include "mtled/report/pictures.h"
#include "mtled/run/progress.h"
#include "mtled/scan/interruption.h"
#include "mtled/scan/slices.h"
#include "mtled/solve/solve_command.h"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using Seconds = std::chrono::duration<double>;

constexpr double samples_per_spacing = 3;
constexpr int checked_voxels = 10'000;

/// Part of the work, shown on the progress line.
std::function<void(double)> partOf(ProgressLine& line, double begin, double width, const char* what) {
  return [&line, begin, width, what](double share) {
    if (interrupted()) throw Interrupted{};
    line.show(begin + width * share, what);
  };
}

/// The solved body as a field.
std::unique_ptr<MmlsDeformation> deformationOf(const std::string& folder, double& spacing, int& nodes) {
  const Scene scene = readScene((fs::path(folder) / "scene.toml").string());
  const Model model = loadModel(scene, {}, ModelCache(ModelCache::userFolder(), warn), warn);
  std::vector<Vec3> u;
  for (const Double4& a : solutionOf(model, (fs::path(folder) / "solution").string())) u.push_back(toVec3(a));
  spacing = scene.discretization.spacing;
  nodes = model.nodeCount();
  return std::make_unique<MmlsDeformation>(
      model.X, model.support_radius, std::move(u),
      MmlsOptions{scene.discretization.basis_degree, scene.discretization.mmls_weight}, organSurface(scene));
}

/// What the solution is worth, as `mtled solve` left it beside it: "good", its doubt, or "unknown" where it left none.
std::string trustOf(const std::string& folder) {
  try {
    const auto report = nlohmann::json::parse(readWholeFile((fs::path(folder) / "solution" / "report.json").string()));
    return report.value("converged", true) ? report.at("trust").get<std::string>() : "not converged";
  } catch (const std::exception&) {
    return "unknown";
  }
}

/// Writes files, each while the next one's bytes are made.
class Writer {
 public:
  void write(const std::string& path, std::string bytes) {
    finish();
    last_ = std::async(std::launch::async, [path, kept = std::move(bytes)] { writeWholeFile(path, kept); });
  }
  void finish() {
    if (last_.valid()) last_.get();
  }

 private:
  std::future<void> last_;
};

/// A mask as an image of 0 and 1.
Image imageOf(const Mask& mask) {
  Image image;
  image.grid = mask.grid;
  image.value.assign(mask.value.begin(), mask.value.end());
  return image;
}

/// |after - before|, to look at.
Image differenceOf(const Image& before, const Image& after) {
  Image difference(after.grid);
  const bool same = sameGrid(before.grid, after.grid);
  parallelFor(
      after.grid.size[2],
      [&](int first, int last) {
        for (int k = first; k < last; ++k)
          for (int j = 0; j < after.grid.size[1]; ++j)
            for (int i = 0; i < after.grid.size[0]; ++i) {
              const std::size_t v = after.grid.at(i, j, k);
              const float was =
                  same ? before.value[v] : linearValue(before, before.grid.indexOf(after.grid.worldOf(i, j, k)));
              difference.value[v] = std::abs(after.value[v] - was);
            }
      },
      1);
  return difference;
}

void drawShift(const std::string& png, const Image& before, const Image& after, const BackwardField& field) {
  const std::unique_ptr<Pictures> pictures = openPictures();
  if (!pictures || countOf(field.body) == 0) return;
  const auto [low, high] = windowOf(after, field.body);
  const Image difference = differenceOf(before, after);
  Mask touched = field.body;
  for (std::size_t v = 0; v < touched.value.size(); ++v) touched.value[v] |= field.vacated.value[v];
  // Through the place that moved most.
  std::size_t most = 0;
  for (std::size_t v = 0; v < field.to_rest.value.size(); ++v)
    if (field.to_rest.value[v].squaredNorm() > field.to_rest.value[most].squaredNorm()) most = v;
  const ImageGrid& grid = after.grid;
  const auto row = static_cast<std::size_t>(grid.size[0]), plane = row * static_cast<std::size_t>(grid.size[1]);
  const Vec3 place =
      grid.worldOf(static_cast<int>(most % row), static_cast<int>(most % plane / row), static_cast<int>(most / plane));
  pictures->write(
      png,
      drawSlices({{&before, nullptr, nullptr}, {&after, &field.body, nullptr}, {&difference, &field.body, nullptr}},
                 boxOf(touched, 0.012), place, low, high));
}

/// Throws InputError where values are none that keep their numbers.
void checkLabels(const std::string& file, const Image& image) {
  for (const float value : image.value)
    if (value != std::round(value) || std::abs(value) > largest_label)
      throw InputError({file, 0, 0}, format("%.9g is no label", value),
                       "labels are whole numbers up to 16,777,216: leave --labels out, or number them anew");
}

}  // namespace

int warpCommand(const WarpOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  if (options.image.empty() && options.like.empty())
    throw InputError({}, "neither --image nor --like", "give the image that is to be warped");
  const fs::path out = options.out.empty() ? fs::path(options.folder) : fs::path(options.out);
  makeFolder(out.string());
  const auto file = [&](const char* name) { return (out / name).string(); };
  for (const char* name : {"field.nii.gz", "forward.nii.gz", "jacobian.nii.gz", "valid.nii.gz", "warped.nii.gz"})
    for (const std::string& read : {options.image, options.like})
      if (isSameFile(file(name), read))
        throw InputError({read}, "this file is read, and would be written over", "choose another --out");
  const NiftiOptions reading{options.assume_ras, warn};
  try {
    ProgressLine progress("warp");
    progress.show(0, "reading");
    // Expanding an image is work for one core, and so is much of opening the scene.
    auto reader = std::async(std::launch::async,
                             [&] { return options.image.empty() ? Image() : readImage(options.image, reading); });
    double spacing = 0;
    int nodes = 0;
    const auto whole = deformationOf(options.folder, spacing, nodes);
    Image image = reader.get();
    if (options.labels) checkLabels(options.image, image);
    const ImageGrid grid = options.like.empty() ? image.grid : readImage(options.like, reading).grid;
    if (options.image.empty()) image.grid = grid;
    const auto loaded = std::chrono::steady_clock::now();
    partOf(progress, 0.1, 0, "sampling the field")(0);
    const SampledDeformation sampled(*whole, spacing / samples_per_spacing);
    const auto sampled_at = std::chrono::steady_clock::now();
    const InverseDeformation inverse(sampled);
    const BackwardField field = backwardField(sampled, inverse, grid, partOf(progress, 0.3, 0.3, "inverting it"));
    const auto inverted = std::chrono::steady_clock::now();
    if (countOf(field.body) == 0)
      throw InputError({(options.like.empty() ? options.image : options.like), 0, 0},
                       "no voxel is in the body of " + options.folder,
                       "give an image of it (that may be in another unit or frame)");
    partOf(progress, 0.6, 0, "checking it")(0);
    const WarpCheck check = checkField(field, *whole, inverse, checked_voxels);
    const auto checked = std::chrono::steady_clock::now();
    partOf(progress, 0.65, 0, "writing")(0);
    Image result;
    std::future<void> drawn;
    if (!options.image.empty()) {
      result = warped(image, field, options.labels ? Between::Nearest : Between::Cubic, options.fill);
      if (!options.labels)
        drawn = std::async(std::launch::async, [&] { drawShift(file("shift.png"), image, result, field); });
    }
    Writer writer;
    writer.write(file("field.nii.gz"), niftiFrom(field.to_rest, true));
    partOf(progress, 0.75, 0, "writing")(0);
    writer.write(file("forward.nii.gz"), niftiFrom(forwardField(sampled, image.grid), true));
    partOf(progress, 0.85, 0, "writing")(0);
    writer.write(file("jacobian.nii.gz"), niftiFrom(field.jacobian, NiftiType::Float32, true));
    writer.write(file("valid.nii.gz"), niftiFrom(imageOf(validOf(image.grid, field)), NiftiType::UInt8, true));
    if (!options.image.empty()) {
      partOf(progress, 0.9, 0, "the image")(0);
      const bool small = options.labels && std::all_of(result.value.begin(), result.value.end(),
                                                       [](float a) { return std::abs(a) <= 32767; });
      writer.write(file("warped.nii.gz"), niftiFrom(result, small ? NiftiType::Int16 : NiftiType::Float32, true));
    }
    writer.finish();
    if (drawn.valid()) drawn.get();
    const auto end = std::chrono::steady_clock::now();
    double largest = 0;
    for (const Vec3f& d : field.to_rest.value) largest = std::max(largest, static_cast<double>(d.norm()));
    const std::string trust = trustOf(options.folder);
    const nlohmann::json report = {{"image", options.image},
                                   {"voxels", grid.voxelCount()},
                                   {"nodes", nodes},
                                   {"trust", trust},
                                   {"voxels_of_the_body", countOf(field.body)},
                                   {"voxels_left_empty", countOf(field.vacated)},
                                   {"largest_displacement_mm", largest / mm},
                                   {"checked_voxels", check.count},
                                   {"sampling_error_mean_mm", check.mean / mm},
                                   {"sampling_error_max_mm", check.max / mm},
                                   {"forward_after_inverse_max_mm", check.round_trip / mm},
                                   {"load_seconds", Seconds(loaded - start).count()},
                                   {"sample_seconds", Seconds(sampled_at - loaded).count()},
                                   {"invert_seconds", Seconds(inverted - sampled_at).count()},
                                   {"check_seconds", Seconds(checked - inverted).count()},
                                   {"write_seconds", Seconds(end - checked).count()},
                                   {"warp_seconds", Seconds(end - loaded).count()},
                                   {"build", buildInfo()}};
    writeWholeFile(file("warp.json"), report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    std::cout << format(
                     "warp: %.1f mm at most; of %d voxels the sampled field is %.4f mm off on average, %.4f mm at "
                     "most; %.1f s\n",
                     largest / mm, check.count, check.mean / mm, check.max / mm, Seconds(end - start).count())
              << "fields   " << file("field.nii.gz") << ", " << file("forward.nii.gz") << "\n";
    if (!options.image.empty()) std::cout << "image    " << file("warped.nii.gz") << "\n";
    std::cout.flush();
    if (trust != "good") warn("the solution behind it is doubted (" + trust + "), and so is where the image went");
    return 0;
  } catch (const Interrupted&) {
    std::cerr << "mtled: interrupted; what was written stays in " << out.string() << "\n";
    return 1;
  }
}

}  // namespace palpate::tools
