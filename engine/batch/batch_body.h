#pragma once

#include "base/spin_team.h"
#include "batch/batch_tools.h"
#include "contact/contact.h"
#include "contact/rigid_layer.h"
#include "mechanics/internal_forces.h"
#include "model/model.h"
#include "model/report.h"
#include "step/holding_friction.h"

namespace palpate {

/// A model that moves in double: what the batch solvers advance. The same kernel, boundary and contact as the
/// real-time step's; the contact itself works in float on the way of the skin, which is all that it reads.
class BatchBody {
 public:
  /// @param mass     kg (node_count); the model's own, or fictitious ones for a static solution
  /// @param threads  the result does not depend on it
  BatchBody(const Model& model, const std::vector<double>& mass, int threads);

  struct Report {
    double min_J = 1;
    int worst_point = -1;
    int inverted_points = 0;
    double max_increment = 0;  // m
    bool finite = true;
    double step_share = 0;           // of the step that the model was made for
    Doubt doubt = Doubt::None;       // of what step time and energy don't tell
    double strain_energy = 0;        // J, at the beginning of the step
    Vec3 tool_force = Vec3::Zero();  // N, on the first tool
    ToolLoads loads;                 // of all tools, without torques
    OrganForces organ_force{};       // N, of the other organs on each
    ContactForces contact;           // of skins and rigid bodies
  };

  /// One step of paper eqs. 12 and 21-25, the boundaries then being where they are at `time`, and loads what they are:
  ///   f = -F_int(u);  du = beta du + alpha M^-1 (f + loads);  contact;  du += P (u_bar - Phi (u + du));  u += du
  /// @param own_beta  (node_count) in place of beta; null: one for all
  Report advance(double alpha, double beta, double time, const double* own_beta = nullptr);

  /// Where the tools are from the next step on; they go there from where they were in that one step.
  void moveTools(const ToolsAt& tools) { tools_.move(tools); }
  /// The tools stand there already: no way leads to it.
  void placeTools(const ToolsAt& tools) { tools_.place(tools); }
  /// Tools that were never moved are not there, but have a place: their start.
  const ToolsAt& tools() const { return tools_.at(); }
  /// rimShare (rim_force.h) of the last step's loads.
  double rimShare(const ToolLoads& loads) const;

  /// The rigid bodies' forces are this layer's from now on, and part of forces(): for static solutions.
  void meetRigidBodiesBy(RigidLayer& layer) { layer_ = layer.empty() ? nullptr : &layer; }

  /// Materials that relax keep the history of steps of h s from now on. Without, they are in equilibrium.
  void keepHistory(double h);
  const AlignedVector<double>& history() const { return history_.Z; }
  PointHistory pointHistory() const;
  /// Of the last step (HoldingFriction).
  const AlignedVector<float>& holdingFriction() const { return kernel_scratch_.cell_volume.friction; }

  /// Goes on from a saved state. @param history  of history(); empty: nothing has been before
  void restore(const AlignedVector<Double4>& displacement, const AlignedVector<Double4>& increment,
               const AlignedVector<double>& history = {});

  /// Materials in place of the loaded ones, by the same laws (model.materials.size()), with the contact layer that goes
  /// with them. What the model had them for otherwise stays: masses, weights, what node patches average.
  void setMaterials(const std::vector<Material>& materials);
  /// How stiff the contact layer before a vertex of the skin is, as a share of what it was loaded as.
  double layerShare(int vertex) const {
    return layer_share_.empty() ? 1 : layer_share_[static_cast<std::size_t>(below_[static_cast<std::size_t>(vertex)])];
  }

  /// increment += M^-1 Phi^T A^-1 (0 - Phi increment): then it moves no imposed node. reactions() are those of a body
  /// whose forces are M increment.
  void project(AlignedVector<Double4>& increment) { moveRegion(0, Vec3::Zero(), increment); }
  /// The same, with one region moved by `shift` and the others held.
  void moveRegion(int region, const Vec3& shift, AlignedVector<Double4>& increment);

  /// How deep the skin is in rigid bodies, at all of its vertices, where they are at `time` (s); into max_penetration.
  /// @return whether that is too deep to be trusted
  Doubt measureDepth(double time, RigidLoads& loads);

  /// Internal forces at a displacement and those of the rigid bodies' layer, N; `force` and the report's J. Of
  /// materials that relax, after a long time.
  ForceReport forces(const AlignedVector<Double4>& at, AlignedVector<Double4>& force);

  const Model& model() const { return model_; }
  const std::vector<Reaction>& reactions() const { return boundary_scratch_.reaction; }  // of the last step
  /// The sum of each surface load's forces in the last step, N (load_count).
  std::vector<Vec3> loadForces() const { return palpate::loadForces(model_.surface_loads, load_scratch_); }
  /// Adds the force at each imposed node in the last step, N (node_count).
  void addNodeReactions(std::vector<Vec3>& force) const {
    palpate::addNodeReactions(boundary_, boundary_scratch_, alpha_, force);
  }
  const AlignedVector<double>& inverseMass() const { return inverse_mass_; }

  AlignedVector<Double4> u;   // (node_count) displacement parameters, m
  AlignedVector<Double4> du;  // (node_count) last increment, m
  AlignedVector<Double4> f;   // (node_count) internal forces of the last step, N

 private:
  ForceReport forces(const AlignedVector<Double4>& at, AlignedVector<Double4>& force,
                     RelaxationHistoryOf<double>* history);
  bool hasContact() const;
  void findFriction();
  void contact(double alpha, double time, Report& report);
  void addLoads(double alpha, double time);
  Doubt doubt(const ForceReport& forces, const Report& report) const;

  const Model& model_;
  SpinTeam team_;
  KernelLayoutOf<double> kernel_;
  KernelMaterialsOf<double> materials_;
  SkinModel skin_;                   // with other layers, where materials were set
  std::vector<int> below_;           // (vertex_count) material below a vertex, likewise
  std::vector<double> layer_share_;  // (material_count) likewise
  KernelScratchOf<double> kernel_scratch_;
  RelaxationHistoryOf<double> history_;
  double history_step_ = 0;  // s; 0: no history is kept
  EssentialBoundaryOf<double> boundary_;
  BoundaryScratchOf<double> boundary_scratch_;
  AlignedVector<double> inverse_mass_;
  AlignedVector<float> inverse_mass_float_;
  double alpha_ = 1;  // of the last step, s^2
  SurfaceLoadScratchOf<double> load_scratch_;
  BatchTools tools_;
  HoldingFriction holding_friction_;
  SkinContactState skins_;
  SkinContactScratch skins_scratch_;
  RigidState rigid_;
  RigidLayer* layer_ = nullptr;  // in place of rigid_
  AlignedVector<Float4> u_float_, du_float_, du_before_;
  AlignedVector<Double4> du_held_;
};

/// The displacement field at rows of a ShapeTable or SkinModel, m: sum_i N_i u_i.  (row_count)
template <class Rows>
std::vector<Vec3> fieldAt(const Rows& rows, const AlignedVector<Double4>& u) {
  std::vector<Vec3> field(rows.begin.size() - 1);
  for (std::size_t r = 0; r < field.size(); ++r) field[r] = fieldAt(rows, r, [&](int i) { return toVec3(u[i]); });
  return field;
}

}  // namespace palpate
