#include "mtled/verify/verification_case.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "base/interrupt.h"
#include "io/load_model.h"
#include "mtled/verify/cases/cases.h"
#include "setup/body_points.h"
#include "setup/build_model.h"

namespace palpate::tools {

const std::vector<VerificationCase>& verificationCases() {
  static const std::vector<VerificationCase> cases{
      {"approximation", "modified moving least squares where the classical fail; rates of convergence",
       approximationCase},
      {"cube", "unconstrained compression of a cube, Table 1", cubeCase},
      {"box_extension", "extension of a sheep brain sample, Table 2", boxExtensionCase},
      {"box_compression", "its compression by 20 %, Table 3", boxCompressionCase},
      {"half_ellipsoid", "brain indentation by 5 mm (section 3.3, on a stand-in)", halfEllipsoidCase},
      {"gel_cylinder", "Sylgard cylinder pressed to a quarter of its height (section 4)", gelCylinderCase},
      {"locking", "pressure of a nearly incompressible sample, Fig. 7", lockingCase},
      {"modes", "whether one point a cell leaves a mode without energy", modesCase},
      {"torsion", "twisting a cylinder, Rivlin's closed form", torsionCase},
      {"brain_shift", "from a scan to the shifted scan, on a phantom (section 5)", brainShiftCase},
      {"thick_sphere", "a thick sphere under pressure from inside, Green and Zerna's closed form", thickSphereCase},
      {"cook", "Cook's panel, shear on a tapered cantilever", cookCase},
      {"flexure", "bending a block into a ring, Rivlin's closed form", flexureCase},
  };
  return cases;
}

void apply(const Variant& variant, Scene& scene) {
  scene.discretization.formulation = Formulation{};
  if (variant.consistent_gradients && variant.node_patch_volume) return;
  scene.discretization.formulation = Formulation::paper();
  scene.discretization.formulation.consistent_gradients = variant.consistent_gradients;
  scene.discretization.formulation.node_patches = variant.node_patch_volume;
  if (variant.node_patch_volume) scene.discretization.formulation.own_bulk = Formulation{}.own_bulk;
}

CaseContext partOf(const CaseContext& context, double begin, double all, double width) {
  CaseContext part = context;
  part.progress = [whole = context.progress, begin, all, width](double fraction, const std::string& what) {
    whole((begin + width * fraction) / all, what);
  };
  return part;
}

std::vector<Variant> variantsFor(const CaseContext& context, bool fine) {
  if (context.quick) return {variants[3]};
  if (fine) return {variants[0], variants[3]};
  return {std::begin(variants), std::end(variants)};
}

Scene caseScene(double young, double poisson) {
  Scene scene;
  scene.materials.emplace_back();
  scene.materials[0].material.set("young", young);
  scene.materials[0].material.set("poisson", poisson);
  scene.tools[0].shape.radius = 0.01;  // a case that has no tool needs a skin no finer than for this
  scene.tools[0].position = Vec3(0, 0, 1);
  return scene;
}

AlignedVector<Float4> StaticSolution::uForPictures() const {
  AlignedVector<Float4> result;
  for (const auto& a : u()) result.push_back(toFloat4(toVec3(a)));
  return result;
}

std::vector<Vec3> StaticSolution::uAsVectors() const {
  std::vector<Vec3> result;
  for (const auto& a : u()) result.push_back(toVec3(a));
  return result;
}

std::vector<Vec3> StaticSolution::at(const std::vector<Vec3>& X) const { return fieldAt(shapeAt(*model, X), u()); }

StaticSolution solveCase(const Scene& scene, const std::vector<double>& times, const CaseContext& context,
                         double tolerance, const StaticSolution* start_from, const TriangleSurface* organ) {
  StaticSolution s;
  context.progress(0, "set-up");
  s.model = std::make_unique<Model>(organ ? buildModel(scene, *organ) : loadModel(scene));
  const auto start = std::chrono::steady_clock::now();
  s.solver = std::make_unique<StaticSolver>(*s.model, context.threads, tolerance);
  if (start_from) s.solver->resume(start_from->solver->time(), start_from->u(), {});
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto watch = [&](int iterations) {
      const double within = 1 - std::exp(-iterations / 400.0);
      context.progress((static_cast<double>(k) + within) / static_cast<double>(times.size()),
                       std::to_string(s.model->nodeCount()) + " nodes");
      return !interrupted();
    };
    s.steps.push_back(s.solver->advanceTo(times[k], {}, watch));
    if (s.steps.back().interrupted) throw std::runtime_error("interrupted");
    if (!s.steps.back().converged) break;
    s.reactions.push_back(s.solver->body().reactions());
  }
  s.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return s;
}

std::vector<double> evenTimes(int n) {
  std::vector<double> times;
  for (int k = 1; k <= n; ++k) times.push_back(static_cast<double>(k) / n);
  return times;
}

void addFigure(const CaseContext& context, const std::string& file, const std::string& caption, const Figure& figure,
               CaseResult& result) {
  context.pictures->write(context.folder + "/" + file, figure);
  result.figures.push_back({file, caption});
}

void addFigure(const CaseContext& context, const std::string& file, const std::string& caption, const Histogram& figure,
               CaseResult& result) {
  context.pictures->write(context.folder + "/" + file, figure);
  result.figures.push_back({file, caption});
}

void addBodyPicture(const CaseContext& context, const std::string& file, const std::string& caption,
                    const BodyPicture& picture, const StaticSolution& solution, CaseResult& result,
                    const CutPlane* cut) {
  context.pictures->write(context.folder + "/" + file, picture, *solution.model, solution.uForPictures(), cut);
  result.figures.push_back({file, caption});
}

Vec3 nrmse(const std::vector<Vec3>& computed, const std::vector<Vec3>& reference) {
  Vec3 sum = Vec3::Zero(), low = reference.front(), high = low;
  for (std::size_t k = 0; k < reference.size(); ++k) {
    sum += (computed[k] - reference[k]).cwiseAbs2();
    low = low.cwiseMin(reference[k]);
    high = high.cwiseMax(reference[k]);
  }
  return (sum / static_cast<double>(reference.size())).cwiseSqrt().cwiseQuotient(high - low);
}

double interpolated(const std::vector<double>& at, const std::vector<double>& value, double x) {
  const auto after = std::lower_bound(at.begin(), at.end(), x);
  if (after == at.end() || (after == at.begin() && x < at.front())) return NAN;
  const auto k = static_cast<std::size_t>(after - at.begin());
  if (k == 0) return value.front();
  const double s = (x - at[k - 1]) / (at[k] - at[k - 1]);
  return value[k - 1] + s * (value[k] - value[k - 1]);
}

}  // namespace palpate::tools
