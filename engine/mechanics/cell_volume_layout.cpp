#include <algorithm>
#include <limits>

#include "approximation/node_entries.h"
#include "discretization/cells/background_cells.h"
#include "mechanics/bounded_pressure.h"
#include "mechanics/cell_volume.h"

namespace palpate {
namespace {

double signedVolume(const std::vector<Vec3>& X, const std::array<int, 4>& cell) {
  return (X[cell[1]] - X[cell[0]]).cross(X[cell[2]] - X[cell[0]]).dot(X[cell[3]] - X[cell[0]]) / 6;
}

/// Cells of positive volume whose first vertex is the lowest, in its order.
std::vector<std::array<int, 4>> orderedCells(const CellVolumeSpec& spec) {
  std::vector<std::array<int, 4>> cells = spec.cells;
  for (auto& cell : cells) {
    std::sort(cell.begin(), cell.end());
    if (signedVolume(spec.X, cell) < 0) std::swap(cell[2], cell[3]);
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

/// Nodes of bonded faces: all of a face's components are imposed. (Where plates without friction meet at a corner, one
/// node's are.)
std::vector<std::uint8_t> bondedNodes(const CellVolumeSpec& spec) {
  std::vector<std::uint8_t> bonded(spec.X.size(), 0);
  if (spec.imposed.empty()) return bonded;
  const auto held = [&](int node) { return spec.imposed[node] == 7; };
  for (const auto& cell : spec.cells)
    if (std::count_if(cell.begin(), cell.end(), held) >= 3)
      for (const int a : cell)
        if (held(a)) bonded[a] = 1;
  return bonded;
}

/// Lists of lists as one, after its borders.
void flatten(const std::vector<std::vector<int>>& lists, std::vector<int>& begin, std::vector<std::int32_t>& all) {
  begin.assign(1, 0);
  for (const auto& list : lists) {
    all.insert(all.end(), list.begin(), list.end());
    begin.push_back(static_cast<int>(all.size()));
  }
}

template <class Real>
void addTables(const CellVolumeSpec& spec, CellVolumeOf<Real>& result) {
  const ShapeTable& shape = spec.vertex_shape;
  const auto real = [](double a) { return static_cast<Real>(a); };
  result.row_begin = shape.begin;
  result.row_node.assign(shape.node.begin(), shape.node.end());
  std::transform(shape.N.begin(), shape.N.end(), std::back_inserter(result.row_N), real);
  const NodeEntries columns = nodeEntries(shape, static_cast<std::size_t>(spec.node_count));
  result.column_begin = columns.begin;
  result.column_node.assign(columns.point.begin(), columns.point.end());
  for (const int e : columns.entry) result.column_N.push_back(real(shape.N[e]));
}

template <class Real>
void addCells(const CellVolumeSpec& spec, CellVolumeOf<Real>& result) {
  const auto cells = orderedCells(spec);
  std::vector<double> volume(spec.X.size(), 0);
  std::vector<std::vector<int>> corners(spec.X.size());
  const std::size_t blocks = (cells.size() + 3) / 4;
  result.cell_node.assign(blocks * 16, cells.empty() ? 0 : cells.back()[0]);
  result.share.assign(spec.X.size(), Real(0.25));
  result.edge.assign(blocks * 36, Real(0));
  for (std::size_t t = 0; t < cells.size(); ++t) {
    for (int v = 0; v < 4; ++v) {
      const int node = cells[t][v];
      result.cell_node[t / 4 * 16 + static_cast<std::size_t>(v) * 4 + t % 4] = node;
      for (int c = 0; v > 0 && c < 3; ++c)
        result.edge[t / 4 * 36 + static_cast<std::size_t>(3 * (v - 1) + c) * 4 + t % 4] =
            static_cast<Real>(spec.X[node][c] - spec.X[cells[t][0]][c]);
      volume[node] += 0.25 * signedVolume(spec.X, cells[t]);
      corners[node].push_back(static_cast<int>(4 * t) + v);
    }
  }
  flatten(corners, result.corner_begin, result.corner);
  result.volume.assign(volume.begin(), volume.end());
}

/// Where patches average a share of the volume only, they and so the cells stand for that share of their energy.
template <class Real>
void averageLess(const std::vector<double>& averaged, CellVolumeOf<Real>& cells) {
  for (std::size_t a = 0; a < averaged.size(); ++a) {
    cells.volume[a] *= static_cast<Real>(averaged[a]);
    cells.share[a] *= static_cast<Real>(averaged[a]);
  }
}

}  // namespace

bool isConfined(const CellVolumeSpec& spec) {
  if (spec.imposed.empty()) return false;
  const auto nodeOf = [&](int vertex) {
    return vertex < spec.node_count ? vertex : spec.vertex_shape.node[spec.vertex_shape.begin[vertex]];
  };
  std::vector<std::array<int, 4>> cells = spec.cells;
  for (auto& cell : cells)
    for (int& vertex : cell) vertex = nodeOf(vertex);
  for (const auto& facet : boundaryFacets(cells))
    for (const int node : facet)
      if (spec.imposed[node] == 0) return false;
  return true;
}

std::vector<double> pressureLimits(const CellVolumeSpec& spec) {
  std::vector<double> limit(spec.X.size(), pressure_limit);
  if (isConfined(spec)) return limit;
  const auto bonded = bondedNodes(spec);
  for (std::size_t a = 0; a < limit.size(); ++a)
    if (bonded[a] != 0) limit[a] = std::numeric_limits<double>::infinity();
  return limit;
}

template <class Real>
CellVolumeOf<Real> makeCellVolume(const CellVolumeSpec& spec) {
  CellVolumeOf<Real> result;
  addTables(spec, result);
  addCells(spec, result);
  const auto limit = pressureLimits(spec);
  result.limit.assign(limit.begin(), limit.end());
  result.patch_volume.assign(spec.patches.volume.begin(), spec.patches.volume.end());
  if (!spec.patches.own.empty()) averageLess(averagedShares(spec.patches), result);
  return result;
}

template <class Real>
CellVolumeScratchOf<Real> makeCellVolumeScratch(const CellVolumeOf<Real>& cells, int part_count) {
  CellVolumeScratchOf<Real> scratch;
  if (cells.empty()) return scratch;
  const auto vertices = static_cast<std::size_t>(cells.vertexCount()),
             blocks = static_cast<std::size_t>(cells.blockCount());
  const std::size_t groups = (vertices + scratch.group_size - 1) / scratch.group_size;
  scratch.energy.resize(static_cast<std::size_t>(part_count));
  scratch.max_pressure.resize(static_cast<std::size_t>(part_count));
  scratch.groups.reserve(groups);
  scratch.groups_of_cells.reserve(groups);
  scratch.blocks.reserve(blocks);
  scratch.group_pressed.resize(groups);
  for (auto* selection : {&scratch.looked, &scratch.loaded}) {
    selection->block.resize(blocks);
    selection->vertex.resize(vertices);
    selection->group.resize(groups);
  }
  scratch.touched.resize(static_cast<std::size_t>(cells.nodeCount()));
  scratch.friction.resize(vertices);
  scratch.weight.resize(vertices);
  scratch.field.resize(vertices);
  scratch.volume_change.resize(4 * blocks);
  scratch.pressure.resize(vertices);
  scratch.corner_force.resize(16 * blocks);
  scratch.vertex_force.resize(vertices);
  return scratch;
}

std::vector<double> patchShear(const NodePatches& patches, const std::vector<int>& point_material,
                               const std::vector<Material>& materials) {
  std::vector<double> shear(patches.volume.size(), 0);
  for (std::size_t q = 0; q < patches.node.size(); ++q)
    for (const int a : patches.node[q]) {
      const Material& material = materials[point_material[q]];
      const double mu = material.shear_modulus * material.longTermShare();
      shear[a] = shear[a] == 0 ? mu : std::min(shear[a], mu);
    }
  return shear;
}

CellVolumeReference referenceCellVolume(const CellVolumeSpec& spec, const std::vector<double>& volume,
                                        const std::vector<double>& J_minus_1, const std::vector<double>& shear,
                                        const std::vector<Vec3>& u, const AlignedVector<float>& friction) {
  const auto cells = orderedCells(spec);
  const std::size_t vertices = spec.X.size();
  const auto& K = spec.patches.bulk_modulus;
  const auto theta = patchDilatation(spec.patches, volume, J_minus_1);
  CellVolumeReference result{0, std::vector<double>(vertices), std::vector<double>(vertices), {}};
  result.force.assign(static_cast<std::size_t>(spec.node_count), Vec3::Zero());
  std::vector<Vec3> x = spec.X, force(vertices, Vec3::Zero());
  for (std::size_t a = 0; a < vertices; ++a)
    for (int e = spec.vertex_shape.begin[a]; e < spec.vertex_shape.begin[a + 1]; ++e)
      x[a] += spec.vertex_shape.N[e] * u[spec.vertex_shape.node[e]];
  std::vector<double> change(vertices, 0), cell_volume(vertices, 0), weight(vertices, 0);
  const auto over_shear = pressureLimits(spec);
  const auto averaged = averagedShares(spec.patches);
  const auto share = [&](int vertex) { return 0.25 * averaged[static_cast<std::size_t>(vertex)]; };
  for (const auto& cell : cells)
    for (const int a : cell) {
      cell_volume[a] += share(a) * signedVolume(spec.X, cell);
      change[a] += share(a) * (signedVolume(x, cell) - signedVolume(spec.X, cell));
    }
  for (std::size_t q = 0; q < J_minus_1.size(); ++q)
    for (const int a : spec.patches.node[q])
      weight[a] = std::max(weight[a], pressedShare(K[a] * J_minus_1[q], over_shear[a] * shear[a]));
  for (std::size_t a = 0; a < vertices; ++a) {
    if (K[a] == 0) continue;
    const double limit = over_shear[a] * shear[a], p = cell_volume[a] > 0 ? K[a] * change[a] / cell_volume[a] : 0;
    const double loose = friction.empty() ? 1 : looseShare(static_cast<double>(friction[a]), shear[a]);
    const double free = K[a] * theta[a];
    weight[a] *= loose;
    result.patch_pressure[a] = free + loose * (bounded(free, limit) - free);
    result.cell_pressure[a] = weight[a] * (p - bounded(p, limit));
    result.energy +=
        spec.patches.volume[a] * (loose * boundedEnergy(free, limit, K[a]) + (1 - loose) * free * free / (2 * K[a])) +
        cell_volume[a] * weight[a] * (p * p / (2 * K[a]) - boundedEnergy(p, limit, K[a]));
  }
  for (const auto& cell : cells) {
    double p = 0;
    for (const int a : cell) p += share(a) * result.cell_pressure[a];
    const auto edge = [&](int v) { return Vec3(x[cell[v]] - x[cell[0]]); };
    for (int v = 1; v < 4; ++v) {
      const Vec3 gradient = edge(v % 3 + 1).cross(edge((v + 1) % 3 + 1)) / 6;
      force[cell[v]] -= p * gradient;
      force[cell[0]] += p * gradient;
    }
  }
  for (std::size_t a = 0; a < vertices; ++a)
    for (int e = spec.vertex_shape.begin[a]; e < spec.vertex_shape.begin[a + 1]; ++e)
      result.force[spec.vertex_shape.node[e]] += spec.vertex_shape.N[e] * force[a];
  return result;
}

template struct CellVolumeOf<float>;
template struct CellVolumeOf<double>;
template CellVolumeOf<float> makeCellVolume(const CellVolumeSpec&);
template CellVolumeOf<double> makeCellVolume(const CellVolumeSpec&);
template CellVolumeScratchOf<float> makeCellVolumeScratch(const CellVolumeOf<float>&, int);
template CellVolumeScratchOf<double> makeCellVolumeScratch(const CellVolumeOf<double>&, int);

}  // namespace palpate
