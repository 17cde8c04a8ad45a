#include "io/scene_lumps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "base/number_text.h"
#include "discretization/surface/surface_tree.h"
#include "io/load_model.h"
#include "scene/scene_regions.h"

namespace palpate {

namespace {

constexpr double spacing_per_radius = 0.55;  // four nodes across a lump: its stiffness is felt within some percent
constexpr double finest = 0.55;              // of the scene's spacing: finer would cost the rate
constexpr double apart = 0.010;              // m, between two lumps: they are felt one by one
constexpr double facing = 0.4;               // cosine between skin and tool, where the tool still gets to the skin
constexpr int most_draws = 4000;

// 16 to 20 mm, 12 to 16 mm, 10 to 12 mm across. Under the fingertips of the assets (6 and 8 mm) they are felt 1.4 to
// 2.1, 1.3 to 1.7 and 1.2 to 1.4 times as stiff as the tissue beside them (palpate --check-lumps).
constexpr std::array<LumpLevel, 3> levels{{{0.008, 0.010, 0.003, 0.005, 40e3, 50e3},
                                           {0.006, 0.008, 0.003, 0.0045, 40e3, 50e3},
                                           {0.005, 0.006, 0.0025, 0.003, 45e3, 50e3}}};

double youngOf(const Material& m) {
  return 9 * m.bulk_modulus * m.shear_modulus / (3 * m.bulk_modulus + m.shear_modulus);
}

/// 0 <= x < 1, the same with any standard library.
double draw(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

double drawBetween(double low, double high, std::mt19937& random) { return low + (high - low) * draw(random); }

bool held(const Scene& scene, const Vec3& x, double margin, const SurfaceTree& tree) {
  for (const BoundarySpec& boundary : scene.boundaries)
    if (boundary.region.contains(x, margin, -tree.signedDistance(x))) return true;
  return false;
}

struct PlacedLump {
  Vec3 centre;
  double radius, young;
};

/// The next layout of a stream of random numbers: as many lumps as fit below the skin and apart, at most `count`.
std::vector<PlacedLump> drawLayout(const LumpLevel& level, int count, const Scene& scene, const SurfaceTree& tree,
                                   std::mt19937& random) {
  const TriangleSurface& skin = tree.surface();
  std::vector<PlacedLump> placed;
  for (int tries = 0; static_cast<int>(placed.size()) < count && tries < most_draws; ++tries) {
    const auto t = std::min(skin.triangles.size() - 1,
                            static_cast<std::size_t>(draw(random) * static_cast<double>(skin.triangles.size())));
    const double radius = drawBetween(level.least_radius, level.most_radius, random);
    const double top = drawBetween(level.least_top, level.most_top, random);
    const double young = drawBetween(level.least_young, level.most_young, random);
    const auto& [a, b, c] = skin.triangles[t];
    const Vec3 foot = (skin.vertices[a] + skin.vertices[b] + skin.vertices[c]) / 3;
    const Vec3 normal = (skin.vertices[b] - skin.vertices[a]).cross(skin.vertices[c] - skin.vertices[a]).normalized();
    if (!(normal.dot(-scene.tools[0].direction) > facing)) continue;
    const Vec3 centre = foot - (top + radius) * normal;
    if (tree.signedDistance(centre) > -0.9 * (top + radius)) continue;  // nearer to the skin elsewhere
    if (held(scene, centre, 1.5 * radius, tree) || held(scene, foot, 1.5 * radius, tree)) continue;
    const bool free = std::all_of(placed.begin(), placed.end(), [&](const PlacedLump& other) {
      return (other.centre - centre).norm() > other.radius + radius + apart;
    });
    if (free) placed.push_back({centre, radius, young});
  }
  return placed;
}

void placeAtRandom(int count, const LumpDraw& wish, const SourceLocation& place, Scene& scene) {
  const SurfaceTree tree(organSurface(scene));
  std::mt19937 random(wish.seed);
  std::vector<PlacedLump> placed;
  for (int layout = 0; layout < wish.layout; ++layout) {
    placed = drawLayout(lumpLevel(wish.level), count, scene, tree, random);
    if (static_cast<int>(placed.size()) < count)
      throw InputError(place,
                       "only " + std::to_string(placed.size()) + " of " + std::to_string(count) +
                           " lumps fit below the skin that the tool gets to",
                       "ask for fewer, or for another seed or level");
  }
  for (const PlacedLump& lump : placed) addLump(lump.centre, lump.radius, lump.young, place, scene);
}

}  // namespace

const LumpLevel& lumpLevel(int level) { return levels[static_cast<std::size_t>(std::clamp(level, 1, 3) - 1)]; }

void addLump(const Vec3& centre, double radius, double young, const SourceLocation& place, Scene& scene) {
  const Material& tissue = scene.materials.front().material;
  const double around = youngOf(tissue);
  if (!(young > around))
    throw InputError(place, "a lump of " + number(young) + " Pa in tissue of " + number(around) + " Pa",
                     "give it a larger \"young\" than the tissue's");
  MaterialSpec lump;
  const auto lumps = std::count_if(scene.materials.begin(), scene.materials.end(),
                                   [](const MaterialSpec& spec) { return spec.name.starts_with("lump "); });
  lump.name = "lump " + std::to_string(lumps + 1);
  lump.material = stiffened(tissue, young / around);
  lump.everywhere = false;
  lump.region.kind = Region::Kind::Sphere;
  lump.region.point = centre;
  lump.region.radius = radius;
  lump.region.place = lump.place = place;
  scene.materials.push_back(lump);
  RefineSpec refine;
  refine.centre = centre;
  refine.radius = radius;
  refine.spacing = std::max(spacing_per_radius * radius, finest * scene.discretization.spacing);
  refine.place = place;
  if (refine.spacing < scene.discretization.spacing) scene.discretization.refine.push_back(refine);
}

void readLumps(const TomlTable& top, Scene& scene) {
  for (const TomlTable& entry : top.tables("lump", {"lump"})) {
    Vec3 centre = Vec3::Zero();
    double radius = 0, young = 0;
    entry.read("centre", centre);
    entry.read("radius", radius);
    entry.read("young", young);
    addLump(centre, radius, young, entry.place(), scene);
  }
  if (!top.has("lumps")) return;
  const TomlTable table = top.table("lumps", {"lumps"});
  int count = 0;
  LumpDraw wish;
  table.read("count", count);
  table.read("level", wish.level);
  table.read("seed", wish.seed);
  table.read("layout", wish.layout);
  placeAtRandom(count, wish, table.place(), scene);
  scene.lump_draw = wish;
}

}  // namespace palpate
