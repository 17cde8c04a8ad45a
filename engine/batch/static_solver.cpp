#include "batch/static_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/float4.h"
#include "mechanics/critical_time_step.h"
#include "mechanics/lanczos.h"
#include "step/resolution.h"
#include "step/rigid_stop.h"
#include "step/trust.h"

namespace palpate {
namespace {

/// Of the largest stable step: what is left is for the stiffening within one load step.
constexpr double step_safety = 0.8;

/// Of the body's size: an error that rounding leaves. Where nothing is loaded, or a tool only just touches, the largest
/// displacement is no more than that itself, and no share of it can be reached.
constexpr double rounding_error = 1e-13;

/// Of the body's size: increments below what a coordinate of it is rounded to, a few times over, are no motion. Where a
/// tool only just touches, gaps are differences of such coordinates, and contact goes on at this level for ever.
constexpr double coordinate_rounding = 4 * std::numeric_limits<double>::epsilon();

}  // namespace

void requireUniqueEquilibrium(const Scene& scene) {
  if (scene.boundaries.empty())
    throw InputError(
        scene.rigid.empty() ? scene.place : scene.rigid.front().place,
        "nothing but rigid bodies holds the organ, along which it is free to slide: a static solution has "
        "no one place for it",
        "add [[fixed]], of some components at least, or let it come to rest in time: mode = \"transient\"");
  for (const RigidSpec& body : scene.rigid)
    if (body.friction > 0)
      throw InputError(body.place,
                       "the friction of the rigid body " + inQuotes(body.name) +
                           " depends on the way that led to a static solution, which has none",
                       "leave friction out, or give mode = \"transient\"");
}

StaticSolver::StaticSolver(const Model& model, int threads, double tolerance)
    : model_(model),
      tolerance_(tolerance),
      mass_(
          gershgorinRows(model.point_shape, model.point_volume, model.point_material, model.materials, model.X.size())),
      rigid_(model.rigid, model.skin, mass_),
      body_(model, mass_, threads),
      relaxation_(1.0),
      size_(boxOf(model.X).diagonal().norm()),
      probe_u_(model.X.size()),
      probe_f_(model.X.size()) {
  requireUniqueEquilibrium(model.scene);
  body_.meetRigidBodiesBy(rigid_);
  updateStep();
}

void StaticSolver::setMaterials(const std::vector<Material>& materials) {
  body_.setMaterials(materials);
  updateStep();
}

void StaticSolver::resume(double time, const AlignedVector<Double4>& u, const ToolsAt& tools, double largest) {
  largest_so_far_ = largest;
  time_ = time;
  restore(u, tools);
  updateStep();
}

/// At rest at a displacement. @param tools  where they are, if there are any
void StaticSolver::restore(const AlignedVector<Double4>& u, const ToolsAt& tools) {
  body_.restore(u, AlignedVector<Double4>(u.size()));
  rigid_.moveTo(time_);
  rigid_.restart(u);
  if (tools) body_.placeTools(tools);
}

/// h = 2 / omega_max of the tangent at the present state, by differences of forces in double.
void StaticSolver::updateStep() {
  constexpr int iterations = 25;
  constexpr double accuracy = 0.02;
  const double reach = 1e-7 * size_;  // of the differences: rounding 1e-9, curvature below 1e-5
  body_.forces(body_.u, body_.f);
  const auto apply = [&](const Eigen::VectorXd& x, Eigen::VectorXd& y) {
    double largest = 0;
    for (std::size_t i = 0; i < mass_.size(); ++i) {
      const double w = std::sqrt(body_.inverseMass()[i]);
      for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(w * x[static_cast<Eigen::Index>(3 * i) + c]));
    }
    const double scale = reach / largest;
    for (std::size_t i = 0; i < mass_.size(); ++i) {
      const double w = std::sqrt(body_.inverseMass()[i]);
      probe_u_[i] = body_.u[i];
      for (int c = 0; c < 3; ++c) (&probe_u_[i].x)[c] += scale * w * x[static_cast<Eigen::Index>(3 * i) + c];
    }
    body_.forces(probe_u_, probe_f_);
    for (std::size_t i = 0; i < mass_.size(); ++i) {
      const double w = std::sqrt(body_.inverseMass()[i]);
      for (int c = 0; c < 3; ++c)
        y[static_cast<Eigen::Index>(3 * i) + c] = -w * ((&probe_f_[i].x)[c] - (&body_.f[i].x)[c]) / scale;
    }
  };
  const auto largest = largestEigenvalue(static_cast<Eigen::Index>(3 * mass_.size()), apply, iterations, accuracy);
  relaxation_.setStep(caution_ * step_safety * 2 / std::sqrt(largest.value + largest.residual + rigid_.highest()));
}

void StaticSolver::observeFrequency() {
  double work = 0, inertia = 0;
  for (std::size_t i = 0; i < mass_.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      if (model_.imposed[i] & (1u << c)) continue;
      const double way = (&body_.u[i].x)[c] - (&body_.du[i].x)[c] - (&u_reference_[i].x)[c];  // f is that of u - du
      work -= way * ((&body_.f[i].x)[c] - (&f_reference_[i].x)[c]);
      inertia += way * way * mass_[i];
    }
  relaxation_.observe(work, inertia);
}

StaticSolver::Outcome StaticSolver::relax(double time, const ToolsAt& tools, int ramp, const Watch& watch,
                                          Equilibrium& equilibrium) {
  constexpr int calm_needed = 20;  // iterations below the tolerance in a row
  constexpr int reference_interval = 200;
  constexpr int watch_interval = 25;
  constexpr int rigid_interval = 10;  // of their planes
  const double from = time_;
  const ToolsAt tools_from = body_.tools();
  int calm = 0;
  for (int k = 1; k <= max_iterations; ++k) {
    const double s = std::min(1.0, static_cast<double>(k) / ramp);
    const double share = s * s * s * (10 + s * (-15 + 6 * s));
    if (tools) body_.moveTools(s < 1 ? between(tools_from, tools, share) : tools);
    const double now = from + share * (time - from);
    rigid_.moveTo(now);
    if (k % rigid_interval == 0) rigid_.follow(body_.u);
    const auto report = body_.advance(relaxation_.alpha(), relaxation_.beta(), now);
    ++equilibrium.iterations;
    if (!report.finite || report.max_increment > 0.1 * size_) return Outcome::BlownUp;
    equilibrium.min_J = report.min_J;
    equilibrium.worst_point = report.worst_point;
    equilibrium.inverted_points = report.inverted_points;
    equilibrium.doubt = report.doubt;
    equilibrium.strain_energy = report.strain_energy;
    equilibrium.tool_force = report.tool_force;
    equilibrium.loads = report.loads;
    equilibrium.rigid = report.contact.rigid;
    if (k % reference_interval == 1) {
      u_reference_ = body_.u;
      for (std::size_t i = 0; i < u_reference_.size(); ++i)
        store(u_reference_[i], load(body_.u[i]) - load(body_.du[i]));
      f_reference_ = body_.f;
    } else {
      observeFrequency();
    }
    equilibrium.error = relaxation_.remaining(report.max_increment);
    if (k > ramp) {
      double largest = 0;
      if (k % watch_interval == 0 || calm > 0 || k == ramp + 1) {
        for (const auto& a : body_.u) largest = std::max(largest, toVec3(a).squaredNorm());
        equilibrium.largest = std::sqrt(largest);
        largest_so_far_ = std::max(largest_so_far_, equilibrium.largest);
      }
      const bool at_rest = equilibrium.error <= std::max(tolerance_ * largest_so_far_, rounding_error * size_) ||
                           report.max_increment <= coordinate_rounding * size_;
      calm = at_rest ? calm + 1 : 0;
      if (calm >= calm_needed) {
        if (rigid_.empty() || rigid_.update(body_.u) <= rigid_accuracy) return Outcome::Converged;
        calm = 0;
      }
    }
    if (watch && k % watch_interval == 0 && !watch(equilibrium.iterations)) return Outcome::Interrupted;
  }
  return Outcome::Exhausted;
}

Equilibrium StaticSolver::advanceTo(double time, const ToolsAt& wanted, const Watch& watch) {
  constexpr int attempts = 6;
  Equilibrium equilibrium;
  equilibrium.time = time;
  const AlignedVector<Double4> u_before = body_.u;
  const ToolsAt tools = stoppedByRigid(model_, body_.tools(), wanted, time);
  ToolsAt tools_before = body_.tools();
  tools_before.count = tools.count;
  const double largest_before = largest_so_far_;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    // The load comes on within a few times what it takes the slowest mode to follow.
    const int ramp = std::clamp(static_cast<int>(2 / (1 - relaxation_.convergenceRate())), 50, 2000) << attempt;
    const Outcome outcome = relax(time, tools, ramp, watch, equilibrium);
    if (outcome == Outcome::Interrupted) {  // back to where it was at rest
      equilibrium.interrupted = true;
      restore(u_before, tools_before);
      largest_so_far_ = largest_before;
      return equilibrium;
    }
    if (outcome != Outcome::BlownUp) {
      equilibrium.converged = outcome == Outcome::Converged;
      PressList presses(model_, equilibrium.loads, equilibrium.rigid);
      presses.findTouches(model_, time, body_.u);
      equilibrium.expected_error =
          expectedError(model_, model_.materials, body_.u, equilibrium.strain_energy, presses, tools.posture, before_);
      equilibrium.expected_error = std::hypot(equilibrium.expected_error, body_.rimShare(equilibrium.loads));
      if (presses.count == 0) before_ = equilibrium.strain_energy;
      if (equilibrium.expected_error > TrustLimits::expected_error)
        equilibrium.doubt = std::max(equilibrium.doubt, Doubt::Resolution);
      equilibrium.doubt = std::max(equilibrium.doubt, body_.measureDepth(time, equilibrium.rigid));
      time_ = time;
      updateStep();
      return equilibrium;
    }
    restore(u_before, tools_before);
    largest_so_far_ = largest_before;
    caution_ *= 0.5;
    updateStep();
  }
  equilibrium.diverged = true;
  return equilibrium;
}

}  // namespace palpate
