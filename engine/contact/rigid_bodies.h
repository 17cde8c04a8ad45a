#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/types.h"
#include "contact/contact_row.h"
#include "contact/rigid_shape.h"
#include "contact/skin.h"
#include "discretization/nodes/spacing_field.h"
#include "discretization/surface/surface_tree.h"
#include "mechanics/essential_nodes.h"

namespace palpate {

inline constexpr int max_rigid_bodies = 8;  // of a scene

/// A body that the skin can't enter, which stands still or moves on a path: a table, a plate, a skull.
struct RigidBody {
  std::string name;
  RigidShape shape;                       // at rest
  double friction = 0;                    // Coulomb
  BoundaryMotion motion;                  // a rotation, then a translation
  bool encloses = false;                  // the organ lies inside it: tools pass it
  std::vector<std::array<Vec3, 2>> edge;  // m, sharp ones, of what is narrower than the skin's points are apart
  int begin = 0, end = 0;                 // its points in RigidBodies

  /// Where it is at `time` (s): x = pose.toWorld(X). Real-time.
  Pose at(double time) const;
};

/// The rigid bodies as the skin meets them, constant. The skin touches each at some of its vertices, half the nodes'
/// spacing there apart: the displacement between them is no finer. (Half of the spacing elsewhere, and a ball with
/// finer nodes below went 0.6 mm through a plate between its points, a third too soft.)
struct RigidBodies {
  std::vector<RigidBody> body;  // (body_count)
  // The points that may touch, body by body.
  std::vector<int> vertex;        // (point_count) skin vertices, ascending for each body
  std::vector<float> area;        // (point_count) m^2 of the skin that each stands for
  std::vector<float> correction;  // (point_count) m, added to a grid's gap: exact at rest where the organ made it
  double row_sum = 1;             // largest sum_i |N_i| of a point: so much further than nodes it goes at most

  bool empty() const { return body.empty(); }
  bool moves() const;
  int pointCount() const { return static_cast<int>(vertex.size()); }
};

/// The gap of a surface that is closed but for openings.
struct SurfaceSide {
  bool inside = false;                      // where the organ is
  double clearance = 0;                     // m, between the surface and what the skin touches: more room inside, less
                                            // outside
  std::function<bool(const Vec3&)> open{};  // whether there is no surface at a place (m); none: it is closed
};
/// @param spacing  m, of the nodes: its grid has a cell of a third of it, or less where the surface is round
RigidShape surfaceShape(const SurfaceTree& surface, const SurfaceSide& side, double spacing);

/// Adds a body, of which only the points are missing.
/// @param of_body      (vertex_count) SkinBodies::body
/// @param spacing      m, of the nodes
/// @param gap_at_rest  m, of all the skin, where the skin made the surface
void addRigidBody(RigidBody body, const SkinModel& skin, const std::vector<int>& of_body, const SpacingField& spacing,
                  std::optional<double> gap_at_rest, RigidBodies& bodies);

/// A point before a body.
struct RigidRow : ContactRow {
  int point = 0;
  int body = 0;
};

/// What contact with rigid bodies remembers from step to step, and scratch.
struct RigidState {
  AlignedVector<Float4> force;  // (point_count) on the tissue, N
  std::vector<Vec3f> normal;    // (point_count) unit, body's frame, where the point is; 0: it does not touch

  // Scratch: the points that the step looks at, and when others have to be looked for. The result does not depend on
  // them.
  std::vector<RigidRow> row;        // (point_count)
  std::vector<int> near;            // (point_count)
  int near_count = -1;              // < 0: they are to be looked for
  AlignedVector<Float4> near_u;     // (node_count) m, displacement that they were looked for at
  double near_time = 0;             // s, likewise
  Vec3 near_centre = Vec3::Zero();  // m, of a ball that held all points then
  double near_radius = 0;           // m

  /// `force` is another now.
  void lookAgain() { near_count = -1; }
};
RigidState makeRigidState(const RigidBodies& bodies, int node_count);

/// What a body did in one step.
struct RigidLoad {
  Vec3 force = Vec3::Zero();                   // N, on the tissue
  double max_penetration = 0;                  // m
  int count = 0;                               // points that carry force
  double expected_error = 0, error_force = 0;  // as ToolLoad's, where it is round (pressesOf)
};
using RigidLoads = std::array<RigidLoad, max_rigid_bodies>;  // the first body_count count

/// Every `stride`-th vertex of the skin from `first` on, whether it carries force or not: how deep it is in a body that
/// does not enclose the organ. And of every `stride`-th face how far the edges of a narrow body are behind it.
/// @param time      s, where the bodies are
/// @param farthest  m behind a face, beyond which an edge is not looked at: it may be on the organ's other side
/// @param loads     max_penetration of each grows to that
/// Real-time: no allocation, no lock, no throw; an interpolation for each vertex, for narrow bodies six more.
void addDeepest(const RigidBodies& bodies, const SkinModel& skin, const Float4* u, double time, double farthest,
                int first, int stride, RigidLoads& loads);

}  // namespace palpate
