#include "mtled/scan/import_scan.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <future>
#include <iostream>
#include <nlohmann/json.hpp>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "base/printable_text.h"
#include "imaging/fuzzy_c_means.h"
#include "imaging/mask_filter.h"
#include "io/image_file.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/point_file.h"
#include "io/scene_file.h"
#include "io/surface_file.h"
#include "io/text_file.h"
#include "mtled/report/pictures.h"
#include "mtled/run/case_folder.h"
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
  CaseFolder folder;
  ProgressLine progress{"import"};
  nlohmann::json report = nlohmann::json::object();
  std::vector<std::string> warnings{};
  Image scan{};
  Mask mask{};
  std::optional<FuzzyClasses> tissue{};
  int fluid = -1;  // class
  double spacing = 0;
  MaskSurface surface{};
  CaseScene scene{};
  PointLoad electrodes{};
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
  std::string file(const std::string& name) const { return folder.aside(name); }
};

/// All that an import may write.
std::vector<std::string> namesOf(const ImportScanOptions& options) {
  std::vector<std::string> names{"mask.nii.gz",         "known.nii.gz", "csf.nii.gz",     "surface.obj",
                                 "preview.png",         "organ.png",    "electrodes.csv", "electrodes.fcsv",
                                 "electrodes.mrk.json", "report.json"};
  for (int c = 1; c <= options.classes; ++c) names.push_back("tissue_" + std::to_string(c) + ".nii.gz");
  names.emplace_back("scene.toml");  // the last: without it the folder does not open
  return names;
}

/// The file that says which voxels are the organ.
const std::string& maskFile(const ImportScanOptions& o) {
  if (o.mask.empty() == o.labels.empty())
    throw InputError({}, o.mask.empty() ? "neither --mask nor --labels" : "both --mask and --labels",
                     "give the organ's voxels as --mask M.nii.gz, or as --labels L.nii.gz --label 2,3 (skull stripping "
                     "is done by other programs)");
  if (!o.labels.empty() && o.label.empty())
    throw InputError({}, "--labels without --label", "say which labels are the organ, such as --label 2,3,41,42");
  return o.mask.empty() ? o.labels : o.mask;
}

/// A mask on the scan's grid.
Mask onScan(Import& import, const Mask& found) {
  if (sameGrid(found.grid, import.scan.grid)) return found;
  import.note(maskFile(import.options) +
              ": its voxels are not those of the scan; each voxel of the scan takes the nearest one's");
  Mask mask(import.scan.grid);
  for (int k = 0; k < mask.grid.size[2]; ++k)
    for (int j = 0; j < mask.grid.size[1]; ++j)
      for (int i = 0; i < mask.grid.size[0]; ++i) {
        const Vec3 index = found.grid.indexOf(mask.grid.worldOf(i, j, k));
        const auto at = [&](int a) { return static_cast<int>(std::lround(index[a])); };
        mask(i, j, k) = found.grid.holds(index) ? found(at(0), at(1), at(2)) : 0;
      }
  std::size_t outside = 0;
  for (int k = 0; k < found.grid.size[2]; ++k)
    for (int j = 0; j < found.grid.size[1]; ++j)
      for (int i = 0; i < found.grid.size[0]; ++i)
        outside += found(i, j, k) != 0 && !mask.grid.holds(mask.grid.indexOf(found.grid.worldOf(i, j, k)));
  if (outside > 0)
    import.note(format("%.3g ml of the mask (%.1f %%) are outside of the scan: left out",
                       1e6 * static_cast<double>(outside) * found.grid.voxelVolume(),
                       100 * static_cast<double>(outside) / static_cast<double>(countOf(found))));
  return mask;
}

/// An organ that goes on where the image ends.
void noteEdges(Import& import) {
  const Mask& mask = import.mask;
  std::size_t count = 0;
  for (int k = 0; k < mask.grid.size[2]; ++k)
    for (int j = 0; j < mask.grid.size[1]; ++j)
      for (int i = 0; i < mask.grid.size[0]; ++i) {
        const std::array<int, 3> at{i, j, k};
        bool edge = false;
        for (std::size_t a = 0; a < 3; ++a) edge = edge || at[a] == 0 || at[a] + 1 == mask.grid.size[a];
        count += edge && mask(i, j, k) != 0;
      }
  if (count > 0)
    import.note(format("the organ reaches the image's edge at %zu voxels: it ends there, as if it were cut", count));
}

/// What a mask's values say that a mask's don't.
void noteValues(Import& import, const Image& mask) {
  if (!import.options.label.empty()) return;
  const std::string& file = maskFile(import.options);
  const bool fractions = std::any_of(mask.value.begin(), mask.value.end(), [](float a) { return a != std::floor(a); });
  float first = 0;  // above a half
  const bool several = std::any_of(mask.value.begin(), mask.value.end(), [&](float a) {
    if (a > 0.5F && first == 0) first = a;
    return a > 0.5F && a != first;
  });
  const double largest = static_cast<double>(*std::max_element(mask.value.begin(), mask.value.end()));
  if (fractions)
    import.note(file + format(": not a mask of 0 and 1: it has values between, up to %.3g; what is above a half is the "
                              "organ",
                              largest));
  else if (several)
    import.note(file + format(": not a mask of 0 and 1, but of several values, up to %.3g; all above a half are the "
                              "organ (--labels with --label picks some)",
                              largest));
}

/// Refuses what is no organ by its size, of which the scan's unit may be the cause.
void checkSize(const Import& import) {
  constexpr double shortest = 1e-3, longest = 3;  // m
  constexpr std::size_t fewest = 64;              // voxels
  const double length = boxOf(import.mask, 0).sizes().maxCoeff() + import.mask.grid.spacing().maxCoeff();
  if (length < shortest || length > longest)
    throw InputError(
        {import.options.scan},
        "the organ would be " + format("%.3g", length / mm) + " mm long, by the voxels' size in the header",
        "is its unit (xyzt_units: m, mm or um) right?");
  if (const std::size_t count = countOf(import.mask); count < fewest)
    throw InputError({maskFile(import.options)}, "the organ has only " + std::to_string(count) + " voxels in one piece",
                     "give a finer mask; is it the right one?");
}

/// Thin tails of a mask, such as the rest of a nerve, would be no body but a strip of skin: they go, with what hangs on
/// them. A mask that is thin in many places is left as it is.
void cutTails(Import& import) {
  constexpr double thin = 0.35, reach = 0.35;  // of the spacing: a tail's radius; how far it may stand out
  constexpr double most = 0.05;                // of the mask
  const Mask cut = withoutTails(import.mask, thin * import.spacing, reach * import.spacing);
  MaskParts parts;
  const Mask kept = keepLargestPart(cut, parts);
  const std::size_t all = countOf(import.mask), left = countOf(kept);
  if (left >= all) return;
  const double share = 1 - static_cast<double>(left) / static_cast<double>(all);
  const std::string what = format("%.3g ml of the mask (%.2g %%)",
                                  1e6 * static_cast<double>(all - left) * kept.grid.voxelVolume(), 100 * share);
  const double width = 2 * thin * import.spacing / mm;
  if (share > most) {
    import.note(what +
                format(" are thinner than %.3g mm, which nodes %.3g mm apart can't follow; a smaller --spacing does",
                       width, import.spacing / mm));
    return;
  }
  import.note(what + format(" are tails thinner than %.3g mm: left out; a smaller --spacing keeps them", width));
  import.mask = kept;
}

void readImages(Import& import) {
  import.show(0, "reading");
  // Expanding an image is work for one core.
  std::vector<std::string> of_mask;  // warnings
  auto reader = std::async(std::launch::async, [&, file = maskFile(import.options)] {
    return readImage(file, {import.options.assume_ras, [&](const std::string& text) { of_mask.push_back(text); }});
  });
  import.scan = readImage(import.options.scan, import.reading());
  const Image of_file = reader.get();
  for (const std::string& text : of_mask) import.note(text);
  noteValues(import, of_file);
  for (const int label : import.options.label) {
    if (label > largest_label)
      throw InputError({maskFile(import.options)}, format("the label %d is too large to be told from the next", label),
                       "number the labels anew, up to 16,777,216");
    if (std::find(of_file.value.begin(), of_file.value.end(), static_cast<float>(label)) == of_file.value.end())
      import.note(format("%s: no voxel has the label %d", maskFile(import.options).c_str(), label));
  }
  const Mask of_organ = maskOf(of_file, import.options.label);
  const Mask given = onScan(import, of_organ);
  MaskParts parts;
  if (countOf(given) == 0 && countOf(of_organ) > 0)
    throw InputError({maskFile(import.options)}, "the organ is outside of the scan",
                     "is one of the two in another unit or frame?");
  if (countOf(given) == 0)
    throw InputError({maskFile(import.options)}, "no voxel is in the organ",
                     import.options.label.empty() ? "is it a mask of 0 and 1?" : "are the labels right?");
  import.mask = keepLargestPart(given, parts);
  const double voxel_ml = 1e6 * given.grid.voxelVolume();
  if (parts.dropped_voxels > 0)
    import.note(format("the mask has %d parts; the largest is the organ, %.3g ml are left out", parts.part_count,
                       static_cast<double>(parts.dropped_voxels) * voxel_ml));
  if (parts.filled_voxels > 0)
    import.note(
        format("holes of %.3g ml inside the mask are filled", static_cast<double>(parts.filled_voxels) * voxel_ml));
  checkSize(import);
  noteEdges(import);
  const double volume = static_cast<double>(countOf(import.mask)) * import.mask.grid.voxelVolume();
  import.spacing =
      import.options.spacing_mm > 0 ? import.options.spacing_mm * mm : spacingFor(volume, import.options.nodes);
  cutTails(import);
  import.report["mask_voxels"] = countOf(import.mask);
}

/// Whether a place is held, or nearer to that than half the spacing; empty: it is not. Before there is a surface the
/// mask's box tells where the organ is lowest.
std::string heldBy(const Import& import, const Box3& box, const Vec3& x) {
  const double near = 0.5 * import.spacing;
  for (const NamedBall& ball : import.scene.fixed)
    if ((x - ball.centre).norm() < ball.radius + near) return ball.text;
  const bool low = import.scene.fixed.empty() && x.z() < box.min().z() + lowest_held * box.sizes().z() + near;
  return low ? "the lowest twentieth, which is held because --fix says nothing else" : "";
}

/// Refuses electrodes where the organ is held, which the set-up would find only after long work.
void checkElectrodes(const Import& import) {
  const PointLoad& load = import.electrodes;
  const Box3 box = boxOf(import.mask, 0);
  std::string held, lines;
  int first = 0;
  for (std::size_t k = 0; k < load.after.size(); ++k) {
    const std::string by = heldBy(import, box, load.before.empty() ? load.after[k] : load.before[k]);
    if (by.empty()) continue;
    const int line = k < load.line.size() ? load.line[k] : 0;
    if (held.empty()) {
      held = by;
      first = line;
    } else {
      lines += (lines.empty() ? " (and so are those of lines " : ", ") + std::to_string(line);
    }
  }
  if (held.empty()) return;
  throw InputError(
      {import.options.electrodes, first},
      format("this electrode is nearer than half the spacing of %.3g mm to what is held: ", import.spacing / mm) +
          held + (lines.empty() ? "" : lines + ")"),
      "say with --fix where else it is held, give a smaller ball, or leave the electrode out");
}

/// The mask without the voxels that are exactly 0: what other programs cut away, and the mask has, is no tissue. Where
/// a scan has negative values 0 is one like others.
Mask knownTissue(Import& import) {
  Mask known = import.mask;
  import.scene.known = "mask.nii.gz";
  for (std::size_t v = 0; v < known.value.size(); ++v) {
    if (known.value[v] && import.scan.value[v] < 0) return import.mask;
    if (import.scan.value[v] == 0) known.value[v] = 0;
  }
  const std::size_t all = countOf(import.mask), left = countOf(known);
  if (left == all) return known;
  if (left == 0)
    throw InputError({import.options.scan}, "all voxels in the mask are 0", "is it the mask of this scan?");
  import.note(
      format("%.2g %% of the mask's voxels are exactly 0, as if cut away: they are of no class, and take the "
             "tissue around them",
             100 * (1 - static_cast<double>(left) / static_cast<double>(all))));
  import.scene.known = "known.nii.gz";
  writeImage(import.file(import.scene.known), known);
  import.report["zero_voxels"] = all - left;
  return known;
}

void classify(Import& import) {
  const ImportScanOptions& o = import.options;
  writeImage(import.file("mask.nii.gz"), import.mask);
  if (o.classes == 0) return;
  const Mask known = knownTissue(import);
  FuzzyOptions fuzzy;
  fuzzy.classes = o.classes;
  const auto show = [&](double share) { import.show(0.1 + 0.3 * share, "tissue classes and surface"); };
  try {
    import.tissue = fuzzyCMeans(import.scan, known, fuzzy, show);
  } catch (const InputError& error) {
    throw InputError({o.scan}, error.what(), "");
  }
  import.fluid = o.fluid == "none" ? -1 : o.fluid == "dark" ? 0 : o.classes - 1;
  nlohmann::json classes = nlohmann::json::array();
  for (int c = 0; c < o.classes; ++c) {
    const std::string name = c == import.fluid ? "csf.nii.gz" : "tissue_" + std::to_string(c + 1) + ".nii.gz";
    import.show(0.4 + 0.1 * c / o.classes, "writing memberships");
    constexpr double share_step = 1.0 / 16384;  // 0 and 1 are exact; half the bytes of real numbers
    writeImage(import.file(name), import.tissue->membership[static_cast<std::size_t>(c)], NiftiType::Int16, share_step);
    nlohmann::json of_class;
    of_class["file"] = name;
    of_class["centre"] = import.tissue->centre[static_cast<std::size_t>(c)];
    classes.push_back(of_class);
  }
  import.report["classes"] = classes;
}

/// Makes import.surface; touches nothing else of it, so that another thread may do the rest.
void makeSurface(Import& import) {
  const ImportScanOptions& o = import.options;
  const double smoothing = o.smoothing_mm > 0
                               ? o.smoothing_mm * mm
                               : std::max(0.35 * import.spacing, 0.7 * std::cbrt(import.mask.grid.voxelVolume()));
  try {
    import.surface = surfaceOf(import.mask, 0.6 * import.spacing, smoothing);
  } catch (const InputError& error) {
    throw InputError({maskFile(o)}, error.what(), "");
  }
  writeObj(import.surface.surface, import.file("surface.obj"));
}

nlohmann::json reportOf(const MaskSurface& s) {
  nlohmann::json report;
  report["vertices"] = s.surface.vertices.size();
  report["triangles"] = s.surface.triangles.size();
  report["volume_ml"] = 1e6 * s.volume;
  report["mask_volume_ml"] = 1e6 * s.mask_volume;
  report["volume_error"] = s.volume / s.mask_volume - 1;
  report["smoothing_mm"] = s.smoothing / mm;
  report["level_mm"] = s.level / mm;
  report["distance_to_mask_95_mm"] = s.distance_95 / mm;
  return report;
}

/// Reads what the command says of the scene, which is quick, before all that takes long.
void readRequests(Import& import) {
  const ImportScanOptions& o = import.options;
  CaseScene& scene = import.scene;
  if (o.fluid != "dark" && o.fluid != "bright" && o.fluid != "none")
    throw InputError({}, "--fluid " + inQuotes(o.fluid), "give dark (T1), bright (T2) or none");
  if (!o.opened.empty() && !o.skull)
    throw InputError({}, "--open without --skull: there is nothing to open", "give --skull, too, or leave --open out");
  scene.name = fs::path(o.scan).filename().string();
  scene.in_skull = o.skull;
  scene.openings = ballsOf("--open", o.opened, o.frame == "lps");
  scene.fixed = ballsOf("--fix", o.fix, o.frame == "lps");
  if (o.skull && o.opened.empty() && o.electrodes.empty())
    import.note("the skull is closed, so that no tool reaches the brain; --open X,Y,Z,R opens it");
  if (o.electrodes.empty()) return;
  const bool slicer = o.electrodes.ends_with(".fcsv") || o.electrodes.ends_with(".json");
  const auto frame = o.frame.empty()    ? std::optional<Frame>()
                     : o.frame == "ras" ? std::optional(Frame::Ras)
                                        : std::optional(Frame::Lps);
  const double unit = o.unit == "m" ? 1 : o.unit == "cm" ? 0.01 : 0.001;
  if (!slicer && !frame)
    throw InputError({o.electrodes}, "the frame of these points is not known",
                     "give --frame ras (+x to the patient's right, +y to the front) or --frame lps (left, back)");
  const PointLoad& points = import.electrodes =
      readPoints(o.electrodes, slicer ? std::optional<double>() : unit, frame);
  scene.electrodes = "electrodes" + fs::path(o.electrodes).extension().string();
  if (o.electrodes.ends_with(".mrk.json")) scene.electrodes = "electrodes.mrk.json";
  if (!slicer) scene.electrode_keys = "unit = \"" + o.unit + "\"\nframe = \"" + o.frame + "\"\n";
  import.report["electrodes"] = points.after.size();
  for (const Vec3& x : points.before.empty() ? points.after : points.before) scene.opened.extend(x);
}

void writeScene(Import& import) {
  CaseScene& scene = import.scene;
  scene.spacing = import.spacing;
  scene.has_fluid = import.fluid >= 0;
  checkBalls(scene.openings, import.surface.surface);
  checkBalls(scene.fixed, import.surface.surface);
  if (!scene.electrodes.empty())
    writeWholeFile(import.file(scene.electrodes), readWholeFile(import.options.electrodes));
  writeWholeFile(import.file("scene.toml"), sceneText(scene, import.surface.surface));
}

/// What is drawn: slices of the scan while the model is made, then the organ.
void draw(const Import& import, std::future<const Model*> ready) {
  const std::unique_ptr<Pictures> pictures = openPictures();
  if (!pictures) return;
  const auto [low, high] = windowOf(import.scan, import.mask);
  const Box3 box = boxOf(import.mask, 0.012);
  SliceColumn tissue{&import.scan, nullptr, nullptr};
  if (import.fluid >= 0) tissue.tint = &import.tissue->membership[static_cast<std::size_t>(import.fluid)];
  pictures->write(import.file("preview.png"),
                  drawSlices({{&import.scan, &import.mask, nullptr}, tissue}, box, box.center(), low, high));
  const Model& model = *ready.get();
  BodyPicture organ;
  organ.title = model.scene.name;
  organ.colour = ColourMap::Tissue;
  pictures->write(import.file("organ.png"), organ, model, AlignedVector<Float4>(model.X.size()), nullptr);
}

/// Opens the scene as every program does, which shows that it opens, and keeps its set-up for them.
void openAndDraw(Import& import) {
  std::optional<Model> model;
  std::future<void> drawn;
  std::promise<const Model*> ready;  // goes first where the scene does not open, which ends the drawing
  drawn = std::async(std::launch::async, draw, std::cref(import), ready.get_future());
  model = loadModel(
      readScene(import.file("scene.toml")),
      [&](const std::string& what, double share) { import.show(0.6 + 0.3 * share, what); },
      ModelCache(ModelCache::userFolder(), warn), [&](const std::string& text) { import.note(text); });
  import.report["nodes"] = model->nodeCount();
  import.report["integration_points"] = model->pointCount();
  import.show(0.92, "pictures");
  ready.set_value(&*model);
  drawn.get();
}

}  // namespace

int importScan(const ImportScanOptions& options) {
  std::string name = fs::path(options.scan).filename().string();
  for (const char* ending : {".gz", ".nii"})
    if (name.ends_with(ending)) name.resize(name.size() - std::string(ending).size());
  Import import{options,
                {options.out.empty() ? fs::path("out") / name : fs::path(options.out),
                 namesOf(options),
                 {options.scan, options.mask, options.labels, options.electrodes}}};
  try {
    readRequests(import);
    readImages(import);
    checkElectrodes(import);
    // Neither needs the other, and each leaves cores idle at times.
    auto surface = std::async(std::launch::async, makeSurface, std::ref(import));
    classify(import);
    import.show(0.5, "surface");
    surface.get();
    import.report["surface"] = reportOf(import.surface);
    writeScene(import);
    if (options.open) openAndDraw(import);
  } catch (const Interrupted&) {
    std::cerr << "mtled: interrupted: nothing was imported\n";
    return 1;
  } catch (const InputError& error) {
    // The case's copy of the electrodes is gone.
    std::string text = error.what();
    if (const std::string copy = import.file(import.scene.electrodes);
        !import.scene.electrodes.empty() && text.starts_with(copy))
      text.replace(0, copy.size(), options.electrodes);
    throw InputError({}, import.folder.inPlace(text), "");
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - import.start;
  import.report["scan"] = options.scan;
  import.report["spacing_mm"] = import.spacing / mm;
  import.report["warnings"] = import.warnings;
  import.report["seconds"] = seconds.count();
  import.report["build"] = buildInfo();
  writeWholeFile(import.file("report.json"),
                 import.report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  import.folder.takePlace();
  if (!options.open) return 0;
  std::cout << format("%s: %.0f ml, %lld nodes, %.3g mm apart; %.1f s\n", name.c_str(), 1e6 * import.surface.volume,
                      asLongLong(import.report["nodes"].get<std::int64_t>()), import.spacing / mm, seconds.count())
            << "scene    " << import.folder.file("scene.toml") << "\npreview  "
            << (withoutPictures().empty() ? import.folder.file("preview.png") : withoutPictures()) << "\nreport   "
            << import.folder.file("report.json") << std::endl;
  return 0;
}

bool isScan(const std::string& file) {
  const std::string name = lowerCase(file);
  return name.ends_with(".nii") || name.ends_with(".nii.gz");
}

}  // namespace palpate::tools
