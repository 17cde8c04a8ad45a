// Cells of tools/mtled/atlas/atlas_cells.h: how far a body may be deformed, and of what it may be made.
#include <cmath>

#include "base/number_text.h"
#include "io/load_model.h"
#include "mtled/atlas/atlas_block.h"
#include "mtled/atlas/atlas_cells.h"
#include "mtled/report/case_result.h"
#include "mtled/verify/verification_case.h"

namespace palpate::tools {
namespace {

using When = AtlasCell::When;

constexpr double young = 3000;

AtlasMeasure againstClosedForm(const Scene& scene, BlockFaces faces, double poisson, double stretch, double bound) {
  const Model model = loadModel(scene);
  const AtlasRun run = drive(model, blockDrive());
  const double force = blockForce(faces, young, poisson, stretch, scene.organs[0].size.x() * scene.organs[0].size.y());
  return compare(run, "force / closed form", run.reaction[1].force.z(), force, bound);
}

AtlasMeasure uniform(BlockFaces faces, double poisson, double stretch, double safety = 0.6) {
  Scene scene = blockScene(faces, young, poisson, stretch);
  scene.dynamics.step_safety = safety;
  return againstClosedForm(scene, faces, poisson, stretch, 0.02);
}

/// Force on the face that moves in equilibrium, in double, N; NaN where none is found.
double equilibriumForce(const Scene& scene) {
  CaseContext context;
  context.progress = [](double, const std::string&) {};
  const StaticSolution solution = solveCase(scene, {scene.boundaries[1].duration}, context, 1e-3);
  const bool solved = !solution.steps.empty() && solution.steps.back().converged;
  return solved ? solution.reactions.back()[1].force.z() : NAN;
}

/// Both ends held: no closed form, so the same model's equilibrium in double.
AtlasMeasure bonded(double poisson, double stretch) {
  Scene scene = blockScene(BlockFaces::Bonded, young, poisson, stretch);
  scene.dynamics.step_safety = 0.6;
  const AtlasRun run = drive(loadModel(scene), blockDrive());
  if (run.lost()) return run.measure;
  return compare(run, "force / equilibrium", run.reaction[1].force.z(), equilibriumForce(scene), 0.02);
}

/// Both ends held, beside a cloud of half the spacing in equilibrium, in double.
AtlasMeasure againstFiner(double poisson, double stretch) {
  Scene scene = blockScene(BlockFaces::Bonded, young, poisson, stretch);
  const AtlasRun run = drive(loadModel(scene), blockDrive());
  if (run.lost()) return run.measure;
  scene.discretization.spacing /= 1.7;
  return compare(run, "force / finer cloud", run.reaction[1].force.z(), equilibriumForce(scene), 0.1);
}

/// Confined and pressed until the pressure is a multiple of the shear modulus.
AtlasMeasure pressure(double over_shear_modulus, double cells_per_point = 1, bool held = false) {
  constexpr double nu = 0.499, mu = young / (2 * (1 + nu)), K = young / (3 * (1 - 2 * nu));
  const double stretch = 1 - over_shear_modulus * mu / K;
  Scene scene = blockScene(BlockFaces::Confined, young, nu, stretch);
  scene.dynamics.step_safety = 0.6;
  scene.discretization.quadrature.cells_per_point = cells_per_point;
  scene.discretization.formulation.cell_volume = held;
  return againstClosedForm(scene, BlockFaces::Confined, nu, stretch, 0.02);
}

AtlasMeasure torsion(double degrees) {
  constexpr double R = 0.01, H = 0.02, mu = 1000, nu = 0.49;
  const double angle = degrees * M_PI / 180, psi = angle / H;
  Scene scene = caseScene(2 * mu * (1 + nu), nu);
  scene.name = "atlas torsion";
  scene.organs[0].solid = OrganSpec::Solid::Cylinder;
  scene.organs[0].radius = R;
  scene.organs[0].height = H;
  scene.discretization.spacing = 2.4e-3;
  scene.tools[0].shape.radius = 2.4e-3;  // a finer polygon for the round: the moment goes with R^4
  scene.discretization.boundary_method = DiscretizationSpec::BoundaryMethod::Ebciem;
  scene.dynamics.damping = 60;
  scene.boundaries = {planeBoundary("base", Vec3::Zero(), Vec3::UnitZ()),
                      planeBoundary("top", Vec3(0, 0, H), Vec3::UnitZ())};
  scene.boundaries[1].angle = angle;
  scene.boundaries[1].duration = 0.5;
  const AtlasRun run = drive(loadModel(scene), blockDrive());
  return compare(run, "moment / Rivlin", run.reaction[1].moment.z(), M_PI / 2 * mu * psi * std::pow(R, 4), 0.06);
}

Region below(double z) {
  Region region;
  region.point = Vec3(0, 0, z);
  return region;
}

/// Two layers of stiffness 1 and `contrast`, each of which is stretched uniformly: one on the other in a confined
/// block,
/// or side by side with sides free, where the lateral stretch of both is the same.
AtlasMeasure stiffness(double contrast, bool parallel) {
  const double nu = 0.45, stretch = 0.95;
  const BlockFaces faces = parallel ? BlockFaces::Free : BlockFaces::Confined;
  Scene scene = blockScene(faces, young, nu, stretch);
  const double H = scene.organs[0].size.z(), area = scene.organs[0].size.x() * scene.organs[0].size.y();
  MaterialSpec other = scene.materials[0];
  other.material.set("young", young * contrast);
  other.everywhere = false;
  if (parallel)
    other.region.normal = Vec3::UnitX();  // x <= 0
  else
    other.region = below(H / 2);
  scene.materials.push_back(other);
  const AtlasRun run = drive(loadModel(scene), blockDrive());
  const auto force = [&](double E, double l) { return blockForce(faces, E, nu, l, area); };
  double truth = 0;
  if (parallel) {
    truth = (force(young, stretch) + force(young * contrast, stretch)) / 2;
  } else {
    double low = 2 * stretch - 1, high = 1;  // stretch of the soft half; that of the stiff one follows
    for (int k = 0; k < 100; ++k) {
      const double soft = (low + high) / 2;
      (force(young, soft) > force(young * contrast, 2 * stretch - soft) ? high : low) = soft;
      truth = force(young, soft);
    }
  }
  return compare(run, "force / closed form", run.reaction[1].force.z(), truth, parallel ? 0.1 : 0.25);
}

AtlasMeasure density(double contrast) {
  const double nu = 0.45, stretch = 0.9;
  Scene scene = blockScene(BlockFaces::Free, young, nu, stretch);
  MaterialSpec light = scene.materials[0];
  light.material.density /= contrast;
  light.everywhere = false;
  light.region = below(scene.organs[0].size.z() / 2);
  scene.materials.push_back(light);
  return againstClosedForm(scene, BlockFaces::Free, nu, stretch, 0.02);
}

}  // namespace

void addSolidCells(std::vector<AtlasAxis>& axes, std::vector<AtlasCell>& cells) {
  axes.push_back({"nu", "Poisson's ratio, sides free",
                  "Block of 30 mm pressed by 20 % between plates without friction; force beside the closed form."});
  for (const double nu : {0.3, 0.4, 0.45, 0.49, 0.499, 0.4999})
    cells.push_back({"nu", format("%g", nu), nu == 0.3 || nu == 0.49 || nu == 0.499 ? When::Always : When::Full,
                     [=] { return uniform(BlockFaces::Free, nu, 0.8); }});
  axes.push_back({"nu-confined", "Poisson's ratio, sides confined",
                  "The same block confined at its sides, pressed by 1.5 %; force beside the closed form."});
  for (const double nu : {0.3, 0.45, 0.49, 0.499, 0.4999})
    cells.push_back({"nu-confined", format("%g", nu), nu == 0.49 ? When::Always : When::Full,
                     [=] { return uniform(BlockFaces::Confined, nu, 0.985); }});
  axes.push_back({"nu-bonded", "Poisson's ratio, ends bonded",
                  "The same block with bonded ends pressed by 10 %; force beside the equilibrium in double of a cloud "
                  "with five times the nodes."});
  for (const double nu : {0.3, 0.45, 0.49, 0.499, 0.4999})
    cells.push_back(
        {"nu-bonded", format("%g", nu), nu == 0.45 ? When::Always : When::Full, [=] { return againstFiner(nu, 0.9); }});
  axes.push_back({"pressure", "Pressure / shear modulus",
                  "The same block confined at its sides, nu 0.499, pressed until its pressure is this multiple of its "
                  "shear modulus; force beside the closed form."});
  for (const double p : {1.0, 2.0, 3.0, 4.0, 4.5, 5.0, 10.0})
    cells.push_back(
        {"pressure", format("%g", p), p == 2 || p == 5 ? When::Always : When::Full, [=] { return pressure(p); }});
  for (const double p : {2.0, 3.0, 4.0})  // where cells share points
    cells.push_back(
        {"pressure", format("%g pairs", p), p == 4 ? When::Always : When::Full, [=] { return pressure(p, 2); }});
  for (const double p : {5.0, 10.0, 20.0, 40.0})  // with cell_volume
    cells.push_back(
        {"pressure", format("%g cells", p), p == 40 ? When::Always : When::Full, [=] { return pressure(p, 1, true); }});
  for (const double p : {10.0, 40.0})
    cells.push_back({"pressure", format("%g pairs, cells", p), When::Full, [=] { return pressure(p, 2, true); }});
  axes.push_back({"compression", "Compression, %",
                  "Block between plates without friction, nu 0.49; force beside the closed form."});
  for (const double percent : {20, 40, 50, 60, 70, 80})
    cells.push_back({"compression", format("%g", percent), percent == 40 || percent == 80 ? When::Always : When::Full,
                     [=] { return uniform(BlockFaces::Free, 0.49, 1 - percent / 100); }});
  cells.push_back(
      {"compression", "80 small step", When::Full, [] { return uniform(BlockFaces::Free, 0.49, 0.2, 0.1); }});
  axes.push_back({"compression-bonded", "Compression, ends bonded, %",
                  "The same with bonded ends; force beside the same motion in double."});
  for (const double percent : {20, 40, 60, 80})
    cells.push_back({"compression-bonded", format("%g", percent),
                     percent == 20 || percent == 80 ? When::Always : When::Full,
                     [=] { return bonded(0.49, 1 - percent / 100); }});
  axes.push_back(
      {"stretch", "Stretch", "Block between plates without friction, nu 0.49; force beside the closed form."});
  for (const double factor : {1.2, 1.5, 2.0, 3.0})
    cells.push_back({"stretch", format("x%g", factor), factor == 1.5 || factor == 3 ? When::Always : When::Full,
                     [=] { return uniform(BlockFaces::Free, 0.49, factor); }});
  axes.push_back(
      {"stretch-bonded", "Stretch, ends bonded", "The same with bonded ends; force beside the same motion in double."});
  for (const double factor : {1.2, 1.5, 2.0, 3.0})
    cells.push_back({"stretch-bonded", format("x%g", factor), factor == 3 ? When::Always : When::Full,
                     [=] { return bonded(0.49, factor); }});
  axes.push_back({"torsion", "Torsion, degrees",
                  "Cylinder, radius 10 mm, height 20 mm, ends bonded, nu 0.49; moment beside Rivlin's closed form."});
  for (const double degrees : {30, 60, 90, 120, 150, 180})
    cells.push_back({"torsion", format("%g", degrees), degrees == 60 || degrees == 180 ? When::Always : When::Full,
                     [=] { return torsion(degrees); }});
  axes.push_back(
      {"stiffness-parallel", "Stiffness contrast, side by side",
       "Block between plates, one half stiffer, pressed by 5 % along the border; force beside the closed form."});
  for (const double contrast : {10, 100, 1000})
    cells.push_back({"stiffness-parallel", format("1:%g", contrast), contrast == 100 ? When::Always : When::Full,
                     [=] { return stiffness(contrast, true); }});
  axes.push_back({"stiffness-series", "Stiffness contrast, layers",
                  "The same confined at its sides and pressed across the border; force beside the closed form, of "
                  "which the width of a support across the border may take up to 25 %."});
  for (const double contrast : {10, 100, 1000})
    cells.push_back({"stiffness-series", format("1:%g", contrast), contrast == 100 ? When::Always : When::Full,
                     [=] { return stiffness(contrast, false); }});
  axes.push_back({"density", "Density contrast",
                  "Block between plates, one half lighter, pressed by 10 %; force beside the closed form."});
  for (const double contrast : {10, 100, 1000})
    cells.push_back({"density", format("1:%g", contrast), contrast == 100 ? When::Always : When::Full,
                     [=] { return density(contrast); }});
}

}  // namespace palpate::tools
