#pragma once

#include <array>
#include <vector>

#include "base/float4.h"
#include "base/spin_team.h"
#include "base/types.h"
#include "mechanics/load_curve.h"

namespace palpate {

/// Pressures and tractions on the skin ([[load]]), constant. They act on the outer faces of the cells:
///
///   f_i = s sum_f R_fi g_f,   R_fi = sum_k w_k N_i(X_k)
///   g_f = A_f t                a traction t, Pa, A_f the area at rest; or the pressure -p n at rest
///       = -p a_f               a follower pressure p: a_f = (x_1 - x_0) x (x_2 - x_0) / 2, of the face's nodes now
///
/// s is the share of the load at a time. The points X_k are those at which gradients are made consistent
/// (boundary_points.h), so that a uniform stress is in equilibrium with the load to rounding. Pressure on all of the
/// skin sums to no force; its torque vanishes as faces become flat. Of a face that a region's border cuts the points
/// are 64 places of even area, of which those inside count.
struct SurfaceLoads {
  struct Course {
    LoadCurve curve;
    double duration = 0;  // s
  };
  /// A face under a follower pressure.
  struct Face {
    std::array<int, 3> vertex{};  // counter-clockwise seen from outside
    int load = 0;
    float share = 1;  // of the area, that is loaded
  };
  std::vector<Course> course;                // (load_count)
  std::vector<double> pressure;              // (load_count) Pa, of followers; else 0
  std::vector<AlignedVector<Double4>> dead;  // (load_count) N, by nodes, at share 1; empty for followers
  std::vector<Vec3> dead_force;              // (load_count) N, their sums
  // Nodes of faces that follower pressures act on.
  std::vector<Vec3> X;           // (vertex_count) m
  std::vector<int> begin, node;  // rows of N: (vertex_count + 1), (entry_count)
  AlignedVector<float> N;        // (entry_count)
  std::vector<Face> face;        // (face_count)
  // R by nodes.
  std::vector<int> node_begin;  // (node_count + 1); empty without followers
  std::vector<int> node_face;   // (coefficient_count)
  AlignedVector<float> R;       // (coefficient_count)

  bool empty() const { return course.empty(); }
};

/// Memory of one evaluation.
template <class Real>
struct SurfaceLoadScratchOf {
  explicit SurfaceLoadScratchOf(const SurfaceLoads& loads)
      : share(loads.course.size()), x(loads.X.size()), g(loads.face.size()) {}
  AlignedVector<Real> share;     // (load_count) of each load
  AlignedVector<Double4> x;      // (vertex_count) m, places of the faces' nodes
  AlignedVector<Real4<Real>> g;  // (face_count) N
};
using SurfaceLoadScratch = SurfaceLoadScratchOf<float>;

/// Shares of all loads at a time and the forces on pressed faces, for loadOnNode.
/// @param u  m (node_count)
/// Real-time: no allocation, no lock, no throw. The team shares it in fixed parts; about 60 four-lane FMAs for each
/// node on a pressed face, and 80 for each such face in loadOnNode.
/// Test: simulation/surface_loads_test.cpp
template <class Real>
void evaluate(const SurfaceLoads& loads, double time, const Real4<Real>* u, SurfaceLoadScratchOf<Real>& scratch,
              SpinTeam& team);

/// f_i of node i, N, after evaluate. Real-time.
template <class Real>
GroupOf<Real> loadOnNode(const SurfaceLoads& loads, const SurfaceLoadScratchOf<Real>& scratch, std::size_t i) {
  GroupOf<Real> f{};
  for (std::size_t k = 0; k < loads.dead.size(); ++k)
    if (!loads.dead[k].empty()) f += scratch.share[k] * __builtin_convertvector(load(loads.dead[k][i]), GroupOf<Real>);
  if (loads.node_begin.empty()) return f;
  for (int e = loads.node_begin[i]; e < loads.node_begin[i + 1]; ++e)
    f += static_cast<Real>(loads.R[e]) * load(scratch.g[loads.node_face[e]]);
  return f;
}

/// The sum of each load's forces, N (load_count), as evaluate left them.
template <class Real>
std::vector<Vec3> loadForces(const SurfaceLoads& loads, const SurfaceLoadScratchOf<Real>& scratch);

}  // namespace palpate
