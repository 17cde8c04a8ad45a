#include "mechanics/cell_volume.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <numeric>

#include "base/float4.h"
#include "mechanics/bounded_pressure.h"

namespace palpate {
namespace {

/// Sets a flag that other threads may be setting, too.
void mark(std::uint8_t& flag) {
  const std::atomic_ref<std::uint8_t> shared(flag);
  if (shared.load(std::memory_order_relaxed) == 0) shared.store(1, std::memory_order_relaxed);
}

/// The places of flags that are set.
void collect(const std::vector<std::uint8_t>& flags, std::vector<int>& list) {
  list.clear();
  for (std::size_t first = 0; first < flags.size(); first += 8) {
    const std::size_t count = std::min<std::size_t>(8, flags.size() - first);
    std::uint64_t eight = 0;
    std::memcpy(&eight, &flags[first], count);
    if (eight == 0) continue;
    for (std::size_t k = first; k < first + count; ++k)
      if (flags[k]) list.push_back(static_cast<int>(k));
  }
}

/// Whether one of 16 numbers is below the limit.
template <class Real>
bool anyBelow(const Real* number, Real limit) {
  GroupOf<Real> least{};
  for (int i = 0; i < 16; i += 4) {
    const GroupOf<Real> a = loadGroup(number + i);
    least = a < least ? a : least;
  }
  return least[0] < limit || least[1] < limit || least[2] < limit || least[3] < limit;
}

template <class Real>
std::size_t groupOf(std::int32_t node) {
  return static_cast<std::size_t>(node) / CellVolumeScratchOf<Real>::group_size;
}

/// Four cells, a lane each: vectors of edges as [edge][component].
template <class Real>
struct CellBlock {
  using Lanes = GroupOf<Real>;
  Lanes E[3][3], D[3][3], F[3][3];  // edges at rest, their change, their sum

  static void transpose(const Lanes* row, Lanes* x) {
    const Lanes a = __builtin_shufflevector(row[0], row[1], 0, 4, 1, 5);
    const Lanes b = __builtin_shufflevector(row[2], row[3], 0, 4, 1, 5);
    const Lanes c = __builtin_shufflevector(row[0], row[1], 2, 6, 3, 7);
    const Lanes d = __builtin_shufflevector(row[2], row[3], 2, 6, 3, 7);
    x[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
    x[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
    x[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
    x[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
  }

  CellBlock(const CellVolumeOf<Real>& cells, int block, const Real4<Real>* field) {
    const std::int32_t* node = &cells.cell_node[static_cast<std::size_t>(block) * 16];
    const Real* edge = &cells.edge[static_cast<std::size_t>(block) * 36];
    Lanes at[4][4];
    for (int v = 0; v < 4; ++v) {
      const Lanes row[4] = {load(field[node[4 * v]]), load(field[node[4 * v + 1]]), load(field[node[4 * v + 2]]),
                            load(field[node[4 * v + 3]])};
      transpose(row, at[v]);
    }
    for (int k = 0; k < 3; ++k)
      for (int c = 0; c < 3; ++c) {
        E[k][c] = loadGroup(edge + 4 * (3 * k + c));
        D[k][c] = at[k + 1][c] - at[0][c];
        F[k][c] = E[k][c] + D[k][c];
      }
  }

  static void cross(const Lanes* a, const Lanes* b, Lanes* result) {
    for (int c = 0; c < 3; ++c) result[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
  }
  static Lanes triple(const Lanes* a, const Lanes* b, const Lanes* c) {
    Lanes n[3];
    cross(b, c, n);
    return a[0] * n[0] + a[1] * n[1] + a[2] * n[2];
  }

  /// det F - det E from the edges' changes: no cancellation.
  Lanes volumeChange() const {
    return (triple(D[0], F[1], F[2]) + (triple(E[0], D[1], F[2]) + triple(E[0], E[1], D[2]))) * (Real(1) / 6);
  }

  /// -p dV/dx of the cells' vertices, [cell][vertex]; nothing where p is 0, whatever is there.
  void forces(const Lanes& p, Real4<Real>* force) const {
    Lanes g[4][4] = {};
    const Lanes none{}, factor = p * (Real(-1) / 6);
    for (int v = 1; v < 4; ++v) {
      cross(F[v % 3], F[(v + 1) % 3], g[v]);
      for (int c = 0; c < 3; ++c) {
        g[v][c] = p != none ? factor * g[v][c] : none;
        g[0][c] -= g[v][c];
      }
    }
    for (int v = 0; v < 4; ++v) {
      Lanes row[4];
      transpose(g[v], row);
      for (int t = 0; t < 4; ++t) store(force[4 * t + v], row[t]);
    }
  }
};

/// The work of cellForces in parts, each over a share of a list.
template <class Real>
struct CellPasses {
  const CellVolumeOf<Real>& cells;
  const PatchStateOf<Real>& patches;
  const Real4<Real>* u;
  CellVolumeScratchOf<Real>& s;

  /// Calls each(item, part) for all of a list.
  template <class Each>
  void forAll(SpinTeam& team, const std::vector<int>& list, Each each) const {
    const std::size_t parts = s.energy.size(), count = list.size();
    if (count == 0) return;  // nothing to wait for
    shareOut(team, static_cast<int>(parts), [&](int part) {
      const auto p = static_cast<std::size_t>(part);
      for (std::size_t k = count * p / parts; k < count * (p + 1) / parts; ++k) each(list[k], p);
    });
  }
  template <class Each>
  void forNodes(SpinTeam& team, const std::vector<int>& groups, Each each) const {
    forAll(team, groups, [&](int group, std::size_t part) {
      const int begin = group * s.group_size;
      for (int a = begin; a < std::min(begin + s.group_size, cells.vertexCount()); ++a) each(a, part);
    });
  }

  void clear() const {
    for (auto* selection : {&s.looked, &s.loaded})
      for (auto* flags : {&selection->group, &selection->block, &selection->vertex})
        std::fill(flags->begin(), flags->end(), std::uint8_t{0});
    std::fill(s.touched.begin(), s.touched.end(), std::uint8_t{0});
    std::fill(s.weight.begin(), s.weight.end(), Real(0));
    std::fill(s.pressure.begin(), s.pressure.end(), Real(0));
  }

  /// Bounds a patch's pressure, and notes the cells around it if it is pressed.
  void bound(int a, std::size_t part) const {
    const Real limit = cells.limit[a] * patches.shear[a], p = patches.pressure[a];
    if (!(limit > 0)) return;  // in no cell
    Real least = 0;
    for (int e = patches.begin[a]; e < patches.begin[a + 1]; ++e)
      least = std::min(least, patches.dilatation[patches.point[e]]);
    const Real loose = looseShare(static_cast<Real>(s.friction[a]), patches.shear[a]);
    s.weight[a] = loose * pressedShare(patches.bulk[a] * least, limit);
    if (s.weight[a] == 0) return;
    const Real kept = bounded(p, limit);
    patches.pressure[a] = p + loose * (kept - p);
    s.energy[part] +=
        loose * cells.patch_volume[a] * (boundedEnergy(p, limit, patches.bulk[a]) - kept * p / (2 * patches.bulk[a]));
    markCells(a, s.looked);
  }

  /// Marks the cells of a node, and their vertices.
  void markCells(int a, typename CellVolumeScratchOf<Real>::Selection& selection) const {
    for (int e = cells.corner_begin[a]; e < cells.corner_begin[a + 1]; ++e) {
      const std::int32_t cell = cells.corner[e] / 4;
      mark(selection.block[cell / 4]);
      for (int v = 0; v < 4; ++v) {
        const std::int32_t node = cells.cell_node[cell / 4 * 16 + 4 * v + cell % 4];
        mark(selection.vertex[node]);
        mark(selection.group[groupOf<Real>(node)]);
      }
    }
  }

  void displace(int a) const {
    if (!s.looked.vertex[a]) return;
    GroupOf<Real> sum{};
    for (int e = cells.row_begin[a]; e < cells.row_begin[a + 1]; ++e)
      sum += cells.row_N[e] * load(u[cells.row_node[e]]);
    store(s.field[a], sum);
  }

  void changeVolume(int block) const {
    storeGroup(&s.volume_change[static_cast<std::size_t>(block) * 4],
               CellBlock<Real>(cells, block, s.field.data()).volumeChange());
  }

  void press(int a, std::size_t part) const {
    if (!(s.weight[a] > 0) || !(cells.volume[a] > 0)) return;
    Real change = 0;
    for (int e = cells.corner_begin[a]; e < cells.corner_begin[a + 1]; ++e)
      change += s.volume_change[cells.corner[e] / 4];
    const Real bulk = patches.bulk[a], limit = cells.limit[a] * patches.shear[a];
    const Real p = bulk * (cells.share[a] * change / cells.volume[a]);
    s.pressure[a] = s.weight[a] * (p - bounded(p, limit));
    if (s.pressure[a] == 0) return;
    markCells(a, s.loaded);
    s.energy[part] += s.weight[a] * cells.volume[a] * (p * p / (2 * bulk) - boundedEnergy(p, limit, bulk));
  }

  void pushCorners(int block, std::size_t part) const {
    const std::int32_t* node = &cells.cell_node[static_cast<std::size_t>(block) * 16];
    GroupOf<Real> p{};
    for (int t = 0; t < 4; ++t) {
      const auto of = [&](int v) { return cells.share[node[4 * v + t]] * s.pressure[node[4 * v + t]]; };
      p[t] = (of(0) + of(1)) + (of(2) + of(3));
      if (node[t] == node[4 + t]) continue;  // padding
      const auto over_shear = [&](int v) {
        const std::int32_t a = node[4 * v + t];
        return cells.share[a] > 0 ? cells.share[a] * (patches.pressure[a] + s.pressure[a]) / patches.shear[a] : 0;
      };
      const Real mean = -((over_shear(0) + over_shear(1)) + (over_shear(2) + over_shear(3)));
      if (mean > s.max_pressure[part]) s.max_pressure[part] = mean;  // not NaN: a node in no point's cell
    }
    CellBlock<Real>(cells, block, s.field.data()).forces(p, &s.corner_force[static_cast<std::size_t>(block) * 16]);
  }

  void sumCorners(int a) const {
    if (!s.loaded.vertex[a]) return;
    GroupOf<Real> sum{};
    for (int e = cells.corner_begin[a]; e < cells.corner_begin[a + 1]; ++e)
      if (s.loaded.block[cells.corner[e] / 16]) sum += load(s.corner_force[cells.corner[e]]);
    store(s.vertex_force[a], sum);
    for (int e = cells.row_begin[a]; e < cells.row_begin[a + 1]; ++e) mark(s.touched[cells.row_node[e]]);
  }

  CellReport run(SpinTeam& team) const {
    std::fill(s.group_pressed.begin(), s.group_pressed.end(), std::uint8_t{0});
    std::fill(s.energy.begin(), s.energy.end(), 0.0);
    std::fill(s.max_pressure.begin(), s.max_pressure.end(), 0.0);
    forNodes(team, s.groups, [this](int a, std::size_t part) { bound(a, part); });
    collect(s.looked.group, s.groups_of_cells);
    collect(s.looked.block, s.blocks);
    s.pressed = !s.blocks.empty();
    if (!s.pressed) return {};  // some point is near its limit, but no patch: all flags are 0 still
    forNodes(team, s.groups_of_cells, [this](int a, std::size_t) { displace(a); });
    forAll(team, s.blocks, [this](int block, std::size_t) { changeVolume(block); });
    forNodes(team, s.groups, [this](int a, std::size_t part) { press(a, part); });
    collect(s.loaded.group, s.groups_of_cells);
    collect(s.loaded.block, s.blocks);
    forAll(team, s.blocks, [this](int block, std::size_t part) { pushCorners(block, part); });
    forNodes(team, s.groups_of_cells, [this](int a, std::size_t) { sumCorners(a); });
    return {std::accumulate(s.energy.begin(), s.energy.end(), 0.0),
            *std::max_element(s.max_pressure.begin(), s.max_pressure.end())};
  }
};

}  // namespace

template <class Real>
void findPressed(const PatchStateOf<Real>& patches, int part, CellVolumeScratchOf<Real>& scratch) {
  const auto parts = static_cast<std::int64_t>(scratch.energy.size());
  const auto border = [&](int k) { return static_cast<int>(std::int64_t{patches.batch_count} * k / parts); };
  for (int batch = border(part); batch < border(part + 1); ++batch) {
    const Real* dilatation = patches.dilatation + static_cast<std::ptrdiff_t>(batch) * 16;
    if (!anyBelow(dilatation, patches.pressed_dilatation)) continue;
    for (int i = 0; i < 16; ++i)
      if (dilatation[i] < patches.pressed_dilatation)
        for (int v = 0; v < 4; ++v)
          mark(
              scratch.group_pressed[groupOf<Real>(patches.node[static_cast<std::ptrdiff_t>(batch) * 64 + 16 * v + i])]);
  }
}

template <class Real>
CellReport cellForces(const CellVolumeOf<Real>& cells, const PatchStateOf<Real>& patches, const Real4<Real>* u,
                      CellVolumeScratchOf<Real>& scratch, SpinTeam& team) {
  CellVolumeScratchOf<Real>& s = scratch;
  const CellPasses<Real> passes{cells, patches, u, s};
  if (s.pressed) passes.clear();
  collect(s.group_pressed, s.groups);
  s.pressed = !s.groups.empty();
  return s.pressed ? passes.run(team) : CellReport{};
}

template <class Real>
void addCellForces(const CellVolumeOf<Real>& cells, const CellVolumeScratchOf<Real>& scratch, int begin, int end,
                   Real4<Real>* f) {
  if (!scratch.pressed) return;
  for (int j = begin; j < end; ++j) {
    if (!scratch.touched[j]) continue;
    GroupOf<Real> sum{};
    for (int e = cells.column_begin[j]; e < cells.column_begin[j + 1]; ++e) {
      const std::int32_t a = cells.column_node[e];
      if (scratch.loaded.vertex[a]) sum += cells.column_N[e] * load(scratch.vertex_force[a]);
    }
    store(f[j], load(f[j]) + sum);
  }
}

template void findPressed(const PatchStateOf<float>&, int, CellVolumeScratchOf<float>&);
template void findPressed(const PatchStateOf<double>&, int, CellVolumeScratchOf<double>&);
template CellReport cellForces(const CellVolumeOf<float>&, const PatchStateOf<float>&, const Float4*,
                               CellVolumeScratchOf<float>&, SpinTeam&);
template CellReport cellForces(const CellVolumeOf<double>&, const PatchStateOf<double>&, const Double4*,
                               CellVolumeScratchOf<double>&, SpinTeam&);
template void addCellForces(const CellVolumeOf<float>&, const CellVolumeScratchOf<float>&, int, int, Float4*);
template void addCellForces(const CellVolumeOf<double>&, const CellVolumeScratchOf<double>&, int, int, Double4*);

}  // namespace palpate
