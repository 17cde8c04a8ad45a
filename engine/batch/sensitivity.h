#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "batch/static_solver.h"

namespace palpate {

/// A number of a scene's material: a parameter of its law by its scene key, or an entry of one that is a list.
struct MaterialNumber {
  int material = 0;  // in the scene's order: a region's, or a membership class's
  std::string name;
  int entry = 0;
};

/// A linear functional of an equilibrium: the component along `direction` of
struct EquilibriumQuantity {
  enum class Kind {
    ToolForce,     // the force on the tool, N
    RegionForce,   // what a region holds the tissue with, N
    Displacement,  // the displacement of a material point, m
  };
  Kind kind = Kind::ToolForce;
  int region = 0;                           // in the order of EssentialNodes::motions
  std::vector<std::pair<int, double>> row;  // node, N_i at the point
  Vec3 direction = Vec3::UnitZ();
};

/// Equilibria of a body under a frictionless tool, in double to rounding, and their derivatives with respect to
/// materials by the adjoint (Bendsoe & Sigmund, Topology Optimization, 2003, app. 5.1). With internal forces F, the
/// contact layer's f_c, the weight w, and tractions t that hold the imposed nodes,
///
///   r(u, p) - Phi^T t = 0,   Phi u = u_bar       r = F(u, p) - f_c(u, p) - w
///   K l + Phi^T m = dq/du,   Phi l = -dq/dt      K = dr/du, where it is symmetric
///   dq/dp = (dq/dp)_u - l . (dr/dp)_u
///
/// one linear solution for each quantity q, whatever the number of parameters p; (d/dp)_u are differences of forces at
/// one u, which cost no solution. Where tissue is pressed to its limit of pressure, K is not quite symmetric
/// (cell_volume.h); then one linear solution for each p, K du/dp = -dr/dp. What is differentiated is the answer at rest
/// for a tool that stays where it is, with the points in contact held to be those that are; one that just touches has a
/// left and a right derivative. Held as loaded: the share of pressure that
/// node patches average, and the weight. Materials that relax are those of after a long time.
///
/// Equilibria are those of StaticSolver's laws, polished by Newton's method; linear systems by projected conjugate
/// gradients (Gould, Hribar, Nocedal, SIAM J. Sci. Comput. 23, 1376 (2001)), K v by differences of forces, which are
/// central for derivatives.
/// Contact is that of the skin's vertices: points of faces that are stretched by more than half take no part, as their
/// weights change with the displacement. The force is less for that: by up to 2 % where the cloud is coarse, by 6 %
/// beside a ball that is pressed in by almost its diameter (lacking()).
/// Test: simulation/sensitivity_test.cpp (central differences)
class EquilibriumSensitivity {
 public:
  /// Called now and then; false ends what goes on by a std::runtime_error "interrupted".
  using Watch = std::function<bool()>;

  /// @param accuracy  of the displacement, as a share of the largest; for derivatives to 1e-6 rounding
  /// Throws InputError for what this is not for: several tools or jaws, friction, several bodies, rigid ones, EBCIEM.
  EquilibriumSensitivity(const Model& model, int threads, Watch watch = {}, double accuracy = 1e-11);

  /// Others in place of the loaded ones, for what is solved next; densities have no effect.
  /// @param of_scene  (scene material count) by the laws that they were loaded with
  void setMaterials(const std::vector<Material>& of_scene);
  const std::vector<Material>& materials() const { return of_scene_; }

  /// The equilibrium with the tool at a pose, come to along its axis from outside; or without a tool.
  /// @param time  s, of the load curves of imposed motions
  /// Throws std::runtime_error where there is none, or the tool stands where it can't come.
  void settle(const std::optional<Pose>& tool, double time = 0);

  /// The same from a displacement that is near, of the same tool and time: by Newton's method alone.
  /// @param lacking  as it was there
  void settleFrom(const AlignedVector<Double4>& u, const std::optional<Pose>& tool, double lacking = 0);

  /// That equilibrium itself, which settle() or settleFrom() had come to.
  void takeFrom(const AlignedVector<Double4>& u, const std::optional<Pose>& tool, double lacking = 0);

  const AlignedVector<Double4>& u() const { return u_; }  // (node_count) m
  double valueOf(const EquilibriumQuantity& q);

  /// dq/dp for each of the numbers, in q's unit over the number's. Throws InputError where there is no such number or
  /// it is at an end of its range, std::runtime_error where the equilibrium is not stable.
  std::vector<double> derivatives(const EquilibriumQuantity& q, const std::vector<MaterialNumber>& numbers);

  /// How far off the tool's force is because the scene's cloud is no finer (expected_error.h), and for lacking(), as a
  /// share.
  double expectedError();

  /// By how much the tool's force differed from that with the points of stretched faces when settle() came to it last,
  /// as a share.
  double lacking() const { return lacking_; }

  /// Throws InputError where the scene has no such number.
  void check(const MaterialNumber& number) const;

  int solutionCount() const { return solution_count_; }  // linear ones so far, Newton's steps included

 private:
  using Field = AlignedVector<Double4>;
  struct ContactPoint {
    int vertex;
    double stiffness;  // N/m
    bool active;
  };

  std::vector<Material> modelMaterials();
  void findContact();
  Vec3 placeOf(const ContactPoint& point, const Field& u) const;
  Vec3 contactForce(const ContactPoint& point, const Vec3& x) const;
  Vec3 toolForce() const;
  void unbalanced(const Field& u, Field& f);
  enum class Difference { Forward, Central };
  void multiply(const Field& v, Field& Kv, Difference difference);
  double precondition(Field& r, Field& g);
  void solve(Field r, Field& x, double tolerance, Difference difference);
  bool isSymmetric();
  Vec3 differentiateForce(const MaterialNumber& number, Field& slope);
  void polish();

  const Model& model_;
  const Watch watch_;
  const double accuracy_;
  Scene scene_;  // with the materials in force
  std::vector<Material> of_scene_;
  const int threads_;
  std::vector<double> mass_;  // fictitious, kg
  BatchBody body_;
  ToolProfile profile_;
  double size_;  // m, of the body
  std::optional<Pose> tool_;
  std::vector<ContactPoint> contact_;
  double lacking_ = 0;
  Field u_, probe_, f_plus_, f_minus_;  // f_minus_: of u_ where differences are forward
  int solution_count_ = 0;
};

}  // namespace palpate
