#include <algorithm>
#include <cmath>

#include "batch/static_solver.h"
#include "discretization/surface/surface_tree.h"
#include "io/load_model.h"
#include "mtled/matrix/matrix_case.h"
#include "mtled/run/plane_boundary.h"
#include "mtled/run/scene_spacing.h"
#include "setup/discretize.h"
#include "step/resolution.h"
#include "step/step.h"
#include "step/workspace.h"

namespace palpate::tools {
namespace {

constexpr double press_seconds = 0.2, hold_seconds = 0.15;  // of a loop, to come to rest with its damping
constexpr int load_steps = 2;
// Of an equilibrium. Below a tool some contacts come and go for ever, by some 1e-4 of the way.
constexpr double tolerance = 1e-4, tolerance_of_known = 1e-5, tolerance_of_press = 1e-3;
// Of a load step: who is not at rest then has no answer. Contact that goes on for ever is found out early.
constexpr int most_iterations = 3000, most_iterations_of_known = 12000;
constexpr double finest = 0.4, reference_ratio = 1.4;  // of the two clouds that are extrapolated from

/// The scene at a fineness, with a boundary for each node that goes to a place of its own.
Scene sceneAt(const MatrixCase& one, double fineness) {
  Scene scene = one.scene;
  scaleSpacing(scene, fineness);
  if (one.placed.empty()) return scene;
  const SurfaceTree organ(organSurface(scene));
  const Discretization cloud = discretize(scene, organ, [](double) {});
  for (const PlacedSurface& placed : one.placed)
    for (std::size_t i = 0; i < cloud.cloud.X.size(); ++i) {
      const Vec3& X = cloud.cloud.X[i];
      if (!cloud.cloud.on_surface[i] || !placed.on(X)) continue;
      BoundarySpec& b = scene.boundaries.emplace_back();
      b.region.kind = Region::Kind::Sphere;
      b.region.point = X;
      b.region.radius = 1e-8;
      b.surface_only = true;
      std::copy(std::begin(placed.component), std::end(placed.component), std::begin(b.component));
      b.axis_point = placed.axis_point;
      b.angle = placed.angle;
      b.translation =
          placed.to(X) - placed.axis_point - Eigen::AngleAxisd(placed.angle, Vec3::UnitZ()) * (X - placed.axis_point);
      if (b.translation.isZero(0) && b.angle == 0) continue;
      beEven(b);
    }
  return scene;
}

double pressedBy(const MatrixCase& one, const Model& model, double share) {
  return model.tools.first().first_contact_travel + share * one.depth;
}

void pressInLoop(const MatrixCase& one, const Model& model, int threads, MatrixAnswer& answer) {
  Workspace workspace(model, threads);
  State state = initialState(model);
  workspace.team.wake();
  const double rate = model.scene.dynamics.rate_hz;
  const auto press = static_cast<int>(press_seconds * rate), ticks = press + static_cast<int>(hold_seconds * rate);
  StepReport report;
  for (int k = 1; k <= ticks && answer.sound; ++k) {
    const double t = std::min(1.0, static_cast<double>(k) / press);
    Command command;
    command.tools[0].pose = model.tools.first().start.pose;
    command.tools[0].pose.position.z() -= pressedBy(one, model, t * t * (3 - 2 * t));
    report = tick(model, state, command, workspace);
    answer.sound = (report.flags & (kNotFinite | kBlowUp | kInvertedPoints)) == 0;
    answer.value = report.tool_force.norm();
    answer.trust.add(doubtOf(model, report), report.expected_error, report.error_force, k / rate);
  }
  workspace.team.park();
  answer.at_end = doubtOf(model, report);
  addLast(model, state, report, ticks / rate, answer.trust);
  answer.expected_at_end = answer.trust.expectedError();
}

/// Of imposed nodes. The traction of node k acts where V says (EssentialBoundaryOf): at the node, or beside it where it
/// is integrated over facets.
double leveredForce(const MatrixCase& one, const Model& model, const BatchBody& body) {
  std::vector<Vec3> force(model.X.size(), Vec3::Zero());
  body.addNodeReactions(force);
  double sum = 0;
  for (const EssentialBoundary::Set& set : model.boundary.sets) {
    const auto& V = set.v.value.empty() ? set.phi : set.v;
    for (std::size_t k = 0; k < set.node.size(); ++k) {
      const auto i = static_cast<std::size_t>(set.node[k]);
      Vec3 X = Vec3::Zero(), u = Vec3::Zero();
      double share = 0;
      for (auto e = static_cast<std::size_t>(V.begin[k]); e < static_cast<std::size_t>(V.begin[k + 1]); ++e) {
        const auto j = static_cast<std::size_t>(V.column[e]);
        share += V.value[e];
        X += static_cast<double>(V.value[e]) * model.X[j];
        u += static_cast<double>(V.value[e]) * toVec3(body.u[j]);
      }
      const Vec3 lever = one.lever(model.X[i], X / share, (X + u) / share);
      for (Eigen::Index c = 0; c < 3; ++c)
        sum += static_cast<double>(set.mask[static_cast<std::size_t>(c)]) * force[i][c] * lever[c];
    }
  }
  return sum;
}

void follow(const MatrixCase& one, const Model& model, int threads, MatrixAnswer& answer) {
  StaticSolver solver(model, threads,
                      one.hasClosedForm() ? tolerance_of_known
                      : one.pressed       ? tolerance_of_press
                                          : tolerance);
  const int most = one.hasClosedForm() ? most_iterations_of_known : most_iterations;
  for (int k = 1; k <= load_steps && answer.sound; ++k) {
    const double time = static_cast<double>(k) / load_steps;
    ToolsAt tools;
    if (one.pressed) {
      Pose pose = model.tools.first().start.pose;
      pose.position.z() -= pressedBy(one, model, time);
      tools = ToolsAt(pose);
    }
    const Equilibrium e = solver.advanceTo(time, tools, [=](int iterations) { return iterations < most; });
    answer.sound = e.converged && e.inverted_points == 0;
    answer.at_end = e.doubt;
    answer.expected_at_end = e.expected_error;
    answer.value = one.pressed ? e.tool_force.norm() : leveredForce(one, model, solver.body());
    // The number is that of the end. On the way faces that are placed pass through other shapes: a block that is bent
    // is stretched, too, by a moment that may be larger, and its expected error would be taken for that of the end.
    if (k == load_steps)
      answer.trust.add(e.doubt, e.expected_error, std::abs(answer.value), time);
    else if (e.doubt != Doubt::Resolution)
      answer.trust.add(e.doubt, 0, 0, time);
  }
}

}  // namespace

MatrixAnswer answerOf(const MatrixCase& one, double fineness, bool looped, int threads) {
  const Model model = loadModel(sceneAt(one, fineness));
  MatrixAnswer answer;
  answer.sound = true;
  answer.nodes = model.nodeCount();
  if (looped)
    pressInLoop(one, model, threads, answer);
  else
    follow(one, model, threads, answer);
  return answer;
}

MatrixReference referenceOf(const MatrixCase& one, int threads) {
  MatrixReference reference;
  reference.value = one.known;
  reference.known = true;
  if (one.hasClosedForm()) return reference;
  const MatrixAnswer coarse = answerOf(one, reference_ratio * finest, false, threads),
                     best = answerOf(one, finest, false, threads);
  reference.nodes = best.nodes;
  reference.known = coarse.sound && best.sound && best.at_end <= Doubt::Resolution;
  const double lacking = (best.value - coarse.value) / (reference_ratio * reference_ratio - 1);
  reference.value = best.value + lacking;
  reference.uncertainty = std::abs(lacking);
  return reference;
}

}  // namespace palpate::tools
