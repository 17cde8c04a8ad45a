#pragma once

#include <array>
#include <vector>

#include "approximation/shape_table.h"
#include "base/spin_team.h"
#include "base/types.h"
#include "mechanics/node_patch.h"

namespace palpate {

/// The volume of the background cells at the field's positions, which takes over where node patches are under a
/// pressure that their own volume can't hold.
///
/// Under a constant pressure the volumetric energy does the work p sum_q w_q (J_q - 1). In the continuum that depends
/// on the boundary alone. With MLS gradients it does so to first order only; to second order some inner displacements
/// gain energy in proportion to p, and from a few shear moduli on shear no longer holds them. The tetrahedra between
/// the nodes' positions fill what their outer faces enclose, whatever the inner nodes do:
///
///   x_a = X_a + sum_j N_j(X_a) u_j,   theta'_a = sum_t s_ta (V_t(x) - V_t) / V'_a,   V'_a = sum_t s_ta V_t
///   energy  sum_a V_a h(K_a theta_a) + V'_a w_a (K_a theta'_a^2 / 2 - h(K_a theta'_a))
///
/// over nodes a and their cells t; theta_a and V_a are the patches' (node_patch.h). h is the energy of a pressure
/// p = K theta that is bounded by p1, some times the least shear modulus in the patch (pressureLimits): p^2 / 2K for p
/// > -p1, p1 (-p - p1/2) / K beyond. So a patch's pressure is max(K theta, -p1), and what is beyond comes from the
/// cells: their pressure is the sum of s_ta w_a min(K theta'_a + p1, 0) of their four nodes, and -p_t dV_t/dx_a goes to
/// the nodes j by N_j(X_a). Under tension nothing changes.
///
/// A cell counts for its vertices by equal parts s_ta: exact where the pressure is even. Along what holds it a field
/// without change of volume curves away, of which tetrahedra see chords, and the body is too stiff: a layer between
/// bonded faces, four times as wide as high, pressed by 20 %, by 22 and 17 % at a height of 3 and 4 spacings, a block
/// with friction 1 between plates by 10 % (nodes of 5 mm; 24 % pressed by 40 %). So what is held keeps its patch's
/// pressure (it is doubted beyond what patches hold: step/trust.h), by the share 1 - c_a: c_a h + (1 - c_a) p^2 / 2K in
/// place of h, and w_a is c_a times what follows.
///   bonded faces                       c_a = 0, but in bodies that are held all around: nothing flows across then
///   what rubs against it               c_a falls with the friction that it has (looseShare)
/// The layers are then 1.4 and 0.2 % stiffer than by patches alone, the block 0.2 %. A face that is turned, or moved
/// while it is bonded, curves the flow everywhere (a block bent to a ring: 17 % too stiff, 4 % by patches alone;
/// twisted tissue of nu 0.499 finds no equilibrium): such bodies have no cells (Model::hasCellVolume).
///
/// Which nodes are looked at follows from the points alone: w_a rises from 0 to 1 as the largest K_a (1 - J_q) / p1 of
/// the points in the patch rises from pressed_from to 1. Where no point gets there, nothing is computed. (A patch's own
/// theta, the points' mean, is no guide: under a tool, theta' is beyond the limit at nodes whose theta is nearly 0.)
/// Forces are continuous; they are the energy's derivative where w_a is 0 or 1, or theta'_a is below p1. Elsewhere, at
/// a node whose cells are beyond the limit while no point around is, the change of w_a is left out.
template <class Real>
struct CellVolumeOf {
  // N_j(X_a) by rows, vertices a, and by columns, nodes j. At a border between materials a node is a vertex of its own
  // for each side.
  std::vector<int> row_begin, column_begin;         // (vertex_count + 1), (node_count + 1)
  std::vector<std::int32_t> row_node, column_node;  // j of a row, a of a column
  AlignedVector<Real> row_N, column_N;
  // Cells in blocks of four, ordered by their lowest node, which is vertex 0.
  std::vector<std::int32_t> cell_node;  // (16 * block_count) [vertex 4][cell 4]; after the last cell, one node
  AlignedVector<Real> edge;             // (36 * block_count) [edge 3][component 3][cell 4], from vertex 0, m
  // Of each vertex.
  std::vector<int> corner_begin;     // (vertex_count + 1) entries in
  std::vector<std::int32_t> corner;  // (4 * cell_count) 4 * cell + vertex
  AlignedVector<Real> share;         // (vertex_count) s_ta, the same in all its cells
  AlignedVector<Real> patch_volume;  // (vertex_count) V_a, m^3
  AlignedVector<Real> volume;        // (vertex_count) V'_a, m^3
  AlignedVector<Real> limit;         // (vertex_count) p1 over the patch's least shear modulus

  bool empty() const { return row_begin.empty(); }
  int vertexCount() const { return static_cast<int>(volume.size()); }
  int nodeCount() const { return static_cast<int>(column_begin.size()) - 1; }
  int blockCount() const { return static_cast<int>(cell_node.size() / 16); }
};

/// What the points and patches leave for the cells' volume; arrays of KernelLayoutOf and KernelScratchOf.
template <class Real>
struct PatchStateOf {
  int batch_count;
  const std::int32_t* node;  // (64 * batch_count) patches of the points, [vertex 4][point 16] per batch
  const int* begin;          // (vertex_count + 1) entries of each patch in
  const std::int32_t* point;
  const Real* bulk;         // (vertex_count) K_a, Pa
  const Real* shear;        // (vertex_count) least shear modulus, Pa
  const Real* dilatation;   // (16 * batch_count) J - 1 of the points
  Real* pressure;           // (vertex_count) K_a theta_a, Pa; is bounded
  Real pressed_dilatation;  // -pressed_from times the least p1 / K_a of all patches
};

/// Which vertices and cells are looked at, and what is known of them. Vertices are listed by groups of 16.
template <class Real>
struct CellVolumeScratchOf {
  static constexpr int group_size = 16;
  /// Flags of cells around some vertices, and of all these cells' vertices.
  struct Selection {
    std::vector<std::uint8_t> block, vertex, group;  // (block_count), (vertex_count), (group_count)
  };
  bool pressed = false;                     // some patch may be; else all flags are 0
  std::vector<double> energy;               // (part_count) J
  std::vector<double> max_pressure;         // (part_count) of CellReport
  std::vector<std::uint8_t> group_pressed;  // (group_count) some point of a vertex's patch is pressed
  Selection looked, loaded;                 // around vertices with w_a > 0; around those with a pressure
  std::vector<std::uint8_t> touched;        // (node_count) moves the field at a vertex of loaded cells
  // Lists of what is flagged: pressed groups; groups and blocks of a selection.
  std::vector<int> groups, groups_of_cells, blocks;
  AlignedVector<float> friction;            // (vertex_count) Pa, that holds nodes of the skin: the caller's to set
  AlignedVector<Real> weight;               // (vertex_count) w_a
  AlignedVector<Real4<Real>> field;         // (vertex_count) displacement at X_a, m
  AlignedVector<Real> volume_change;        // (4 * block_count) V_t(x) - V_t, m^3
  AlignedVector<Real> pressure;             // (vertex_count) w_a (K theta' - clamp), Pa
  AlignedVector<Real4<Real>> corner_force;  // (16 * block_count) N
  AlignedVector<Real4<Real>> vertex_force;  // (vertex_count) N, at X_a
};

/// What the cells' volume is computed from, in double.
struct CellVolumeSpec {
  std::vector<Vec3> X;                    // (vertex_count) m: nodes, and after them a border's further sides
  std::vector<std::array<int, 4>> cells;  // (cell_count) of either orientation
  int node_count;
  ShapeTable vertex_shape;                 // of nodes, where vertices go with them; no gradients
  const NodePatches& patches;              // a patch of each vertex
  std::vector<std::uint8_t> imposed = {};  // (vertex_count) 7: all components are imposed; empty: none is
};

/// Whether each outer face is held at its nodes, in some component.
bool isConfined(const CellVolumeSpec& spec);

/// p1 over the shear modulus, of the vertices: pressure_limit, and infinity on bonded faces.
std::vector<double> pressureLimits(const CellVolumeSpec& spec);

template <class Real>
CellVolumeOf<Real> makeCellVolume(const CellVolumeSpec& spec);

/// @param part_count  parts of the work, on which the order of sums depends
template <class Real>
CellVolumeScratchOf<Real> makeCellVolumeScratch(const CellVolumeOf<Real>& cells, int part_count);

/// What one force evaluation says of the cells.
struct CellReport {
  double energy = 0;        // J, that the points' sum of p_q (J_q - 1) / 2 lacks
  double max_pressure = 0;  // largest mean over a cell's nodes of pressure (patches' and cells') by least shear modulus
};

// The work of one force evaluation. Real-time: no allocation, no lock, no throw; the same bits for any team.
// Test: mechanics/cell_volume_test.cpp

/// Notes the patches of points that are pressed, of a part of the points; after their dilatation is known.
template <class Real>
void findPressed(const PatchStateOf<Real>& patches, int part, CellVolumeScratchOf<Real>& scratch);

/// After all parts of findPressed: bounds the patches' pressure, and keeps the cells' forces in the scratch.
template <class Real>
CellReport cellForces(const CellVolumeOf<Real>& cells, const PatchStateOf<Real>& patches, const Real4<Real>* u,
                      CellVolumeScratchOf<Real>& scratch, SpinTeam& team);

/// Adds them to f of nodes [begin, end).
template <class Real>
void addCellForces(const CellVolumeOf<Real>& cells, const CellVolumeScratchOf<Real>& scratch, int begin, int end,
                   Real4<Real>* f);

/// The same plainly, in double: what the fast passes are held to.
struct CellVolumeReference {
  double energy = 0;                   // J, of patches and cells
  std::vector<double> patch_pressure;  // (vertex_count) Pa, bounded
  std::vector<double> cell_pressure;   // (vertex_count) Pa, what is beyond
  std::vector<Vec3> force;             // (node_count) N, of the cells
};

/// @param volume     of the points, m^3                       (point_count)
/// @param J_minus_1  of the points                            (point_count)
/// @param shear      least shear modulus of the patches, Pa   (vertex_count)
/// @param friction   that holds them, Pa                      (vertex_count); empty: none
CellVolumeReference referenceCellVolume(const CellVolumeSpec& spec, const std::vector<double>& volume,
                                        const std::vector<double>& J_minus_1, const std::vector<double>& shear,
                                        const std::vector<Vec3>& u, const AlignedVector<float>& friction = {});

/// Least shear modulus in each node's patch, what relaxes left out, Pa; 0 where there is none.
std::vector<double> patchShear(const NodePatches& patches, const std::vector<int>& point_material,
                               const std::vector<Material>& materials);

}  // namespace palpate
