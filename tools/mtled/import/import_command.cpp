#include "mtled/import/import_command.h"

#include <cmath>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "base/parallel_for.h"
#include "base/printable_text.h"
#include "discretization/surface/surface_parts.h"
#include "imaging/mend_surface.h"
#include "imaging/repair_surface.h"
#include "imaging/surface_distance.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/scene_file.h"
#include "io/surface_file.h"
#include "mtled/import/import_scene.h"
#include "mtled/import/import_unit.h"
#include "mtled/report/pictures.h"
#include "mtled/run/case_folder.h"
#include "mtled/run/progress.h"

namespace palpate::tools {
namespace {

// More faces than these cost the window and the contact time, and show nothing.
constexpr int max_faces = 100'000;
// A surface further from the origin than this many of its sizes is moved there: single precision would feel it.
constexpr double far_sizes = 20;
// The widest spacing, of the body's least extent; and the nodes of a thin body that can be waited for.
constexpr double least_layers = 0.95, max_nodes = 12'000;
// Above this the budget's cost is brought down by one more try, and told where that does not help.
constexpr double bearable_cost = 1.2;
// Told as lost: what is further from the organ than so many cells of the grid that it was made on, or than this
// fraction of its size where it was not.
constexpr double lost_cells = 4, lost_share = 0.02;
// Points on each of two surfaces at which their distance is measured.
constexpr int distance_points = 40'000;

void stopWhereInterrupted() {
  if (interrupted()) throw std::runtime_error("interrupted: nothing was imported");
}

/// Both ways: from the given faces to the organ's, and back.
struct Deviation {
  SurfaceDistance from_given, from_made;
  std::string text() const {
    return format(
        "%.3g mm mean, %.3g mm for 95 %%, %.3g mm at most; from the organ back to the file %.3g, %.3g and "
        "%.3g mm",
        1e3 * from_given.mean, 1e3 * from_given.p95, 1e3 * from_given.max, 1e3 * from_made.mean, 1e3 * from_made.p95,
        1e3 * from_made.max);
  }
};

nlohmann::json jsonOf(const SurfaceDistance& d) { return {{"mean", d.mean}, {"p95", d.p95}, {"max", d.max}}; }

class SurfaceImport {
 public:
  explicit SurfaceImport(const ImportOptions& options)
      : options_(options),
        name_(printable(std::filesystem::path(options.file).stem().string())),
        folder_(options.out.empty() ? "out/" + std::filesystem::path(options.file).stem().string() : options.out,
                {"surface.obj", "organ.png", "report.json", "scene.toml"}, {options.file}) {}

  int run() {
    const SetupWatch watch(stopWhereInterrupted);
    read();
    found_in_file_ = findings_;
    makeOrgan();
    makeScene();
    for (const std::string& line : findings_) std::cout << "  " << line << "\n";
    std::cout << name_ << ": " << model_->nodeCount() << " nodes, " << model_->substeps_per_tick
              << (model_->substeps_per_tick == 1 ? " step" : " steps") << " a tick, spacing " << spacingText() << "\n";
    const std::string picture = draw();
    writeReport(picture);
    stopWhereInterrupted();
    folder_.takePlace();
    for (const std::string& line : warnings_) warn(line);
    const std::string scene = folder_.file("scene.toml");
    std::cout << "surface  " << folder_.file("surface.obj") << "\nscene    " << scene << "\npicture  " << picture
              << "\nreport   " << folder_.file("report.json") << "\nTouch it: palpate " << scene << "\n";
    std::cout.flush();
    return 0;
  }

 private:
  /// Where the cloud follows, the ball's and that far from it.
  std::string spacingText() const {
    const Scene& scene = model_->scene;
    const std::string far = format("%.3g mm", 1e3 * scene.discretization.spacing);
    if (scene.discretization.refine.empty()) return far;
    return format("%.3g mm around the tool, ", 1e3 * scene.discretization.refine[0].spacing) + far + " elsewhere";
  }

  void find(const std::string& line) { findings_.push_back(line); }

  void read() {
    {
      ProgressLine progress("import");
      progress.show(0, "reading");
      file_ = readSurface(options_.file, 1.0, {}, SurfaceReading::Tolerant);
    }
    dropStray(file_.surface, file_.source, strays_);
    const Box3 box = boundingBox(file_.surface);
    unit_ = surfaceUnit(options_.file, options_.unit, box.sizes().maxCoeff());
    find(std::to_string(file_.surface.triangles.size() + static_cast<std::size_t>(strays_.stray_faces)) + " faces in " +
         unit_.name + " (" + unit_.reason + ")");
    for (Vec3& x : file_.surface.vertices) x *= unit_.length;
    const double size = unit_.length * box.diagonal().norm();
    const Vec3 centre = unit_.length * box.center();
    if (centre.norm() > far_sizes * size) {
      moved_ = -centre;
      for (Vec3& x : file_.surface.vertices) x += moved_;
      find(format("moved to the origin, by (%.6g, %.6g, %.6g) m: it was %.0f of its sizes away", moved_.x(), moved_.y(),
                  moved_.z(), centre.norm() / size));
    }
  }

  /// Points of the file's surface, without those that lie within the organ: walls and parts that were united or
  /// removed.
  std::vector<Vec3> pointsOutside() {
    std::vector<Vec3> points = pointsOn(file_.surface, distance_points).x;
    const double within = std::max(2 * report_.cell, 1e-3 * boundingBox(organ_->surface()).diagonal().norm());
    const auto all = static_cast<double>(points.size());
    std::vector<char> inside(points.size(), 0);
    parallelFor(static_cast<int>(points.size()), [&](int begin, int end) {
      for (int k = begin; k < end; ++k)
        inside[k] = organ_->closest(points[k], within).triangle < 0 && organ_->inside(points[k]);
    });
    std::size_t kept = 0;
    for (std::size_t k = 0; k < points.size(); ++k)
      if (!inside[k]) points[kept++] = points[k];
    points.resize(kept);
    inside_share_ = all > 0 ? 1 - static_cast<double>(kept) / all : 0;
    return points;
  }

  /// What can't be mended may be so because of what can't be read.
  RepairedSurface mended(const RepairOptions& options) const {
    try {
      return repairSurface(file_.surface, file_.source, options);
    } catch (const InputError& error) {
      if (file_.unreadable_faces == 0) throw;
      throw InputError({}, error.what(),
                       "but first: " + std::to_string(file_.unreadable_faces) +
                           " of the file's faces can't be read (cut off, or without proper vertices): write it anew" +
                           (file_.unreadable.empty() ? "" : "; the first: " + file_.unreadable));
    }
  }

  /// @param thinnest  see RepairOptions
  void makeOrgan(double thinnest = 0) {
    ProgressLine progress("import");
    RepairOptions repair;
    repair.thinnest = thinnest;
    repair.max_faces = max_faces;
    repair.progress = [&](const std::string& what, double share) {
      stopWhereInterrupted();
      progress.show(0.6 * share, what);
    };
    RepairedSurface repaired = mended(repair);
    report_ = std::move(repaired.report);
    report_.unreadable_faces = file_.unreadable_faces;
    report_.concave_polygons = file_.concave_polygons;
    report_.unused_vertices = file_.unused_vertices;
    report_.stray_vertices += strays_.stray_vertices;
    report_.stray_faces += strays_.stray_faces;
    report_.stray_sizes = std::max(report_.stray_sizes, strays_.stray_sizes);
    findings_ = found_in_file_;
    if (report_.changedNothing()) find("it bounds a solid: kept as it is");
    for (const std::string& line : report_.lines()) find(line);
    progress.show(0.7, "measuring the distance");
    organ_.emplace(std::move(repaired.surface));
    const std::vector<Vec3> outside = pointsOutside();
    deviation_.from_given = distanceTo(*organ_, outside);
    deviation_.from_made = distanceTo(SurfaceTree(file_.surface), pointsOn(organ_->surface(), distance_points).x);
    stopWhereInterrupted();
    if (inside_share_ > 0.0005)
      find(format("%.2g %% of the file's surface lies within the organ", 100 * inside_share_));
    if (!report_.changedNothing()) find("distance from the file's outer surface to the organ's: " + deviation_.text());
    if (!file_.unreadable.empty()) find("the first line that can't be read: " + file_.unreadable);
    warnings_.clear();
    if (deviation_.from_given.furthest >= 0)
      warnWhereLost(outside[static_cast<std::size_t>(deviation_.from_given.furthest)]);
    const TriangleSurface& surface = organ_->surface();
    const Vec3 size = 1e3 * boundingBox(surface).sizes();
    find(format("%.3g x %.3g x %.3g mm, %.3g ml, ", size.x(), size.y(), size.z(), 1e6 * signedVolume(surface)) +
         std::to_string(surface.triangles.size()) + " faces");
  }

  /// What of the file's surface is not in the organ's, by far.
  /// @param furthest  the point of the file's surface that is furthest from the organ
  void warnWhereLost(const Vec3& furthest) {
    const double size = boundingBox(organ_->surface()).diagonal().norm();
    const double far = report_.resampled() ? lost_cells * report_.cell : lost_share * size;
    if (!(deviation_.from_given.max > far)) return;
    const Vec3 at = (furthest - moved_) / unit_.length;
    warnings_.push_back(
        format("%.2g %% of the file's outer surface is not in the organ's, the furthest %.3g mm off it, "
               "at (%.4g, %.4g, %.4g) in the file: what is there is lost; if it matters, unite it with "
               "the rest or thicken it in a mesh editor",
               100 * deviation_.from_given.shareBeyond(far), 1e3 * deviation_.from_given.max, at.x(), at.y(), at.z()));
  }

  /// Where a body with thin spikes or walls can't be divided: one without them, if something is left then.
  bool makeThicker(double spacing) {
    try {
      makeOrgan(0.5 * spacing);
      return true;
    } catch (const InputError&) {
      return false;  // all of it is thin
    }
  }

  /// The nodes are no further apart than the body is thick, whatever that costs.
  double spacingOf(const BodyMeasures& body) const { return std::min(firstSpacing(body), widestSpacing()); }
  double widestSpacing() const { return least_layers * boundingBox(organ_->surface()).sizes().minCoeff(); }

  /// Writes surface and scene, and opens them as the window will: once, where the counts told the spacing that holds
  /// the rate; a second time with a coarser one where it costs too much, and others where it is refused.
  void makeScene() {
    BodyMeasures body = measuresOf(*organ_);
    double spacing = spacingOf(body);
    bool thicker = false, coarser = false;
    std::string why;  // it was refused, at first
    constexpr int max_refusals = 3;
    if (opensFollowing(body, spacing)) return;
    for (int refusals = 0;;) {
      const double nodes = nodesAt(body, spacing);
      if (nodes > max_nodes)
        throw InputError({options_.file}, format("so thin for its size that it takes some %.0f nodes", nodes),
                         "import a part of it, or a thicker one: 5,000 nodes hold 500 Hz");
      const std::string scene_file = writeScene(spacing);
      try {
        model_.emplace(open(scene_file));
      } catch (const InputError& error) {
        why = error.what();
        if (why.starts_with(scene_file))
          why.erase(0, std::min(why.size(), why.find(": ", scene_file.size()) + 2));  // a file that goes, too
        if (++refusals > max_refusals)
          throw InputError({options_.file}, "no scene can be made of it: " + why,
                           "smooth or thicken the surface in a mesh editor where it is sharp or thin");
        if (!std::exchange(thicker, true) && makeThicker(spacing)) {
          body = measuresOf(*organ_);
          spacing = spacingOf(body);
        } else {
          spacing *= 0.8;  // a finer one follows a difficult shape more closely
        }
        continue;
      }
      const double cost = static_cast<double>(model_->nodeCount()) * model_->substeps_per_tick / node_steps_budget;
      const double wider = spacing * std::max(1.03, std::pow(cost, 0.3));
      if (cost > bearable_cost && refusals == 0 && wider <= widestSpacing() && !std::exchange(coarser, true)) {
        spacing = wider;
        continue;
      }
      if (!why.empty()) findings_.push_back("refused at first, with other triangles or a wider spacing: " + why);
      if (cost > bearable_cost)
        findings_.push_back(
            format("so thin that it takes %.1f times what holds 500 Hz on two cores: slower than life", cost));
      return;
    }
  }

  /// A cloud that follows the tool, where the body can have one that costs no more.
  bool opensFollowing(const BodyMeasures& body, double spacing) {
    if (separateParts(organ_->surface(), connectedParts(organ_->surface(), faceEdges(organ_->surface()))).size() > 1)
      return false;
    constexpr double most_nodes = 60000;  // of the fine cloud, which is made anew for each try
    if (nodesAt(body, 0.5 * chooseScene(*organ_, spacing).tool_radius) > most_nodes) return false;
    for (const bool slowed : {false, true}) {
      try {
        model_.emplace(open(writeScene(spacing, true, slowed)));
      } catch (const InputError&) {
        return false;
      }
      const double cost = static_cast<double>(model_->nodeCount()) / node_steps_budget;
      if (cost * model_->substeps_per_tick <= 1) return true;
      if (cost > 1) return false;  // however few the steps are
    }
    return false;
  }

  std::string writeScene(double spacing, bool follows = false, bool slowed = true) const {
    ImportedScene scene = chooseScene(*organ_, spacing);
    scene.follows = follows;
    scene.slowed = slowed;
    scene.name = name_;
    scene.source = std::filesystem::path(options_.file).filename().string();
    writeObj(organ_->surface(), folder_.aside("surface.obj"));
    writeWholeFile(folder_.aside("scene.toml"), sceneText(scene));
    return folder_.aside("scene.toml");
  }

  Model open(const std::string& scene_file) {
    ProgressLine progress("opening the scene");
    const ModelCache cache(options_.use_cache ? ModelCache::userFolder() : "", warn);
    return loadModel(
        readScene(scene_file),
        [&](const std::string& what, double share) {
          stopWhereInterrupted();
          progress.show(share, what);
        },
        cache, warn);
  }

  /// What to say of the picture: its file, or why there is none.
  std::string draw() const {
    BodyPicture picture;
    picture.title = name_;
    picture.colour = ColourMap::Tissue;
    picture.azimuth_deg = -68;
    picture.elevation_deg = 30;
    picture.rest_outline = false;
    picture.tool = model_->tools.first().start.pose;
    try {
      const CutPlane* const whole = nullptr;
      return folder_.inPlace(
          writePicture(folder_.aside("organ.png"), picture, *model_, AlignedVector<Float4>(), whole));
    } catch (const std::runtime_error& error) {
      return "none: " + folder_.inPlace(error.what());
    }
  }

  void writeReport(const std::string& picture) const {
    nlohmann::json report = {{"file", options_.file},
                             {"unit", unit_.name},
                             {"unit_reason", unit_.reason},
                             {"moved_m", {moved_.x(), moved_.y(), moved_.z()}},
                             {"findings", findings_},
                             {"warnings", warnings_},
                             {"kept_as_it_is", report_.changedNothing()},
                             {"made_anew", report_.resampled()},
                             {"cell_m", report_.cell},
                             {"holes_closed", report_.holes},
                             {"turned_faces", report_.turned_faces},
                             {"parts", report_.parts},
                             {"cavities", report_.cavities},
                             {"faces", organ_->surface().triangles.size()},
                             {"volume_m3", signedVolume(organ_->surface())},
                             {"share_of_file_within", inside_share_},
                             {"distance_from_file_m", jsonOf(deviation_.from_given)},
                             {"distance_to_file_m", jsonOf(deviation_.from_made)},
                             {"nodes", model_->nodeCount()},
                             {"steps_per_tick", model_->substeps_per_tick},
                             {"spacing_m", model_->scene.discretization.spacing},
                             {"picture", picture},
                             {"build", buildInfo()}};
    writeWholeFile(folder_.aside("report.json"),
                   report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  }

  const ImportOptions& options_;
  std::string name_;
  CaseFolder folder_;
  SurfaceFile file_;  // m, once the unit is known
  SurfaceUnit unit_;
  Vec3 moved_ = Vec3::Zero();  // m
  RepairReport strays_, report_;
  std::optional<SurfaceTree> organ_;
  Deviation deviation_;
  double inside_share_ = 0;  // of the file's surface
  std::vector<std::string> found_in_file_, findings_, warnings_;
  std::optional<Model> model_;
};

}  // namespace

int importCommand(const ImportOptions& options) { return SurfaceImport(options).run(); }

}  // namespace palpate::tools
