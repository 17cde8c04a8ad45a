#include "mtled/scan/import_scan.h"

#include <cctype>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "imaging/fuzzy_c_means.h"
#include "imaging/mask_filter.h"
#include "io/image_file.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/point_file.h"
#include "io/scene_file.h"
#include "io/surface_file.h"
#include "io/text_file.h"
#include "mtled/pictures/pictures.h"
#include "mtled/run/progress.h"
#include "mtled/scan/case_scene.h"
#include "mtled/scan/interruption.h"
#include "mtled/scan/mask_surface.h"
#include "mtled/scan/slices.h"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

/// A case on its way.
struct Import {
  const ImportScanOptions& options;
  fs::path folder;
  ProgressLine progress{"import"};
  nlohmann::json report = nlohmann::json::object();
  std::vector<std::string> warnings{};
  Image scan{};
  Mask mask{};
  std::optional<FuzzyClasses> tissue{};
  int fluid = -1;  // class
  double spacing = 0;
  MaskSurface surface{};
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();

  void show(double share, const std::string& what) {
    if (interrupted()) throw Interrupted{};
    progress.show(share, what);
  }
  void note(const std::string& text) {
    warn(text);
    warnings.push_back(text);
  }
  NiftiOptions reading() {
    return {options.assume_ras, [this](const std::string& text) { note(text); }};
  }
  std::string file(const std::string& name) const { return (folder / name).string(); }
};

/// The voxels that are the organ, on the scan's grid.
Mask readMask(Import& import) {
  const ImportScanOptions& o = import.options;
  if (o.mask.empty() == o.labels.empty())
    throw InputError({}, o.mask.empty() ? "neither --mask nor --labels" : "both --mask and --labels",
                     "give the organ's voxels as --mask M.nii.gz, or as --labels L.nii.gz --label 2,3 (skull stripping "
                     "is done by other programs)");
  if (!o.labels.empty() && o.label.empty())
    throw InputError({}, "--labels without --label", "say which labels are the organ, such as --label 2,3,41,42");
  const std::string& file = o.mask.empty() ? o.labels : o.mask;
  const Image image = readImage(file, import.reading());
  const Mask found = maskOf(image, o.label);
  if (sameGrid(found.grid, import.scan.grid)) return found;
  import.note(file + ": its voxels are not those of the scan; each voxel of the scan takes the nearest one's");
  Mask mask(import.scan.grid);
  for (int k = 0; k < mask.grid.size[2]; ++k)
    for (int j = 0; j < mask.grid.size[1]; ++j)
      for (int i = 0; i < mask.grid.size[0]; ++i) {
        const Vec3 index = found.grid.indexOf(mask.grid.worldOf(i, j, k));
        int at[3];
        bool within = true;
        for (int a = 0; a < 3; ++a) {
          at[a] = static_cast<int>(std::lround(index[a]));
          within = within && at[a] >= 0 && at[a] < found.grid.size[static_cast<std::size_t>(a)];
        }
        mask(i, j, k) = within ? found(at[0], at[1], at[2]) : 0;
      }
  return mask;
}

void readImages(Import& import) {
  import.show(0, "reading");
  import.scan = readImage(import.options.scan, import.reading());
  MaskParts parts;
  const Mask given = readMask(import);
  if (countOf(given) == 0)
    throw InputError({import.options.mask.empty() ? import.options.labels : import.options.mask},
                     "no voxel is in the organ",
                     import.options.label.empty() ? "is it a mask of 0 and 1?" : "are the labels right?");
  import.mask = keepLargestPart(given, parts);
  const double voxel_ml = 1e6 * given.grid.voxelVolume();
  if (parts.dropped_voxels > 0)
    import.note(format("the mask has %d parts; the largest is the organ, %.3g ml are left out", parts.part_count,
                       static_cast<double>(parts.dropped_voxels) * voxel_ml));
  if (parts.filled_voxels > 0)
    import.note(
        format("holes of %.3g ml inside the mask are filled", static_cast<double>(parts.filled_voxels) * voxel_ml));
  import.report["mask_voxels"] = countOf(import.mask);
}

void classify(Import& import) {
  const ImportScanOptions& o = import.options;
  writeImage(import.file("mask.nii.gz"), import.mask);
  if (o.classes == 0) return;
  if (o.fluid != "dark" && o.fluid != "bright" && o.fluid != "none")
    throw InputError({}, "--fluid " + inQuotes(o.fluid), "give dark (T1), bright (T2) or none");
  FuzzyOptions fuzzy;
  fuzzy.classes = o.classes;
  import.tissue = fuzzyCMeans(import.scan, import.mask, fuzzy,
                              [&](double share) { import.show(0.1 + 0.2 * share, "tissue classes");
});
import.fluid = o.fluid == "none" ? -1 : o.fluid == "dark" ? 0 : o.classes - 1;
nlohmann::json classes = nlohmann::json::array();
for (int c = 0; c < o.classes; ++c) {
  const std::string name = c == import.fluid ? "csf.nii.gz" : "tissue_" + std::to_string(c + 1) + ".nii.gz";
  import.show(0.3 + 0.1 * c / o.classes, "writing memberships");
  constexpr double share_step = 1.0 / 16384;  // 0 and 1 are exact; half the bytes of real numbers
  writeImage(import.file(name), import.tissue->membership[static_cast<std::size_t>(c)], NiftiType::Int16, share_step);
  classes.push_back({{"file", name}, {"centre", import.tissue->centre[static_cast<std::size_t>(c)]}});
}
import.report["classes"] = classes;
}  // namespace

void makeSurface(Import& import) {
  const ImportScanOptions& o = import.options;
  const double volume = static_cast<double>(countOf(import.mask)) * import.mask.grid.voxelVolume();
  import.spacing = o.spacing_mm > 0 ? o.spacing_mm * mm : spacingFor(volume, o.nodes);
  const double smoothing = o.smoothing_mm > 0
                               ? o.smoothing_mm * mm
                               : std::max(0.35 * import.spacing, 0.7 * std::cbrt(import.mask.grid.voxelVolume()));
  import.show(0.4, "surface");
  import.surface = surfaceOf(import.mask, 0.6 * import.spacing, smoothing);
  writeObj(import.surface.surface, import.file("surface.obj"));
  const MaskSurface& s = import.surface;
  import.report["surface"] = {{"vertices", s.surface.vertices.size()},
                              {"triangles", s.surface.triangles.size()},
                              {"volume_ml", 1e6 * s.volume},
                              {"mask_volume_ml", 1e6 * s.mask_volume},
                              {"volume_error", s.volume / s.mask_volume - 1},
                              {"smoothing_mm", s.smoothing / mm},
                              {"level_mm", s.level / mm},
                              { "distance_to_mask_95_mm",
                                s.distance_95 / mm }};
}

/// Writes the scene, with the electrodes where there are some.
void writeScene(Import& import) {
  const ImportScanOptions& o = import.options;
  CaseScene scene;
  scene.name = fs::path(o.scan).filename().string();
  scene.spacing = import.spacing;
  scene.has_fluid = import.fluid >= 0;
  scene.in_skull = o.skull;
  if (!o.electrodes.empty()) {
    const bool slicer = o.electrodes.ends_with(".fcsv") || o.electrodes.ends_with(".json");
    const auto frame = o.frame.empty()    ? std::optional<Frame>()
                       : o.frame == "ras" ? std::optional(Frame::Ras)
                                          : std::optional(Frame::Lps);
    const double unit = o.unit == "m" ? 1 : o.unit == "cm" ? 0.01 : 0.001;
    if (!slicer && !frame)
      throw InputError({o.electrodes}, "the frame of these points is not known",
                       "give --frame ras (+x to the patient's right, +y to the front) or --frame lps (left, back)");
    const PointLoad points = readPoints(o.electrodes, slicer ? std::optional<double>() : unit, frame);
    scene.electrodes = "electrodes" + fs::path(o.electrodes).extension().string();
    if (o.electrodes.ends_with(".mrk.json")) scene.electrodes = "electrodes.mrk.json";
    if (!slicer) scene.electrode_keys = "unit = \"" + o.unit + "\"\nframe = \"" + o.frame + "\"\n";
    writeWholeFile(import.file(scene.electrodes), readWholeFile(o.electrodes));
    import.report["electrodes"] = points.after.size();
    for (const Vec3& x : points.before.empty() ? points.after : points.before) scene.opened.extend(x);
  }
  writeWholeFile(import.file("scene.toml"), sceneText(scene, import.surface.surface));
}

/// Opens the scene as every program does, which shows that it opens, and keeps its set-up for them.
void openAndDraw(Import& import) {
  const Model model = loadModel(
      readScene(import.file("scene.toml")),
      [&](const std::string& what, double share) { import.show(0.6 + 0.3 * share, what); },
      ModelCache(ModelCache::userFolder(), warn), [&](const std::string& text) { import.note(text); });
  import.report["nodes"] = model.nodeCount();
  import.report["integration_points"] = model.pointCount();
  import.show(0.92, "pictures");
  const auto [low, high] = windowOf(import.scan, import.mask);
  const Box3 box = boxOf(import.mask, 0.012);
  SliceColumn tissue{&import.scan, nullptr, nullptr};
  if (import.fluid >= 0) tissue.tint = &import.tissue->membership[static_cast<std::size_t>(import.fluid)];
  const std::unique_ptr<Pictures> pictures = openPictures();
  if (!pictures) return;
  pictures->write(import.file("preview.png"),
                  drawSlices({{&import.scan, &import.mask, nullptr}, tissue}, box, box.center(), low, high));
  BodyPicture organ;
  organ.title = model.scene.name;
  organ.colour = ColourMap::Tissue;
  pictures->write(import.file("organ.png"), organ, model, AlignedVector<Float4>(model.X.size()), nullptr);
}

}  // namespace palpate::tools

int importScan(const ImportScanOptions& options) {
  std::string name = fs::path(options.scan).filename().string();
  for (const char* ending : {".gz", ".nii"})
    if (name.ends_with(ending)) name.resize(name.size() - std::string(ending).size());
  Import import{options, options.out.empty() ? fs::path("out") / name : fs::path(options.out)};
  std::error_code error;
  fs::create_directories(import.folder, error);
  if (error) throw std::runtime_error(import.folder.string() + ": " + error.message());
  try {
    readImages(import);
    classify(import);
    makeSurface(import);
    writeScene(import);
    if (options.open) openAndDraw(import);
  } catch (const Interrupted&) {
    std::cerr << "mtled: interrupted; what was done is in " << import.folder.string() << "\n";
    return 1;
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - import.start;
  import.report.update({{"scan", options.scan},
                        {"spacing_mm", import.spacing / mm},
                        {"warnings", import.warnings},
                        {"seconds", seconds.count()},
                        { "build",
                          buildInfo() }});
  writeWholeFile(import.file("report.json"),
                 import.report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  if (!options.open) return 0;
  std::cout << format("%s: %.0f ml, %lld nodes, %.3g mm apart; %.1f s\n", name.c_str(), 1e6 * import.surface.volume,
                      asLongLong(import.report["nodes"].get<std::int64_t>()), import.spacing / mm, seconds.count())
            << "scene    " << import.file("scene.toml") << "\npreview  "
            << (withoutPictures().empty() ? import.file("preview.png") : withoutPictures()) << "\nreport   "
            << import.file("report.json") << std::endl;
  return 0;
}

bool isScan(const std::string& file) {
  std::string name = file;
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name.ends_with(".nii") || name.ends_with(".nii.gz");
}

}  // namespace palpate::tools
