#include "mtled/matrix/matrix_case.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "contact/tools/tool_list.h"
#include "io/load_model.h"
#include "mtled/frontier/frontier_settings.h"
#include "simulation/build_model.h"
#include "simulation/static_solver.h"
#include "simulation/resolution.h"
#include "simulation/step.h"
#include "simulation/workspace.h"

namespace palpate::tools {
namespace {

constexpr double gap = 0.002;                               // m, between tool and body at the start
constexpr double press_seconds = 0.2, hold_seconds = 0.15;  // to come to rest with the damping below
constexpr int load_steps = 5;
constexpr double tolerance = 1e-4;       // of an equilibrium
constexpr double reference_ratio = 1.4;  // of the two spacings that are extrapolated from
constexpr int most_nodes = 60000;

/// std's distributions differ from library to library; its engines do not.
class Lot {
 public:
  explicit Lot(unsigned seed) : random_(seed * 7919U + 13U) {}
  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_()) / 4294967296.0);
  }
  double logBetween(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
  bool chance(double share) { return between(0, 1) < share; }
  int oneOf(int count) { return std::min(count - 1, static_cast<int>(between(0, count))); }

 private:
  std::mt19937 random_;
};

double poissonOf(Lot& lot) {
  const double group = lot.between(0, 1);
  return group < 0.35 ? lot.between(0, 0.45) : group < 0.8 ? lot.between(0.45, 0.49) : lot.between(0.49, 0.499);
}

/// A law with Young's modulus E and Poisson's ratio nu at rest.
Material material(int law, double E, double nu) {
  const double mu = E / (2 * (1 + nu)), K = E / (3 * (1 - 2 * nu));
  switch (law) {
    case 0:
      return Material::of("mooney-rivlin").set("c10", 0.35 * mu).set("c01", 0.15 * mu).set("D1", 2 / K);
    case 1: {
      const double alpha = -4;
      return Material::ogden(&mu, &alpha, 1, 2 / K, 1000);
    }
    default:
      return Material::neoHookean(E, nu, 1000);
  }
}

BoundarySpec face(double z) {
  BoundarySpec boundary;
  boundary.region.kind = Region::Kind::NearPlane;
  boundary.region.point = Vec3(0, 0, z);
  boundary.region.distance = 1e-6;
  return boundary;
}

void addTool(Lot& lot, double top, MatrixCase& one) {
  constexpr std::array kinds{ToolKind::Sphere, ToolKind::Sphere, ToolKind::FlatCylinder, ToolKind::Capsule,
                             ToolKind::Cone};
  Scene& s = one.scene;
  s.tool = ToolShape::of(kinds[static_cast<std::size_t>(lot.oneOf(kinds.size()))], lot.between(0.004, 0.012));
  s.tool_position = Vec3(lot.between(-0.008, 0.008), lot.between(-0.008, 0.008), top + gap);
  one.pressed = true;
  one.depth = std::min(lot.between(0.3, 0.9) * s.tool.radius, 0.35 * top);
  one.kind = std::string("press ") + toolType(s.tool.kind).name;
}

void addMotion(Lot& lot, double height, MatrixCase& one) {
  BoundarySpec top = face(height);
  top.duration = 1;
  top.curve.kind = LoadCurve::Kind::Linear;
  switch (lot.oneOf(4)) {
    case 0:
      one.kind = "stretch";
      top.translation = Vec3(0, 0, lot.between(0.05, 0.4) * height);
      break;
    case 1:
      one.kind = "compress";
      top.translation = Vec3(0, 0, -lot.between(0.05, 0.25) * height);
      break;
    case 2:
      one.kind = "shear";
      top.translation = Vec3(lot.between(0.1, 0.5) * height, 0, 0);
      break;
    default:
      one.kind = "twist";
      top.angle = lot.between(0.2, 1.2);
  }
  one.scene.boundaries.push_back(top);
  one.scene.tool_position = Vec3(0, 0, height + 1);
}

/// The spacing where the tool presses, or everywhere.
Scene finer(const MatrixCase& one, double fineness) {
  Scene scene = one.scene;
  if (fineness == 1) return scene;
  scene.time_step = 0;
  if (!one.pressed) {
    scaleSpacing(scene, fineness);
    return scene;
  }
  scene.mass_scaling = 0.1;
  const Vec3 touched = scene.tool_position - Vec3(0, 0, gap);
  refineWhere(scene, {touched, 3 * scene.tool.radius}, std::clamp(1.6 * fineness, 0.7, 1.0), fineness);
  return scene;
}

MatrixAnswer pressed(const MatrixCase& one, const Model& model, int threads) {
  MatrixAnswer answer;
  Workspace workspace(model, threads);
  State state = initialState(model);
  workspace.team.wake();
  const double rate = model.scene.rate_hz;
  const auto press = static_cast<int>(press_seconds * rate), ticks = press + static_cast<int>(hold_seconds * rate);
  answer.sound = true;
  StepReport report;
  for (int k = 1; k <= ticks && answer.sound; ++k) {
    const double t = std::min(1.0, static_cast<double>(k) / press), share = t * t * (3 - 2 * t);
    Command command;
    command.tool_target = model.tool_start;
    command.tool_target.position.z() -= gap + share * one.depth;
    report = tick(model, state, command, workspace);
    answer.sound = (report.flags & (kNotFinite | kBlowUp | kInvertedPoints)) == 0;
    answer.value = report.tool_force.norm();
    answer.trust.add(doubtOf(model, report), report.expected_error, report.error_force, k / rate);
  }
  workspace.team.park();
  answer.at_end = doubtOf(model, report);
  addLast(model, state, report, ticks / rate, answer.trust);
  return answer;
}

MatrixAnswer moved(const MatrixCase& one, const Model& model, int threads) {
  MatrixAnswer answer;
  StaticSolver solver(model, threads, tolerance);
  answer.sound = true;
  for (int k = 1; k <= load_steps && answer.sound; ++k) {
    const double time = static_cast<double>(k) / load_steps;
    const Equilibrium e = solver.advanceTo(time);
    answer.sound = e.converged && e.inverted_points == 0;
    answer.at_end = e.doubt;
    const Reaction& top = solver.body().reactions().back();
    answer.value = one.kind == "twist" ? std::abs(top.moment.z()) : top.force.norm();
    answer.trust.add(e.doubt, e.expected_error, answer.value, time);
  }
  return answer;
}

}  // namespace

MatrixCase drawCase(unsigned seed) {
  Lot lot(seed);
  MatrixCase one;
  one.seed = seed;
  Scene& s = one.scene;
  s.name = "matrix " + std::to_string(seed);
  const bool press = lot.chance(0.6), round = press && lot.chance(0.3);
  double height = 0;
  if (round) {
    s.solid = Scene::Solid::Ellipsoid;
    s.upper_half = true;
    s.semi_axes = Vec3(lot.between(0.028, 0.04), lot.between(0.028, 0.04), lot.between(0.022, 0.035));
    height = s.semi_axes.z();
  } else {
    s.solid = Scene::Solid::Box;
    s.size = Vec3(lot.between(0.035, 0.06), lot.between(0.035, 0.06), lot.between(0.015, 0.035));
    height = s.size.z();
  }
  s.damping = 60;
  s.spacing = press ? lot.between(0.0035, 0.008) : std::min(lot.between(0.005, 0.009), height / 3);
  const int law = lot.oneOf(5);
  const double E = lot.logBetween(1000, 20000), nu = poissonOf(lot), contrast = lot.logBetween(1, 100);
  s.materials.assign(1, MaterialSpec{});
  s.materials[0].material = material(law, E, nu);
  s.boundaries.assign(1, face(0));
  if (press)
    addTool(lot, height, one);
  else
    addMotion(lot, height, one);
  const int borders = lot.oneOf(3);
  if (borders == 0) return one;
  MaterialSpec other;
  other.everywhere = false;
  other.material =
      material(law, E * (lot.chance(0.7) ? contrast : 1 / contrast), lot.chance(0.5) ? nu : poissonOf(lot));
  other.region.kind = borders == 1 ? Region::Kind::HalfSpace : Region::Kind::Sphere;
  other.region.point = Vec3(0, 0, lot.between(0.35, 0.65) * height);
  other.region.radius = lot.between(0.2, 0.35) * height;
  s.materials.push_back(other);
  one.kind += borders == 1 ? ", layers" : ", lump";
  return one;
}

MatrixAnswer answerOf(const MatrixCase& one, double fineness, int threads) {
  const Model model = loadModel(finer(one, fineness));
  MatrixAnswer answer;
  if (model.nodeCount() <= most_nodes) answer = one.pressed ? pressed(one, model, threads) : moved(one, model, threads);
  answer.nodes = model.nodeCount();
  return answer;
}

MatrixReference referenceOf(const MatrixCase& one, int threads) {
  // Fine enough for the tool, too: a quarter of its radius.
  const double fine = one.pressed ? std::min(0.45, 0.25 * one.scene.tool.radius / one.scene.spacing) : 0.5;
  const MatrixAnswer coarse = answerOf(one, reference_ratio * fine, threads), best = answerOf(one, fine, threads);
  MatrixReference reference;
  reference.nodes = best.nodes;
  reference.known = coarse.sound && best.sound && best.at_end <= Doubt::Resolution;
  const double lacking = (best.value - coarse.value) / (reference_ratio * reference_ratio - 1);
  reference.value = best.value + lacking;
  reference.uncertainty = std::abs(lacking);
  return reference;
}

}  // namespace palpate::tools
