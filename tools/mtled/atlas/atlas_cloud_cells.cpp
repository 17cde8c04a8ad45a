// Cells of tools/mtled/atlas/atlas_cells.h: nodes that lie badly.
#include <algorithm>
#include <cmath>
#include <random>

#include "io/load_model.h"
#include "mtled/atlas/atlas_block.h"
#include "mtled/atlas/atlas_cells.h"
#include "setup/build_model.h"

namespace palpate::tools {
namespace {

using When = AtlasCell::When;

constexpr double young = 3000, poisson = 0.45, stretch = 0.9;

/// Presses a block that has these nodes and cells by 10 % between plates.
/// @param area_share  of the scene's cross-section that the nodes fill
AtlasMeasure press(const Scene& scene, const std::function<void(NodeCloud&)>& disturb, double area_share = 1) {
  BuildOptions options;
  options.disturb = [&](Discretization& d, const SurfaceTree& tree) {
    disturb(d.cloud);
    d.cells = makeBackgroundCells(d.cloud, tree);
  };
  const Model model = buildModel(scene, organSurface(scene), options);
  const AtlasRun run = drive(model, blockDrive());
  return compare(run, "force / closed form", run.reaction[1].force.z(),
                 blockForce(BlockFaces::Free, young, poisson, stretch,
                            area_share * scene.organs[0].size.x() * scene.organs[0].size.y()),
                 0.02);
}

/// Of ten nodes inside, each gets another one beside it.
AtlasMeasure pairs(double distance_over_spacing) {
  const Scene scene = blockScene(BlockFaces::Free, young, poisson, stretch);
  return press(scene, [&](NodeCloud& cloud) {
    const std::size_t count = cloud.X.size();
    int left = 10;
    for (std::size_t i = 0; i < count && left > 0; ++i) {
      if (cloud.on_surface[i]) continue;
      cloud.X.push_back(cloud.X[i] + distance_over_spacing * scene.discretization.spacing * Vec3(0.6, 0.48, 0.64));
      cloud.on_surface.push_back(0);
      --left;
    }
  });
}

/// All nodes moved onto one of the sides, or as near to it as `thickness` of the width.
AtlasMeasure flattened(double thickness) {
  const Scene scene = blockScene(BlockFaces::Free, young, poisson, stretch);
  return press(
      scene,
      [&](NodeCloud& cloud) {
        const double side = -scene.organs[0].size.y() / 2;
        for (Vec3& X : cloud.X) X.y() = side + thickness * (X.y() - side);
      },
      thickness);
}

/// Nodes on a grid: eight on a sphere in each cube, so that the cells' Delaunay division is of slivers.
AtlasMeasure grid(double jitter) {
  const Scene scene = blockScene(BlockFaces::Free, young, poisson, stretch);
  return press(scene, [&](NodeCloud& cloud) {
    constexpr int n = 6;
    cloud = {};
    std::mt19937 random(1);
    const auto shake = [&] { return jitter * scene.organs[0].size.x() / n * (random() / 4294967296.0 - 0.5); };
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j)
        for (int k = 0; k <= n; ++k) {
          const auto at = [&](int m) { return static_cast<double>(m) / n; };
          Vec3 X((at(i) - 0.5) * scene.organs[0].size.x(), (at(j) - 0.5) * scene.organs[0].size.y(),
                 at(k) * scene.organs[0].size.z());
          const bool outer = i % n == 0 || j % n == 0 || k % n == 0;
          if (!outer) X += Vec3(shake(), shake(), shake());
          cloud.X.push_back(X);
          cloud.on_surface.push_back(outer);
        }
  });
}

/// A sheet of so many node distances in thickness, stretched in its plane by 10 %.
AtlasMeasure sheet(double thickness_over_spacing) {
  Scene scene = blockScene(BlockFaces::Free, young, poisson, 1.1);
  const double spacing = scene.discretization.spacing;
  scene.organs[0].size.y() = thickness_over_spacing * spacing;
  for (auto& boundary : scene.boundaries)
    if (std::abs(boundary.region.normal.y()) > 0.5) boundary.region.point.y() = -scene.organs[0].size.y() / 2;
  const Model model = loadModel(scene);
  const AtlasRun run = drive(model, blockDrive());
  return compare(run, "force / closed form", run.reaction[1].force.z(),
                 blockForce(BlockFaces::Free, young, poisson, 1.1, scene.organs[0].size.x() * scene.organs[0].size.y()),
                 0.02);
}

}  // namespace

void addCloudCells(std::vector<AtlasAxis>& axes, std::vector<AtlasCell>& cells) {
  axes.push_back({"pairs", "Near-coincident nodes, distance / spacing",
                  "Block pressed by 10 % between plates, ten nodes inside doubled at this distance; force beside the "
                  "closed form."});
  const std::pair<const char*, double> distances[] = {
      {"1e-1", 1e-1}, {"1e-2", 1e-2}, {"1e-4", 1e-4}, {"1e-8", 1e-8}, {"0", 0}};
  for (const auto& [name, distance] : distances)
    cells.push_back({"pairs", name, distance == 1e-2 || distance == 0 ? When::Always : When::Full,
                     [distance = distance] { return pairs(distance); }});
  axes.push_back({"flat", "Flat clouds, thickness / width",
                  "The same block with its nodes moved together towards one of its sides."});
  const std::pair<const char*, double> thicknesses[] = {{"1e-1", 1e-1}, {"1e-2", 1e-2}, {"1e-6", 1e-6}, {"0", 0}};
  for (const auto& [name, thickness] : thicknesses)
    cells.push_back({"flat", name, thickness == 0 ? When::Always : When::Full,
                     [thickness = thickness] { return flattened(thickness); }});
  axes.push_back(
      {"slivers", "Slivers: grid, shaken by / spacing",
       "The same block with its nodes on a cubic grid, those inside shaken: the grid's cells are degenerate."});
  const std::pair<const char*, double> shakes[] = {{"0", 0}, {"1e-6", 1e-6}, {"1e-2", 1e-2}, {"0.2", 0.2}};
  for (const auto& [name, shake] : shakes)
    cells.push_back(
        {"slivers", name, shake == 1e-6 ? When::Always : When::Full, [shake = shake] { return grid(shake); }});
  axes.push_back({"sheet", "Sheet, thickness / spacing",
                  "Sheet of 30 x 30 mm stretched by 10 % in its plane; force beside the closed form."});
  for (const auto& [name, thickness] :
       {std::pair("3", 3.0), std::pair("2", 2.0), std::pair("1", 1.01), std::pair("0.5", 0.5)})
    cells.push_back({"sheet", name, thickness < 1.5 ? When::Always : When::Full,
                     [thickness = thickness] { return sheet(thickness); }});
}

}  // namespace palpate::tools
