#pragma once

#include <vector>

#include "approximation/shape_table.h"
#include "base/types.h"
#include "contact/tool.h"
#include "discretization/triangle_surface.h"

namespace palpate {

/// The skin as the contact reads it: constant. Vertices are not nodes; vertex v
/// stands at X_v + sum_i N_i(X_v) u_i.
struct SkinModel {
  TriangleSurface surface;                 // reference configuration, m
  std::vector<double> area;                // (vertex_count) a third of the adjacent triangles, m^2
  // Row r of the shape table in the layout of the real-time loop.
  std::vector<int> begin;                  // (vertex_count + 1)
  std::vector<int> node;                   // (entry_count)
  AlignedVector<float> N;                  // (entry_count)
  // Clusters for the broad phase, made by buildSkinModel.
  std::vector<int> cluster_begin;          // (cluster_count + 1)
  std::vector<int> cluster_vertex;         // (vertex_count) vertices, grouped by cluster
  std::vector<int> cluster_representative; // (cluster_count) a vertex near the cluster's centre
  std::vector<float> cluster_radius;       // (cluster_count) m, reference configuration
  double bulk_stiffness = 0;               // Pa/m, pressure per penetration of the contact layer
};

/// Forces between tool and tissue in one step, and what the solver remembers.
/// Sized by contactCapacity at load; nothing here allocates later.
struct ContactState {
  int count = 0;                      // vertices in or near contact
  std::vector<int> vertex;            // (capacity) skin vertex
  std::vector<Float4> force;          // (capacity) on the tissue at that vertex, N; warm start of the next step
  bool overflow = false;              // more vertices near the tool than capacity
  double max_penetration = 0;         // m, deepest after the last step
};

/// Groups the skin's vertices into clusters and copies the shape table into the
/// real-time layout. `shape` has one row per skin vertex.
/// @param young_modulus  Pa, the softest tissue's; sets the contact layer's stiffness
SkinModel buildSkinModel(const TriangleSurface& surface, const ShapeTable& shape, double tool_radius,
                         double young_modulus);

/// Memory for the largest contact that this tool can make with this skin.
ContactState makeContactState(const SkinModel& skin, const ToolShape& tool);

/// Finds the skin vertices within reach of the tool (clusters first, with a margin
/// that allows for the tissue's stretch) and lists them in `contact`, keeping the
/// warm-start forces of those that stay. Once per tick.
/// Real-time: no allocation, no lock, no throw.
void findContactCandidates(const SkinModel& skin, const Float4* u, const ToolShape& tool,
                           const Pose& tool_pose, double margin, ContactState& contact);

/// Pushes the predicted displacement out of the tool: finds forces f_v at the skin
/// vertices, compressive along the tool's normal and inside the friction cone, with
///   du_i += alpha / m_i sum_v N_i(X_v) f_v
/// so that u + du satisfies the contact law at the end of the step (implicit in the
/// contact, hence no limit on the step). The tool's force is exactly -sum_v f_v.
///
/// @param alpha         the step's mobility factor of paper eq. 12, s^2
/// @param inverse_mass  1/kg                                   (node_count)
/// @param u             displacement at the start, m           (node_count)
/// @param du            predicted increment, m; corrected      (node_count)
/// @param pose, previous_pose  tool at the step's end and start
/// @return the force on the tool, N
/// Real-time: no allocation, no lock, no throw.
Vec3 solveContact(const SkinModel& skin, const ToolShape& tool, const Pose& pose,
                  const Pose& previous_pose, double friction, double alpha, const float* inverse_mass,
                  const Float4* u, Float4* du, ContactState& contact);

}  // namespace palpate
