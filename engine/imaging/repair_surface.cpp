#include "imaging/repair_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/input_error.h"
#include "base/number_text.h"
#include "base/parallel_for.h"
#include "base/ranked.h"
#include "discretization/surface/surface_geometry.h"
#include "discretization/surface/surface_parts.h"
#include "discretization/surface/surface_tree.h"
#include "imaging/mend_surface.h"
#include "imaging/remesh.h"
#include "imaging/signed_field.h"
#include "imaging/surface_distance.h"

namespace palpate {
namespace {

// The grid's cell beside the spacing of the body's nodes; and beside their cube root, the least cells along the body.
constexpr double cell_of_spacing = 0.25, cells_of_nodes = 2.3, least_cell_of_spacing = 0.12;
// The thinnest walls have so many cells, if the grid then has no more nodes than can be held.
constexpr double cells_of_wall = 3;
constexpr double grid_nodes_of_node = 500;
// Rays that measure the walls.
constexpr int wall_rays = 1000;
// Edges of the even triangles, in cells.
constexpr double edge_in_cells = 2.0, short_edge_in_cells = 1.25;
// A surface whose inside lets out this share of the rays that its outside does is an open sheet: a half ball has 0.5, a
// box without a lid 0.2: what max_filled_share allows of the boundary of a convex body.
constexpr double sheet_see_through = 0.19;
// Points of a surface at which distances are measured.
constexpr int distance_points = 20'000;
// Where more of the given surface than this is lost, a finer grid is tried.
constexpr double bearable_loss = 0.05;
// Piercing faces are cut out where they and those around them are no more of the area than this, and the volume changes
// by no more.
constexpr double max_cut_share = 0.03;
// Small parts thinner than this many of the grid's cells do not show on it.
constexpr double thin_part = 0.5;
// Cut off with piercing faces: no more than crumbs.
constexpr double max_crumb_share = 1e-4;
// A body keeps this share of its volume where spikes are taken off, or triangles made fewer: else it is a thin shell,
// of which that would leave crumbs.
constexpr double least_kept = 0.85;
// What has lost more than this share of its outside and of its volume is no longer what was given.
constexpr double most_lost = 0.5;
// The next try's cell; the widest opening, in cells: the field knows its distance to three.
constexpr double finer = 0.6, most_opening = 5;
// A gap is what is further from the given faces than this many cells.
constexpr double gap_cells = 2;

/// What checkSurface says of it; empty: it bounds a solid.
std::string faultOf(const TriangleSurface& surface) {
  try {
    checkSurface(surface);
    return {};
  } catch (const InputError& error) {
    const std::string text = error.what();
    return text.substr(0, text.find(';'));
  }
}

/// Takes the surface to the origin and to a length of 0.2, where rounding is small, and back.
class Frame {
 public:
  explicit Frame(const Box3& box)
      : centre_(box.center()), scale_(box.diagonal().norm() > 0 ? box.diagonal().norm() / 0.2 : 1) {}
  TriangleSurface to(TriangleSurface s) const {
    for (Vec3& x : s.vertices) x = (x - centre_) / scale_;
    return s;
  }
  TriangleSurface back(TriangleSurface s) const {
    for (Vec3& x : s.vertices) x = centre_ + scale_ * x;
    return s;
  }
  double scale() const { return scale_; }

 private:
  Vec3 centre_;
  double scale_;
};

class Repair {
 public:
  Repair(TriangleSurface surface, SurfaceSource source, const RepairOptions& options)
      : surface_(std::move(surface)), source_(std::move(source)), options_(options) {
    report_.given_faces = static_cast<int>(surface_.triangles.size());
  }

  RepairedSurface run() {
    dropStray(surface_, source_, report_);
    const bool too_fine = options_.max_faces > 0 && report_.given_faces > options_.max_faces;
    const bool anew = too_fine || options_.thinnest > 0;
    step("checking", 0);
    if (!anew && (report_.resampled_because = faultOrContact()).empty()) {
      dropSmallParts(surface_, source_, report_, 0);
      return finish();
    }
    step("mending", 0.1);
    tidyFaces(surface_, source_, report_);
    if (surface_.triangles.empty()) refuseSheet();
    step("finding the outside", 0.15);
    orientPatches(surface_, source_, report_);
    if (report_.see_through > sheet_see_through) refuseSheet();
    step("closing holes", 0.25);
    TriangleSurface given = surface_;
    given.triangles.resize(static_cast<std::size_t>(fillHoles(surface_, source_, report_)));
    if (!anew) {
      dropSmallParts(surface_, source_, report_, thin_part * wideCell(surface_));
      step("checking", 0.3);
      if ((report_.resampled_because = faultOrContact()).empty()) return finish();
      step("cutting out faces that pierce others", 0.35);
      if (cutPiercing()) return finish();
    } else if (!too_fine) {
      report_.resampled_because = "the body can't be divided while it has such thin spikes or walls";
    } else {
      report_.resampled_because =
          "there are more than the " + std::to_string(options_.max_faces) + " faces that a touched surface needs";
    }
    makeAnew(given);
    return finish();
  }

 private:
  void step(const char* what, double share) {
    if (options_.progress) options_.progress(what, share);
  }

  [[noreturn]] void refuseSheet() {
    std::string problem = "the surface does not enclose a volume: ";
    if (report_.invented_share > 0)
      problem += format("%.0f %% of what would have to bound it is missing", 100 * report_.invented_share);
    else
      problem += "it is an open sheet, or has a large opening";
    throw InputError({source_.file, 0, 0}, problem,
                     "an organ needs a surface that is closed but for small holes: cap the opening (\"fill holes\"), "
                     "or give the sheet a thickness (\"solidify\"), in a mesh editor");
  }

  /// What is wrong with the surface, or that parts of it touch face on face: nothing is wrong with each, but they are
  /// one body. Empty: neither.
  std::string faultOrContact() const {
    const std::string fault = faultOf(surface_);
    if (!fault.empty()) return fault;
    return bodiesOf(surface_).touching ? "parts of it touch, face on face" : "";
  }

  static Bodies bodiesOf(const TriangleSurface& surface) {
    std::vector<FaceEdge> edges = faceEdges(surface);
    const SurfaceParts parts = connectedParts(surface, edges);
    return joinedParts(surface, parts, std::vector<char>(static_cast<std::size_t>(parts.count), 1));
  }

  /// Cuts the faces that pierce others out, with those around them, and closes the holes. False, and nothing has
  /// changed, where they are many or the result is no better.
  bool cutPiercing() {
    TriangleSurface surface = surface_;
    SurfaceSource source = source_;
    RepairReport report = report_;
    const int bodies = bodiesOf(surface_).count;
    const int most = std::max(20, static_cast<int>(surface.triangles.size()) / 200);
    constexpr int max_rounds = 3;
    for (int round = 0; round < max_rounds; ++round) {
      const std::vector<int> piercing = piercingFaces(surface, most);
      if (piercing.empty() || static_cast<int>(piercing.size()) >= most) return false;
      std::vector<char> near(surface.vertices.size(), 0), cut(surface.triangles.size(), 0);
      for (const int t : piercing) cut[t] = 1;
      for (int ring = 0; ring <= round; ++ring) {
        for (std::size_t t = 0; t < cut.size(); ++t)
          if (cut[t])
            for (const int v : surface.triangles[t]) near[v] = 1;
        for (std::size_t t = 0; t < cut.size(); ++t)
          for (const int v : surface.triangles[t]) cut[t] |= near[v];
      }
      std::size_t kept = 0;
      double area = 0;
      for (std::size_t t = 0; t < cut.size(); ++t) {
        if (cut[t])
          area += areaVector(surface, static_cast<int>(t)).norm();
        else
          surface.triangles[kept++] = surface.triangles[t];
      }
      if (area > max_cut_share * surfaceArea(surface_)) return false;
      surface.triangles.resize(kept);
      source.triangle_line.clear();
      source.vertex_line.clear();
      RepairReport ignored;
      dropUnusedVertices(surface, source);
      fillHoles(surface, source, ignored);
      dropSmallParts(surface, source, ignored, 0);
      report.piercing_faces += static_cast<int>(piercing.size());
      const bool same_volume =
          std::abs(signedVolume(surface) - signedVolume(surface_)) <= max_cut_share * std::abs(signedVolume(surface_));
      const bool whole = ignored.small_volume_share <= max_crumb_share && bodiesOf(surface).count <= bodies;
      if (same_volume && whole && faultOf(surface).empty()) {
        surface_ = std::move(surface);
        source_ = std::move(source);
        report_ = report;
        report_.resampled_because.clear();
        return true;
      }
    }
    return false;
  }

  /// The wall's thickness below which a fifth of the surface has it, by rays inwards: spikes have less area.
  static double thinWall(const SurfaceTree& tree) {
    const TriangleSurface& s = tree.surface();
    const double off = 1e-5 * boundingBox(s).diagonal().norm();
    const SurfacePoints points = pointsOn(s, wall_rays);
    std::vector<double> walls;
    for (std::size_t k = 0; k < points.x.size(); ++k) {
      const Vec3 n = areaVector(s, points.face[k]).stableNormalized();
      if (const auto hit = tree.firstHit(points.x[k] - off * n, -n)) walls.push_back(hit->distance);
    }
    if (walls.empty()) return std::numeric_limits<double>::infinity();
    return ranked(walls, walls.size() / 5);
  }

  /// The spacing with which the body has its nodes, as far as its volume tells.
  double nodeSpacing(const TriangleSurface& s) const {
    const double size = boundingBox(s).diagonal().norm();
    const double volume = std::max(std::abs(signedVolume(s)), 1e-4 * surfaceArea(s) * size);
    return std::cbrt(volume / (0.7 * options_.body_nodes));
  }
  /// The grid's cell where no wall is thin.
  double wideCell(const TriangleSurface& s) const {
    return std::min(cell_of_spacing * nodeSpacing(s),
                    boundingBox(s).diagonal().norm() / (cells_of_nodes * std::cbrt(options_.body_nodes)));
  }
  double firstCell(const SurfaceTree& tree) const {
    const double least = least_cell_of_spacing * nodeSpacing(tree.surface());
    return std::min(wideCell(tree.surface()), std::max(thinWall(tree) / cells_of_wall, least));
  }

  /// Share of the given surface's outside that has no new surface within reach.
  double lostShare(const SurfaceTree& given, const SurfaceTree& made, double reach) const {
    const SurfacePoints points = pointsOn(given.surface(), distance_points / 4);
    int outer = 0, lost = 0;
    for (std::size_t k = 0; k < points.x.size(); ++k) {
      const Vec3 n = areaVector(given.surface(), points.face[k]).stableNormalized();
      if (given.windingNumber(points.x[k] + 1e-4 * 0.2 * n) > 0.5) continue;
      ++outer;
      if (made.closest(points.x[k], reach).triangle < 0) ++lost;
    }
    return outer > 0 ? static_cast<double>(lost) / outer : 0;
  }

  /// @param given_faces  the mended surface without the faces that close holes
  void makeAnew(const TriangleSurface& given_faces) {
    given_bodies_ = bodiesOf(surface_).count;
    const Frame frame(boundingBox(surface_));
    const TriangleSurface normal = frame.to(surface_);
    const SurfaceTree tree(normal);
    const SurfaceTree given(report_.holes > 0 ? frame.to(given_faces) : normal);
    const Box3 box = boundingBox(normal);
    double cell = firstCell(tree);
    SampledField field;
    TriangleSurface made;
    const RepairReport before = report_;
    constexpr int max_tries = 2;
    for (int attempt = 1;; ++attempt) {
      while (fieldNodes(box, cell) > grid_nodes_of_node * options_.body_nodes) cell *= 1.05;
      const double from = 0.2 + 0.2 * attempt;
      field = signedField(tree, cell, [&](double share) { step("winding numbers on a grid", from + 0.15 * share); });
      const SmallRegions small = removeSmallRegions(field, least_part_share, least_cavity_share);
      made = isosurface(field);
      report_.small_parts = before.small_parts + small.parts;
      report_.small_volume_share = before.small_volume_share + small.part_share;
      report_.filled_bubbles = before.filled_bubbles + small.hollows;
      const bool last = attempt == max_tries || options_.thinnest > 0;
      if (!made.triangles.empty())
        report_.lost_share = lostShare(given, SurfaceTree(made), gap_cells * cell);
      else if (last)
        refuseSheet();
      if (last || (!made.triangles.empty() && report_.lost_share <= bearable_loss)) break;
      cell *= finer;
    }
    report_.invented_share = distanceTo(given, pointsOn(made, distance_points).x).shareBeyond(gap_cells * cell);
    if (report_.invented_share > max_filled_share || 2 * signedVolume(made) < 0.5 * cell * surfaceArea(made))
      refuseSheet();
    report_.cell = cell * frame.scale();
    step("making the triangles even", 0.85);
    surface_ = frame.back(evenOrOpened(made, field, options_.thinnest / frame.scale()));
    if (report_.opened > 0) {
      report_.opened *= frame.scale();
      report_.lost_share = lostShare(given, SurfaceTree(frame.to(surface_)), gap_cells * cell);
    }
    const double given_volume = std::pow(frame.scale(), 3) * std::abs(signedVolume(normal));
    if (report_.lost_share > most_lost && signedVolume(surface_) < most_lost * given_volume)
      throw InputError({source_.file, 0, 0},
                       format("the body is too thin to be made anew: of its surface %.0f %% would be lost on a grid of "
                              "%.3g mm",
                              100 * report_.lost_share, 1e3 * report_.cell),
                       "thicken its walls, or fill its inside, in a mesh editor");
    report_.made_faces = static_cast<int>(surface_.triangles.size());
    if (options_.max_faces > 0 && report_.made_faces > options_.max_faces)
      throw InputError({source_.file, 0, 0},
                       "the body is so thin for its size that its surface takes " + std::to_string(report_.made_faces) +
                           " faces, more than " + std::to_string(options_.max_faces),
                       "fill its inside, or thicken its walls, in a mesh editor");
  }

  /// Even triangles; without spikes and walls thinner than `thinnest`, or, where that takes it, than two cells. As the
  /// grid gives them where nothing helps.
  TriangleSurface evenOrOpened(const TriangleSurface& made, const SampledField& field, double thinnest) {
    if (thinnest <= 0) {
      if (auto even = evenTriangles(made, field)) return std::move(*even);
      thinnest = 2 * field.cell;
    }
    step("removing spikes", 0.9);
    const RepairReport before = report_;
    const SampledField open = opened(made, field.cell, 0.5 * std::min(thinnest, most_opening * field.cell));
    TriangleSurface without = open.value.empty() ? TriangleSurface() : isosurface(open);
    if (without.triangles.empty() || signedVolume(without) < least_kept * signedVolume(made)) {
      report_ = before;
      return uneven(made, field);
    }
    report_.opened = thinnest;
    if (auto even = evenTriangles(without, open)) return std::move(*even);
    return uneven(std::move(without), open);
  }

  /// The triangles that the grid gave; where they are too many those of coarser grids, which may be even.
  TriangleSurface uneven(TriangleSurface made, const SampledField& field) {
    const Field at = [&](const Vec3& x) { return field.at(x); };
    double cell = field.cell;
    while (options_.max_faces > 0 && static_cast<int>(made.triangles.size()) > options_.max_faces) {
      SetupWatch::check();
      const double wider = 1.05 * std::sqrt(static_cast<double>(made.triangles.size()) / options_.max_faces);
      cell *= wider;
      const Vec3 last = field.position(static_cast<int>(field.value.size()) - 1);
      SampledField coarser = sampleField(at, field.origin, last, cell);
      removeSmallRegions(coarser, least_part_share, least_cavity_share);
      TriangleSurface fewer = reachesBox(coarser) ? TriangleSurface() : isosurface(coarser);
      if (fewer.triangles.empty() || signedVolume(fewer) < least_kept * signedVolume(made)) break;
      report_.cell *= wider;
      if (auto even = evenTriangles(fewer, coarser)) return std::move(*even);
      made = std::move(fewer);
    }
    return made;
  }

  /// The body without what a ball of this radius does not reach from inside (a morphological opening). No values where
  /// nothing is left.
  SampledField opened(const TriangleSurface& body, double cell, double radius) {
    SampledField field = signedField(SurfaceTree(body), cell);  // to the body's own skin: the given had walls inside
    for (double& value : field.value) value += radius;
    const SmallRegions small = removeSmallRegions(field, least_part_share, 0);
    report_.small_parts += small.parts;
    report_.small_volume_share += small.part_share;
    const TriangleSurface core = isosurface(field);
    if (core.triangles.empty()) return {};
    field = signedField(SurfaceTree(core), cell);
    for (double& value : field.value) value -= radius;
    return reachesBox(field) ? SampledField() : field;
  }

  /// Nothing where walls would meet.
  std::optional<TriangleSurface> evenTriangles(const TriangleSurface& made, const SampledField& field) {
    const Field at = [&](const Vec3& x) { return field.at(x); };
    for (const double edge : {edge_in_cells, short_edge_in_cells}) {
      SetupWatch::check();
      TriangleSurface even = remesh(made, at, edge * field.cell);
      if (even.triangles.empty() || !faultOf(even).empty()) continue;
      report_.even_triangles = true;
      return even;
    }
    return {};
  }

  RepairedSurface finish() {
    const SurfaceParts parts = connectedParts(surface_, faceEdges(surface_));
    report_.parts = parts.count;
    report_.cavities = 0;
    if (parts.count > 1)
      for (const TriangleSurface& part : separateParts(surface_, parts)) report_.cavities += signedVolume(part) < 0;
    if (given_bodies_ > 0) report_.came_apart = std::max(0, parts.count - report_.cavities - given_bodies_);
    step("done", 1);
    return {std::move(surface_), std::move(report_)};
  }

  TriangleSurface surface_;
  SurfaceSource source_;
  const RepairOptions& options_;
  RepairReport report_;
  int given_bodies_ = 0;  // before the surface was made anew
};

}  // namespace

RepairedSurface repairSurface(TriangleSurface surface, SurfaceSource source, const RepairOptions& options) {
  return Repair(std::move(surface), std::move(source), options).run();
}

}  // namespace palpate
