#pragma once

#include <functional>

#include "batch/batch_body.h"
#include "mechanics/dynamic_relaxation.h"

namespace palpate {

/// Where a static solution stands after one load step.
struct Equilibrium {
  double time = 0;           // s, of the load curves
  int iterations = 0;        // of this load step, failed attempts included
  double error = 0;          // m, estimated distance of the displacement parameters from equilibrium
  double largest = 0;        // m, largest displacement parameter
  bool converged = false;    // error was below the tolerance for 20 iterations in a row
  bool interrupted = false;  // the state is that of the last equilibrium
  bool diverged = false;     // no step was small enough; the state is that of the last equilibrium
  double min_J = 1;
  int worst_point = -1;  // with min J
  int inverted_points = 0;
  Doubt doubt = Doubt::None;
  double strain_energy = 0;        // J
  double expected_error = 0;       // of the forces, as a share (expected_error.h)
  Vec3 tool_force = Vec3::Zero();  // N, on the first tool
  ToolLoads loads;                 // of all tools, without torques
  RigidLoads rigid;
};

/// Throws InputError where a scene has no static solution of its own: nothing but rigid bodies holds the organ, along
/// which it may lie anywhere, or they have friction, which depends on the way there.
void requireUniqueEquilibrium(const Scene& scene);

/// Follows the equilibria of a model under imposed motions and a tool by dynamic relaxation, with fictitious masses
/// that give all nodes the same stable step (paper section 2.3). Times are those of the load curves; there is no
/// inertia.
///
/// The stable step is taken from the largest eigenvalue of the tangent at each equilibrium, so that it follows
/// the stiffening under compression. An iteration that blows up all the same is taken back and repeated with half
/// the step and twice as gentle a load. On rigid bodies (RigidLayer) it comes to rest several times in a load step,
/// the layer being brought up to date in between, until nothing is more than rigid_accuracy from contact.
class StaticSolver {
 public:
  /// @param tolerance  of the displacement, as a share of the largest that there was so far; what double's rounding
  ///                   leaves (1e-13 of the body's size) is always good enough
  /// Throws what requireUniqueEquilibrium does.
  StaticSolver(const Model& model, int threads, double tolerance);

  /// Called every few iterations with the load step's iterations so far; false interrupts.
  using Watch = std::function<bool(int iterations)>;

  /// Moves the load from where it is to `time`, then relaxes.
  /// @param tools  where they are at `time`; without, there are none
  Equilibrium advanceTo(double time, const ToolsAt& tools = {}, const Watch& watch = {});

  /// As BatchBody::setMaterials, from the next load step on.
  void setMaterials(const std::vector<Material>& materials);

  const BatchBody& body() const { return body_; }
  double time() const { return time_; }
  /// Goes on from a state that was saved. @param largest  m, largestSoFar() then
  void resume(double time, const AlignedVector<Double4>& u, const ToolsAt& tools, double largest = 0);
  double largestSoFar() const { return largest_so_far_; }

  static constexpr int max_iterations = 20000;    // of one load step
  static constexpr double rigid_accuracy = 1e-5;  // m, a tenth of what is promised

 private:
  enum class Outcome { Converged, Exhausted, Interrupted, BlownUp };
  Outcome relax(double time, const ToolsAt& tools, int ramp, const Watch& watch, Equilibrium& equilibrium);
  void restore(const AlignedVector<Double4>& u, const ToolsAt& tools);
  void updateStep();
  void observeFrequency();

  const Model& model_;
  double tolerance_;
  std::vector<double> mass_;  // fictitious, kg
  RigidLayer rigid_;
  BatchBody body_;
  DynamicRelaxation relaxation_;
  double time_ = 0;
  double size_ = 0;            // m, of the body
  double largest_so_far_ = 0;  // m, displacement parameter
  double before_ = -1;         // J, strain energy when nothing touched last; < 0: not known
  double caution_ = 1;         // extra share of the stable step after a blow-up
  AlignedVector<Double4> u_reference_, f_reference_, probe_u_, probe_f_;
};

}  // namespace palpate
