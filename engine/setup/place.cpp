#include "setup/place.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/number_text.h"
#include "discretization/cells/cell_pairs.h"
#include "discretization/nodes/node_scatter.h"
#include "discretization/nodes/site_grid.h"
#include "discretization/surface/surface_bodies.h"
#include "discretization/surface/surface_geometry.h"
#include "scene/scene_messages.h"
#include "scene/scene_regions.h"
#include "scene/scene_rigid.h"
#include "setup/choose_time_step.h"
#include "setup/discretize_parts.h"
#include "setup/imposed_nodes.h"
#include "setup/interface_nodes.h"
#include "setup/join_bodies.h"
#include "setup/make_tools.h"

namespace palpate {
namespace {

constexpr double fine_radii = 0.5, coarse_radii = 1.2, narrowest_of_body = 0.1, widest_of_body = 0.2;
constexpr double sharpest =
    0.4;  // of the tool's radius, for tips below its square; below 1/16 told of (resolutionWarning)
constexpr double thin_share = 0.1;       // of the skin
constexpr double least_across = 4;       // nodes across a body, of its volume's cube root
constexpr double most_for_thin = 6000;   // nodes that a thin body gets for it
constexpr double hysteresis = 0.25;      // strides
constexpr double longest_stride = 0.01;  // m
constexpr int kept_of_region = 6;        // nodes of each imposed region that are always live
/// Rows at places that were not looked at may need a little more than those at the first: 2 % of the step.
constexpr double row_margin = 0.96;
constexpr double least_critical = 0.95;  // of the first place's critical step, that all have

/// The scene's own refinements that ask for less than a spacing.
std::vector<RefineSpec> finerThan(double spacing, const std::vector<RefineSpec>& refine) {
  std::vector<RefineSpec> finer = refine;
  std::erase_if(finer, [&](const RefineSpec& r) { return !(r.spacing < spacing); });
  return finer;
}

/// Nodes of each imposed region that have neighbours outside: a coarse cloud keeps them as a sheet, or what is held
/// would end where its next node happens to be, and the body above it be softer (the kidney by 2 %).
void markBorders(const Scene& scene, const SurfaceTree& organ, const Discretization& d,
                 std::vector<std::uint8_t>& dimension) {
  for (const BoundarySpec& spec : scene.boundaries) {
    if (spec.region.kind == Region::Kind::Point || spec.surface_only) continue;
    std::vector<std::uint8_t> in(d.cloud.X.size());
    for (std::size_t i = 0; i < in.size(); ++i) in[i] = contains(spec.region, d.cloud.X[i], organ);
    for (const auto& cell : d.cells.cells) {
      const auto inside = std::count_if(cell.begin(), cell.end(), [&](int i) { return in[i]; });
      if (inside == 0 || inside == 4) continue;
      for (const int i : cell)
        if (in[i]) dimension[i] = std::min<std::uint8_t>(dimension[i], d.cloud.on_surface[i] ? 1 : 2);
    }
  }
}

std::vector<std::uint8_t> dimensionsOf(const Scene& scene, const SurfaceTree& organ, const Discretization& d) {
  auto dimension = nodeDimensions(d.cloud, featuresOf(scene, organ), spacingField(scene));
  markBorders(scene, organ, d, dimension);
  if (!hasSharpInterfaces(scene)) return dimension;
  const auto material = cellMaterials(scene, organ, d.cloud.X, d.cells);
  std::vector<int> of_node(d.cloud.X.size(), -1);
  std::vector<std::uint8_t> on_border(d.cloud.X.size(), 0);
  for (std::size_t c = 0; c < material.size(); ++c)
    for (const int i : d.cells.cells[c]) {
      if (of_node[i] < 0) of_node[i] = material[c];
      if (of_node[i] != material[c]) on_border[i] = 1;
    }
  // Where a border meets a sharp edge is a corner, unless it runs along the edge: else coarse cells there reach over
  // the border far into the other material, and have no nodes of their own.
  const std::vector<std::uint8_t> of_surface = dimension;
  std::vector<std::uint8_t> runs_along(d.cloud.X.size(), 0);
  const auto isOnEdge = [&](int i) { return on_border[i] != 0 && of_surface[i] == 1; };
  for (const auto& cell : d.cells.cells)
    if (std::count_if(cell.begin(), cell.end(), isOnEdge) > 1)
      for (const int i : cell) runs_along[i] = 1;
  for (std::size_t i = 0; i < dimension.size(); ++i) {
    if (on_border[i] == 0) continue;
    const int border = !d.cloud.on_surface[i] ? 2 : of_surface[i] == 1 && runs_along[i] == 0 ? 0 : 1;
    dimension[i] = std::min(dimension[i], static_cast<std::uint8_t>(border));
  }
  return dimension;
}

/// Some nodes of each imposed region are live wherever the tools are, or a place could have none there.
/// @return which regions the body has part in (boundary_count)
std::vector<bool> keepRegions(BodyPlaces& body) {
  std::vector<bool> has;
  for (const BoundarySpec& spec : body.scene.boundaries) {
    std::vector<int> members;
    for (int i = 0; i < body.cloud.nodeCount() && spec.region.kind != Region::Kind::Point; ++i)
      if ((body.cloud.on_surface[i] || !spec.surface_only) && contains(spec.region, body.cloud.X[i], body.surface))
        members.push_back(i);
    if (!members.empty()) keepLive(members, kept_of_region, body.cloud);
    has.push_back(!members.empty() || spec.region.kind == Region::Kind::Point);
  }
  return has;
}

/// What a tool's ball and the spacing in it are made for, m.
double resolvedRadius(const ToolShape& tool) { return std::max(touchRadius(tool), sharpest * tool.radius); }

double smallestResolved(const Scene& scene) {
  double smallest = smallestToolRadius(scene);
  for (const ToolSpec& tool : scene.tools) smallest = std::min(smallest, resolvedRadius(tool.shape));
  return smallest;
}

/// m, in the balls where a scene says nothing.
double spacingByTools(const Scene& scene) { return fine_radii * smallestResolved(scene); }

/// By how much further apart nodes are as a scene has them.
double widening(const Scene& scene) {
  return scene.discretization.at_tools > 0 ? scene.discretization.at_tools / spacingByTools(scene) : 1;
}

/// @param resolved  m, resolvedRadius
double ballRadius(double resolved, double fine) { return std::max(ball_radii * resolved, ball_spacings * fine); }

double ballRadius(const ToolShape& tool, double fine) { return ballRadius(resolvedRadius(tool), fine); }

/// With both of a tool's jaws.
double ballRadius(const ToolSpec& tool, double fine) {
  return ballRadius(tool.shape, fine) + (tool.jaws() ? tool.opening / 2 : 0);
}

/// A rigid body that is as narrow as a tool needs nodes as near to one another, and the tools' balls are elsewhere (a
/// ball of 2.5 mm on nodes 5.3 mm apart pressed by 35 % too much): balls for round bodies that are no longer than such
/// a ball, where their middle comes nearest to the organ while they move.
std::vector<RefineSpec> ballsOfRigidBodies(const Scene& scene, const SurfaceTree& organ) {
  constexpr int looks = 16;  // at the motion
  constexpr std::size_t most = 4;
  std::vector<RefineSpec> balls;
  for (const RigidSpec& spec : scene.rigid) {
    RigidBody body;
    body.motion = spec.motion;
    const double radius = spec.surface ? meanRadius(*spec.surface) : spec.region.radius;
    if (!(radius > 0) || spec.encloses || spec.of_organ) continue;
    RefineSpec ball;
    ball.spacing = widening(scene) * fine_radii * radius;
    ball.radius = ballRadius(radius, ball.spacing);
    const RigidShape shape = solidOf(spec.region);
    const Box3 box = spec.surface ? boundingBox(*spec.surface) : Box3();
    const Vec3 middle = spec.surface ? box.center() : shape.middle();
    const double half_length = spec.surface ? 0.5 * box.diagonal().norm() : std::hypot(radius, 0.5 * shape.height);
    if (half_length > ball.radius) continue;
    const double end = motionEnd(scene);
    for (int k = 0; k <= (spec.motion.moves() ? looks : 0); ++k) {
      const Vec3 x = body.at(end * k / looks).toWorld(middle);
      ball.centre = organ.closest(x).point;
      const bool touches = organ.inside(x) || (ball.centre - x).norm() < half_length + ball.spacing;
      const bool is_new = std::none_of(balls.begin(), balls.end(), [&](const RefineSpec& other) {
        return (other.centre - ball.centre).norm() < 0.5 * ball.radius && other.spacing <= ball.spacing;
      });
      if (touches && is_new && balls.size() < most) balls.push_back(ball);
    }
  }
  return balls;
}

/// Vertices of a surface about a stride apart: each the first that is farther from all before.
std::vector<Vec3> centresOn(const TriangleSurface& skin, double stride) {
  std::vector<Vec3> centres;
  SiteGrid grid(boundingBox(skin), stride);
  for (const Vec3& x : skin.vertices) {
    bool free = true;
    grid.forEachWithin(x, stride, [&](int, const Site&) { return free = false; });
    if (!free) continue;
    grid.add({x, Vec3::Zero(), 0});
    centres.push_back(x);
  }
  return centres;
}

/// Balls with two nodes across tissue that is thinner than two fine spacings: with one or none a lamella beside narrow
/// air bends as a solid, or goes as what is around it. (Blocks of 60 x 40 x 30 mm with slits of 1 and 2 mm, 1 to 8 mm
/// apart, under a ball of 12 mm: 8 to 51 % off without, 0.4 to 9 % with half of the fine spacing, 2 to 3 % with a
/// third, which takes twice the nodes and a half more steps.)
/// @param ball_reach  m, of a tool's ball, in which they have some thousand nodes at most: wider where much is thin
std::vector<SpacingField::Refinement> thinTissue(const TriangleSurface& skin, const BodyPlaces& body,
                                                 double ball_reach) {
  // Of the fine spacing: no nearer, and not for less than a fifth (sheets 1.65 and 1.85 spacings thick are 5 and 8 % too
  // soft without, 19 and 9 expected).
  constexpr double closest = 0.5, worth = 0.8;
  // Fewer and wider ones where there are more: a comb's thousands took 57 % of its set-up to look at, these take 4.
  constexpr std::size_t most_balls = 300;
  const TriangleSurface& closed = body.surface.surface();
  const std::vector<double> thickness = thicknesses(skin, body.surface);
  double least =
      std::max(closest * body.fine, finestSpacing(signedVolume(closed), surfaceArea(closed), most_fine_nodes));
  struct Thin {
    Vec3 at;
    double thickness, volume;  // m, m^3
  };
  std::vector<Thin> thin;
  for (int t = 0; t < static_cast<int>(thickness.size()); ++t) {
    if (!(thickness[t] / 2 < worth * body.fine)) continue;
    const auto& [a, b, c] = skin.triangles[t];
    thin.push_back({(skin.vertices[a] + skin.vertices[b] + skin.vertices[c]) / 3, thickness[t],
                    0.5 * areaVector(skin, t).norm() * thickness[t]});  // half: there is skin on both sides
  }
  std::stable_sort(thin.begin(), thin.end(),
                   [](const Thin& one, const Thin& other) { return one.thickness < other.thickness; });
  const auto spacingAt = [&](const Thin& t) { return std::max(t.thickness / 2, least); };
  for (const Vec3& centre : thin.empty() ? std::vector<Vec3>{} : centresOn(skin, ball_reach / 2)) {
    double nodes = most_for_thin + 1;
    while (nodes > most_for_thin && least < worth * body.fine) {
      nodes = 0;
      for (const Thin& t : thin)
        if ((t.at - centre).norm() < ball_reach) nodes += t.volume / (volume_per_node * std::pow(spacingAt(t), 3));
      if (nodes > most_for_thin) least *= 1.05;
    }
  }
  std::vector<SpacingField::Refinement> balls;
  for (double apart = 2;; apart *= 1.5) {  // spacings
    balls.clear();
    SiteGrid grid(boundingBox(skin), apart * body.fine);
    for (const Thin& t : thin) {
      const double spacing = spacingAt(t);
      if (!(spacing < worth * body.fine)) break;
      bool is_covered = false;
      grid.forEachWithin(t.at, apart * spacing, [&](int k, const Site& site) {
        is_covered = (site.X - t.at).norm() < apart * balls[static_cast<std::size_t>(k)].spacing;
        return !is_covered;
      });
      if (is_covered) continue;
      grid.add({t.at, Vec3::Zero(), 0});
      balls.emplace_back();
      balls.back().centre = t.at;
      balls.back().radius = (apart + 1) * spacing;
      balls.back().spacing = spacing;
    }
    if (balls.size() <= most_balls) return balls;
  }
}

/// Nodes that are further apart than a body is thick can't fill it.
void checkThickness(const Scene& scene, const TriangleSurface& organ, double fine) {
  const double thickness = boundingBox(organ).sizes().minCoeff();
  if (!(fine > thickness)) return;
  const bool said = scene.discretization.at_tools > 0;
  const double finest = finestSpacing(signedVolume(organ), surfaceArea(organ), said ? most_fine_nodes : most_nodes);
  throw InputError(
      placeOf(scene, said ? "discretization.spacing" : "tool.radius"),
      (said ? "near the tool nodes are " : "where the cloud follows a tool of this radius nodes are ") + number(fine) +
          " m apart, more than the body is thick, " + number(thickness) + " m",
      finest < thickness
          ? (said ? "give a spacing" : "take a smaller tool, or give [discretization] spacing,") +
                std::string(" between ") + number(finest) + " and " + number(thickness / 2) + " m"
          : "no spacing that can be made, " + number(finest) +
                " m at least, is enough: cut the part that is touched out of the body, or check its scale");
}

/// Of what a scene asks for.
void checkFineCloud(const Scene& scene, const TriangleSurface& organ) {
  const double finest = finestSpacing(signedVolume(organ), surfaceArea(organ), most_fine_nodes),
               asked = scene.discretization.at_tools;
  if (asked == 0 || asked >= finest) return;
  throw InputError(
      placeOf(scene, "discretization.spacing"),
      "a cloud that follows the tool is taken from one with this spacing, " + number(asked) +
          " m, in the whole organ, which is more than " + std::to_string(static_cast<int>(most_fine_nodes)) + " nodes",
      "give " + number(std::ceil(1e5 * finest) / 1e5) + " m or more, or cut the organ to the part that is touched");
}

/// Whether a ball makes nodes of a body denser.
bool reaches(const SpacingField::Refinement& ball, double coarse, const Box3& body) {
  const double farthest = ball.radius + 3 * (coarse - ball.spacing);  // SpacingField's
  return ball.spacing < coarse && body.squaredExteriorDistance(ball.centre) < farthest * farthest;
}

/// Each as fine as its own tool wants, with thin tissue in it; none where the whole of a body is.
/// @param thin    BodyPlaces::thin
/// @param widest  m, BodyPlaces::widest
/// @param coarse  m, of the body
/// @param used    gets for each tool the centre of its ball, or -1
std::vector<SpacingField::Refinement> ballsAt(const Places& places, const PlaceIndex& index,
                                              const std::vector<SpacingField::Refinement>& thin, double widest,
                                              double coarse, const Box3& body, PlaceIndex* used = nullptr) {
  std::vector<SpacingField::Refinement> balls;
  const std::vector<ToolSpec>& tools = places.scene.tools;
  if (used != nullptr) *used = no_place;
  for (std::size_t t = 0; t < tools.size(); ++t) {
    SpacingField::Refinement ball;
    ball.centre = places.centres[static_cast<std::size_t>(index[t])];
    ball.spacing = std::min(
        widest, std::max(places.sizes.fine, widening(places.scene) * fine_radii * resolvedRadius(tools[t].shape)));
    ball.radius = ballRadius(tools[t], ball.spacing);
    const std::size_t before = balls.size();
    if (reaches(ball, coarse, body)) balls.push_back(ball);
    for (const SpacingField::Refinement& narrow : thin)
      if (narrow.spacing < ball.spacing && (narrow.centre - ball.centre).norm() < ball.radius) balls.push_back(narrow);
    if (used != nullptr && balls.size() > before) (*used)[t] = index[t];
  }
  return balls;
}

std::vector<SpacingField::Refinement> ballsAt(const Places& places, const PlaceIndex& index) {
  constexpr double any = std::numeric_limits<double>::infinity();
  return ballsAt(places, index, {}, any, places.sizes.coarse, boundingBox(places.organ.surface()));
}

/// Nodes that any place may have: as many as the first, and those of whole balls with what is around them, twice, where
/// tissue is thin all that there are; no more than the cloud has.
int mostNodes(const Places& places, int of_first) {
  constexpr double safety = 2;
  constexpr int shells = 1000;
  const PlaceIndex any{};
  double nodes = 0;
  for (const BodyPlaces& body : places.body) {
    const double coarse = body.scene.discretization.spacing;
    for (const SpacingField::Refinement& ball :
         ballsAt(places, any, {}, body.widest, coarse, boundingBox(places.organ.surface()))) {
      SpacingField field{coarse, {ball}, {}};
      const double outer = ball.radius + 3 * coarse, width = outer / shells;
      double in_ball = 0;
      for (int k = 0; k < shells; ++k) {
        const double r = (k + 0.5) * width, h = field.at(ball.centre + Vec3(r, 0, 0));
        in_ball += 4 * std::numbers::pi * r * r * width / std::pow(h, 3);
      }
      nodes += std::min(in_ball / volume_per_node, static_cast<double>(body.cloud.nodeCount()));
    }
    double widest_thin = 0;  // m, radius
    for (const SpacingField::Refinement& narrow : body.thin) widest_thin = std::max(widest_thin, narrow.radius);
    for (const ToolSpec& tool : places.scene.tools) {
      if (body.thin.empty()) break;
      const double around = ballRadius(tool, body.widest) + widest_thin + 3 * coarse;  // 3: as SpacingField grows
      std::ptrdiff_t most = 0;
      for (const Vec3& centre : places.centres)
        most = std::max(most, std::count_if(body.cloud.X.begin(), body.cloud.X.end(),
                                            [&](const Vec3& x) { return (x - centre).norm() < around; }));
      nodes += static_cast<double>(most);
    }
  }
  return static_cast<int>(std::min<double>(of_first + safety * nodes, places.nodeCount()));
}

/// A body at a place.
struct BodyPlace {
  Scene scene;            // with its balls
  std::vector<int> node;  // of the body's cloud
  std::string key;        // what its preparation depends on; "": nothing is to be kept
};

void addBalls(const std::vector<SpacingField::Refinement>& balls, Scene& scene) {
  for (const SpacingField::Refinement& ball : balls) {
    RefineSpec refine;
    refine.centre = ball.centre;
    refine.radius = ball.radius;
    refine.spacing = ball.spacing;
    scene.discretization.refine.push_back(refine);
  }
}

/// But for its nodes. @param first  whether it has yet nothing in common with others
BodyPlace bodyAt(const Places& places, std::size_t k, const PlaceIndex& index, bool first) {
  const BodyPlaces& body = places.body[k];
  BodyPlace at{body.scene, {}, {}};
  PlaceIndex used;
  addBalls(ballsAt(places, index, body.thin, body.widest, body.scene.discretization.spacing,
                   boundingBox(body.surface.surface()), &used),
           at.scene);
  if (places.key.empty()) return at;
  at.key = places.key + (first ? "\nfirst place" : "\nplace");
  if (places.body.size() > 1) at.key += " of body " + std::to_string(k);
  for (const int centre : used) at.key += ' ' + std::to_string(centre);
  return at;
}

/// @param memory  or null
Preparation prepareAt(const BodyPlaces& body, const BodyPlace& at, bool first, PlaceMemory::OfBody* memory) {
  Discretization d;
  for (const int i : at.node) {
    d.cloud.X.push_back(body.cloud.X[i]);
    d.cloud.on_surface.push_back(body.cloud.on_surface[i]);
  }
  SurfaceMemory* const surface = memory != nullptr ? &memory->surface : nullptr;
  d.cells = makeBackgroundCells(d.cloud, body.surface, surface);
  fitVolumes(body.scene, body.surface, d, surface);
  if (surface != nullptr) surface->next();
  std::optional<RowMemory> rows;
  if (memory != nullptr) rows.emplace(RowMemory{at.node, memory->rows});
  const Progress silent = [](const std::string&, double) {};
  Preparation made =
      prepare(at.scene, body.surface, std::move(d), silent, first ? nullptr : &body.common, rows ? &*rows : nullptr);
  if (first) made.cloud = body.cloud, made.pair_moment = body.common.pair_moment;
  return made;
}

/// The place from its scene, with what is common to all or, for the first, without.
/// @param kept  preparations that are at hand (body_count), or none
Place place(const Places& places, const PlaceIndex& index, bool first, const PlaceStore& store, PlaceMemory* memory,
            std::vector<std::optional<Preparation>> kept = {}) {
  Place made;
  made.index = index;
  kept.resize(places.body.size());
  if (memory != nullptr) memory->body.resize(places.body.size());
  std::vector<Preparation> prepared;
  int before = 0;  // nodes of the fine clouds
  for (std::size_t k = 0; k < places.body.size(); ++k) {
    const BodyPlaces& body = places.body[k];
    BodyPlace at = bodyAt(places, k, index, first);
    at.node = liveNodes(body.cloud, spacingField(at.scene));
    std::optional<Preparation>& own = kept[k];
    if (!own && !at.key.empty() && store.find) own = store.find(at.key);
    if (!own || own->X.size() != at.node.size()) {
      own = prepareAt(body, at, first, memory != nullptr ? &memory->body[k] : nullptr);
      if (!at.key.empty() && store.keep) store.keep(at.key, *own);
    }
    own->cloud = {};
    for (const int i : at.node) made.node.push_back(before + i);
    before += body.cloud.nodeCount();
    prepared.push_back(std::move(*own));
  }
  Scene scene = places.scene;
  addBalls(ballsAt(places, index), scene);
  made.model = finish(
      scene, places.organ, prepared.size() > 1 ? joinBodies(std::move(prepared)) : std::move(prepared[0]),
      [](const std::string&, double) {}, first ? nullptr : &places.common);
  made.model.scene.discretization.follow = false;  // as a body on its own it stays
  return made;
}

/// Of a state of `nodes` nodes, whose patches may be twice as many, that remembers `history` numbers.
void reserveFor(std::size_t nodes, std::size_t history, State& state) {
  state.relaxation.Z.reserve(history);
  state.u.reserve(nodes);
  state.du.reserve(nodes);
  state.u_low.reserve(nodes);
  state.local_mass.factor.reserve(nodes);
  if (state.live.kernel.patch_bulk.empty()) return;
  state.live.kernel.patch_bulk.reserve(2 * nodes);
  state.live.kernel.patch_shear.reserve(2 * nodes);
}

}  // namespace

FollowSizes followSizes(const Scene& scene, double volume, double area, double thickness) {
  const double body = std::cbrt(volume), finest = finestSpacing(volume, area, most_fine_nodes),
               wanted = std::max(spacingByTools(scene), finest);
  FollowSizes sizes;
  sizes.fine = std::max(fineSpacing(scene), finest);
  sizes.coarse = std::max(
      wanted, std::clamp(coarse_radii * smallestToolRadius(scene), narrowest_of_body * body, widest_of_body * body));
  sizes.coarse = std::min(sizes.coarse, std::max({wanted, finestSpacing(volume, area, most_for_thin), thickness / 2}));
  sizes.coarse = std::max(sizes.fine, widening(scene) * sizes.coarse);
  double ball = std::numeric_limits<double>::infinity();
  for (const ToolSpec& tool : scene.tools) ball = std::min(ball, ballRadius(tool.shape, sizes.fine));
  sizes.stride = std::min(longest_stride, ball / 2);
  return sizes;
}

double fineSpacing(const Scene& scene) { return widening(scene) * spacingByTools(scene); }

double followSpacing(const Scene& scene) { return widening(scene) * coarse_radii * smallestToolRadius(scene); }

int Places::nodeCount() const {
  int count = 0;
  for (const BodyPlaces& each : body) count += each.cloud.nodeCount();
  return count;
}

namespace {

/// The fine cloud of a body that all places are taken from, and up to where their cells are joined.
void makeCloud(const std::function<void(double)>& progress, BodyPlaces& body) {
  Scene fine = body.scene;
  fine.discretization.spacing = body.fine;
  addBalls(body.thin, fine);
  fine.discretization.refine = finerThan(body.fine, fine.discretization.refine);
  // So wide air lies between coarse nodes that would be nearest to each other (NestedCloud's are 0.7 spacings apart).
  const double paired_air = 0.7 * body.scene.discretization.spacing;
  Discretization d = discretizeOnSurface(fine, body.surface, progress, paired_air);
  putInSlices(d);
  body.cloud = nestedOrder(d.cloud, dimensionsOf(fine, body.surface, d), spacingField(fine),
                           pairsAcrossAir(d.cloud, body.surface, paired_air));
  const QuadratureSpec& quadrature = body.scene.discretization.quadrature;
  if (quadrature.cells_per_point > 1 && quadrature.accuracy == 0 && quadrature.points_per_cell == 1)
    body.common.pair_moment = largestPairMoment(
        d.cloud.X, d.cells, cellMaterials(fine, body.surface, d.cloud.X, d.cells), quadrature.cells_per_point);
}

/// The scene as places have it, but for their balls.
Scene withoutBalls(const Scene& as_read, double coarse) {
  Scene scene = as_read;
  scene.discretization.spacing = coarse;
  scene.discretization.refine = finerThan(coarse, as_read.discretization.refine);
  scene.set_up_values.clear();
  return scene;
}

/// Bodies with their surfaces and scenes; the sizes are those of the widest.
void addBodies(const Scene& as_read, const TriangleSurface& organ, Places& places) {
  checkFineCloud(as_read, organ);
  FollowSizes& sizes = places.sizes = followSizes(as_read, signedVolume(organ), surfaceArea(organ));
  sizes.coarse = 0;
  for (TriangleSurface& surface : separated(organ, bodiesOf(organ))) {
    checkThickness(as_read, surface, sizes.fine);
    const Scene own = sceneOf(as_read, surface);
    const SurfaceTree tree(std::move(surface));
    const TriangleSurface& closed = tree.surface();
    const FollowSizes of_body =
        followSizes(as_read, signedVolume(closed), surfaceArea(closed), thicknessOf(tree, thin_share));
    // With no more than a few nodes across, what a body stores says nothing about how far off they are: cubes of 12 mm
    // under a ball of 20 mm had 12 nodes, 0.180 N, and 3 % were expected; with four across it is 0.075 N and 12 %, with
    // six 0.063 N.
    const double across = std::max(std::cbrt(signedVolume(closed)) / least_across,
                                   finestSpacing(signedVolume(closed), surfaceArea(closed), most_fine_nodes));
    const double finest = std::min(sizes.fine, across),
                 coarse = of_body.coarse > sizes.fine ? std::max(finest, of_body.coarse) : finest;
    sizes.coarse = std::max(sizes.coarse, coarse);
    places.body.push_back({withoutBalls(own, coarse), tree, {}, {}, finest, across, {}});
  }
  places.scene = withoutBalls(as_read, sizes.coarse);
}

/// The skin is one for all: no finer below a ball than elsewhere.
void addSkin(const Scene& as_read, Places& places) {
  TriangleSurface all;
  for (BodyPlaces& body : places.body) {
    Scene plain = body.scene;
    plain.discretization.spacing = body.fine;
    plain.discretization.refine = finerThan(body.fine, as_read.discretization.refine);
    TriangleSurface& skin = body.common.skin = refineForContact(plain, body.surface.surface());
    double ball_reach = 0;
    for (const ToolSpec& tool : as_read.tools) ball_reach = std::max(ball_reach, ballRadius(tool, body.fine));
    body.thin = thinTissue(skin, body, ball_reach);
    body.common.gaps = std::make_shared<const SurfaceGaps>(gapsOf(body.scene, skin, body.surface));
    places.common.gaps.push_back(body.common.gaps);
    addSurface(skin, all);
  }
  CommonToPlaces& common = places.common;
  common.finest_spacing = places.sizes.fine;
  for (const BodyPlaces& body : places.body) common.finest_spacing = std::min(common.finest_spacing, body.fine);
  common.skin = skinOf(all);
  SpacingField finest;
  finest.spacing = common.finest_spacing;
  common.bodies = makeSkinBodies(common.skin, places.scene.discretization.spacing, finest);
  common.tools = makeToolSet(places.scene, places.organ, common.skin.surface);
}

}  // namespace

Places makePlaces(const Scene& said, const TriangleSurface& organ, const Progress& progress, const PlaceStore& store) {
  Scene as_read = said;
  const std::vector<RefineSpec> rigid_balls = ballsOfRigidBodies(said, SurfaceTree(organ));
  for (const RefineSpec& ball : rigid_balls) as_read.discretization.refine.push_back(ball);
  const auto report = [&](const char* what, double fraction) {
    if (progress) progress(what, fraction);
  };
  Places places{as_read, SurfaceTree(organ), {}, {}, {}, {}, 0, 0, {}};
  addBodies(as_read, organ, places);
  if (!as_read.set_up_values.empty()) {
    places.key = preparationKey(as_read, organ);
    for (const ToolSpec& tool : as_read.tools)  // what the balls, and so the places, depend on besides
      places.key += "\ntool " + shortest(tool.shape.radius) + ' ' + shortest(touchRadius(tool.shape)) + ' ' +
                    shortest(tool.opening);
    for (const RefineSpec& ball : rigid_balls)
      places.key += "\nball " + shortest(ball.centre.x()) + ' ' + shortest(ball.centre.y()) + ' ' +
                    shortest(ball.centre.z()) + ' ' + shortest(ball.radius);
  }
  addSkin(as_read, places);
  places.centres = centresOn(places.common.skin.surface, places.sizes.stride);
  const PlaceIndex start = startPlace(places);
  const std::size_t count = places.body.size();
  std::vector<std::optional<Preparation>> kept(count);
  std::vector<std::vector<bool>> has(count,
                                     std::vector<bool>(as_read.boundaries.size(), true));  // if kept: then it had
  for (std::size_t k = 0; k < count; ++k) {
    BodyPlaces& body = places.body[k];
    const auto made = [&](double share) {
      report("fine cloud", 0.5 * (static_cast<double>(k) + share) / static_cast<double>(count));
    };
    made(0);
    const std::string key = bodyAt(places, k, start, true).key;
    if (!key.empty() && store.find) kept[k] = store.find(key);
    if (kept[k] && !kept[k]->cloud.X.empty()) {
      body.cloud = std::move(kept[k]->cloud);
      body.common.pair_moment = kept[k]->pair_moment;
    } else {
      kept[k].reset();
      makeCloud(made, body);
      has[k] = keepRegions(body);
    }
  }
  checkBoundaries(as_read, count, [&](std::size_t k, std::size_t b) { return has[k][b]; });

  // One step and one rule for masses: those that suit the place at which the tools start.
  report("time step", 0.6);
  const Model first = place(places, start, true, store, nullptr, std::move(kept)).model;
  if (!places.key.empty())
    for (const int centre : start) places.key += "\nstart " + std::to_string(centre);
  places.scene.dynamics.time_step = first.dt;
  for (BodyPlaces& body : places.body) {
    body.common.row_limit = row_margin * 4 / (first.dt_proven * first.dt_proven);
    // What the step asks for; a place has more mass only where it falls short of that (another search, half its time).
    body.common.critical =
        std::clamp(first.dt / as_read.dynamics.step_safety, least_critical * first.dt_critical, first.dt_critical);
    body.scene.dynamics.time_step = first.dt;
  }
  constexpr double denser = 1.5;  // points that a node may have more than at the first place
  places.most_nodes = mostNodes(places, first.nodeCount());
  places.most_batches = static_cast<std::size_t>(
      denser * static_cast<double>(first.kernel.batch_material.size()) * places.most_nodes / first.nodeCount() + 1);
  report("ready", 1);
  return places;
}

Place makePlace(const Places& places, const PlaceIndex& index, const PlaceStore& store, PlaceMemory* memory) {
  Place made = place(places, index, false, store, memory);
  if (made.model.nodeCount() > places.most_nodes || made.model.kernel.batch_material.size() > places.most_batches)
    throw InputError(places.scene.place,
                     "a place of the cloud that follows the tool has " + std::to_string(made.model.nodeCount()) +
                         " nodes, more than states have room for",
                     "give [discretization] spacing");
  return made;
}

PlaceIndex startPlace(const Places& places) {
  ToolPostures tools;
  const std::vector<ToolSpec>& specs = places.scene.tools;
  for (std::size_t t = 0; t < specs.size(); ++t) tools[t].pose.position = specs[t].position;
  return nextPlace(places, no_place, tools);
}

PlaceIndex placeAt(const Places& places, const Vec3& point) {
  PlaceIndex index = startPlace(places);
  ToolPostures tools;
  tools[0].pose.position = point;
  index[0] = nextPlace(places, no_place, tools)[0];
  return index;
}

std::size_t Places::mostRemembered(const State& state) const {
  return most_batches * static_cast<std::size_t>(state.relaxation.term_count) * state.relaxation.batch_numbers;
}

void reserveForPlaces(const Places& places, State& state) {
  reserveFor(static_cast<std::size_t>(places.most_nodes), places.mostRemembered(state), state);
}

void reserveAs(const State& like, State& state) {
  if (like.u.capacity() > like.u.size()) reserveFor(like.u.capacity(), like.relaxation.Z.capacity(), state);
}

SpacingField wantedSpacing(const Places& places, const PlaceIndex& index) {
  SpacingField wanted = spacingField(places.scene);
  for (const SpacingField::Refinement& ball : ballsAt(places, index)) wanted.refinements.push_back(ball);
  return wanted;
}

PlaceIndex nextPlace(const Places& places, const PlaceIndex& present, const ToolPostures& tools) {
  PlaceIndex next = no_place;
  const std::size_t count = places.scene.tools.size();
  for (std::size_t t = 0; t < count; ++t) {
    const Vec3& at = tools[t].pose.position;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < places.centres.size(); ++c) {
      const double distance = (places.centres[c] - at).norm();
      if (distance < nearest) nearest = distance, next[t] = static_cast<int>(c);
    }
    if (present[t] < 0) continue;
    const double now = (places.centres[static_cast<std::size_t>(present[t])] - at).norm();
    if (!(now > nearest + hysteresis * places.sizes.stride)) next[t] = present[t];
  }
  return next;
}

PlaceIndex placeUnder(const Places& places, ToolPostures tools) {
  for (std::size_t t = 0; t < places.scene.tools.size(); ++t) {
    Pose& pose = tools[t].pose;
    if (!places.organ.inside(pose.position)) continue;
    const auto hit = places.organ.firstHit(pose.position, pose.orientation * Vec3::UnitZ());
    if (hit) pose.position = hit->point;
  }
  return nextPlace(places, no_place, tools);
}

}  // namespace palpate
