#include "setup/sharp_interfaces.h"

#include <algorithm>
#include <bit>
#include <map>
#include <set>

#include "discretization/cells/background_cells.h"
#include "discretization/gradients/consistent_gradients.h"

namespace palpate {
namespace {

/// A face whichever way it is turned.
std::array<int, 3> sorted(std::array<int, 3> face) {
  std::sort(face.begin(), face.end());
  return face;
}

/// Rows of a table that are wanted, with the nodes numbered anew; `entry` receives where they were.
ShapeTable part(const ShapeTable& table, const std::vector<int>& rows, const std::vector<int>& number,
                std::vector<int>& entry) {
  ShapeTable some;
  some.begin.push_back(0);
  entry.clear();
  for (const int r : rows) {
    for (int e = table.begin[r]; e < table.begin[r + 1]; ++e) {
      entry.push_back(e);
      some.node.push_back(number[table.node[e]]);
      some.N.push_back(table.N[e]);
      if (!table.gradN.empty()) some.gradN.push_back(table.gradN[e]);
    }
    some.begin.push_back(static_cast<int>(some.node.size()));
  }
  return some;
}

/// Cells of one group that hang together by faces. Fewer nodes than `few` carry no approximation of their own: a linear
/// one has four coefficients, and twice as many nodes leave none of them to a sliver.
constexpr std::size_t few = 8;
constexpr std::size_t small_lump = 64;  // cells, which are given away together

struct Lumps {
  std::vector<int> lump;                // (cell_count)
  std::vector<std::vector<int>> cells;  // (lump_count)

  Lumps(const std::vector<std::array<int, 4>>& all, const std::vector<int>& group) : lump(all.size(), -1) {
    std::vector<std::vector<int>> next(all.size());
    for (const auto& [a, b] : neighbouringCells(all))
      if (group[a] == group[b]) next[a].push_back(b), next[b].push_back(a);
    for (int first = 0; first < static_cast<int>(all.size()); ++first) {
      if (lump[first] >= 0) continue;
      const int number = static_cast<int>(cells.size());
      std::vector<int> mine{first};
      lump[first] = number;
      for (std::size_t k = 0; k < mine.size(); ++k)
        for (const int c : next[mine[k]])
          if (lump[c] < 0) lump[c] = number, mine.push_back(c);
      cells.push_back(std::move(mine));
    }
  }

  std::size_t nodeCount(int number, const std::vector<std::array<int, 4>>& all) const {
    std::set<int> nodes;
    for (const int c : cells[number]) nodes.insert(all[c].begin(), all[c].end());
    return nodes.size();
  }
};

/// Gives some cells of a group to the one nearest to them.
void giveAway(const std::vector<int>& mine, const std::vector<Vec3>& centroid, std::vector<int>& group) {
  const int own = group[mine.front()];
  const Vec3 at = centroid[mine.front()];
  int nearest = -1;
  for (int c = 0; c < static_cast<int>(group.size()); ++c)
    if (group[c] != own && (nearest < 0 || (centroid[c] - at).squaredNorm() < (centroid[nearest] - at).squaredNorm()))
      nearest = c;
  if (nearest >= 0)
    for (const int c : mine) group[c] = group[nearest];
}

/// Of which groups a node has cells.
std::vector<GroupBits> groupsOfNodes(const std::vector<std::array<int, 4>>& cells, const std::vector<int>& cell_group,
                                     const std::vector<int>& node_group) {
  std::vector<GroupBits> bits(node_group.size(), 0);
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (const int i : cells[c]) bits[i] |= GroupBits{1} << cell_group[c];
  for (std::size_t i = 0; i < bits.size(); ++i)
    if (bits[i] == 0) bits[i] = GroupBits{1} << node_group[i];
  return bits;
}

}  // namespace

std::vector<int> cellGroups(const std::vector<std::array<int, 4>>& cells, const std::vector<Vec3>& centroid,
                            const std::vector<int>& cell_material) {
  std::vector<int> group = cell_material;
  for (int& g : group)
    if (g >= max_groups) g = 0;
  const Lumps lumps(cells, group);
  for (int k = 0; k < static_cast<int>(lumps.cells.size()); ++k)
    if (lumps.cells[k].size() < small_lump && lumps.nodeCount(k, cells) < few)
      giveAway(lumps.cells[k], centroid, group);
  return group;
}

void joinGroups(const std::vector<Unsupported>& places, const std::vector<std::array<int, 4>>& cells,
                const std::vector<Vec3>& centroid, std::vector<int>& group) {
  const Lumps lumps(cells, group);
  const std::vector<int> before = group;
  for (const Unsupported& place : places) {
    int nearest = -1;
    for (int c = 0; c < static_cast<int>(cells.size()); ++c)
      if ((place.group >> before[c] & 1) != 0 &&
          (nearest < 0 || (centroid[c] - place.at).squaredNorm() < (centroid[nearest] - place.at).squaredNorm()))
        nearest = c;
    if (nearest < 0 || group[nearest] != before[nearest]) continue;
    const std::vector<int>& lump = lumps.cells[lumps.lump[nearest]];
    giveAway(lump.size() <= small_lump ? lump : std::vector<int>{nearest}, centroid, group);
  }
}

SharpInterfaces sharpInterfaces(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                                const std::vector<int>& cell_group, const std::vector<int>& node_group,
                                const std::vector<int>& point_cell, const std::vector<std::uint8_t>& lumped,
                                bool loaded) {
  SharpInterfaces sharp;
  sharp.node = groupsOfNodes(cells, cell_group, node_group);
  for (const int c : point_cell) sharp.point_group.push_back(cell_group[c]);
  std::set<std::array<int, 3>> outer;
  for (const auto& face : boundaryFacets(cells)) outer.insert(sorted(face));
  const int groups = 1 + *std::max_element(cell_group.begin(), cell_group.end());
  for (int m = 0; m < groups; ++m) {
    std::vector<std::array<int, 4>> own;
    for (std::size_t c = 0; c < cells.size(); ++c)
      if (cell_group[c] == m) own.push_back(cells[c]);
    if (own.empty()) continue;
    SharpInterfaces::Side side;
    side.group = m;
    std::vector<std::array<int, 3>> free;
    std::vector<Vec3> area(X.size(), Vec3::Zero());
    std::vector<std::uint8_t> at_border(X.size(), 0);
    for (const auto& face : boundaryFacets(own)) {
      if (outer.count(sorted(face)) != 0) {
        free.push_back(face);
        continue;
      }
      const Vec3 third = (X[face[1]] - X[face[0]]).cross(X[face[2]] - X[face[0]]) / 6;
      for (const int i : face) {
        area[i] += third;
        at_border[i] = 1;
      }
    }
    for (std::size_t i = 0; i < X.size(); ++i) {
      if (!at_border[i]) continue;
      side.border_node.push_back(static_cast<int>(i));
      side.border_area.push_back(area[i]);
    }
    const BoundaryPoints samples = boundaryPoints(X, free, lumped, loaded);
    side.begin = static_cast<int>(sharp.boundary.X.size());
    sharp.boundary.append(samples, 0, samples.X.size());
    side.end = static_cast<int>(sharp.boundary.X.size());
    for (const int i : samples.node)
      sharp.sample_node.push_back(i >= 0 && (sharp.node[i] & (sharp.node[i] - 1)) != 0 ? i : -1);
    sharp.sides.push_back(std::move(side));
  }
  return sharp;
}

void correctGradients(const SharpInterfaces& sharp, ShapeTable& shape, const std::vector<Vec3>& point_X,
                      const std::vector<double>& volume, const std::vector<Vec3>& X, const ShapeTable& at_boundary,
                      double tolerance) {
  std::vector<int> number(X.size(), -1), entry, unused;
  for (const SharpInterfaces::Side& side : sharp.sides) {
    std::vector<Vec3> side_X, side_point_X;
    for (std::size_t i = 0; i < X.size(); ++i) {
      if ((sharp.node[i] >> side.group & 1) == 0) continue;
      number[i] = static_cast<int>(side_X.size());
      side_X.push_back(X[i]);
    }
    std::vector<int> rows, samples;
    std::vector<double> side_volume;
    for (std::size_t q = 0; q < point_X.size(); ++q) {
      if (sharp.point_group[q] != side.group) continue;
      rows.push_back(static_cast<int>(q));
      side_point_X.push_back(point_X[q]);
      side_volume.push_back(volume[q]);
    }
    for (int k = side.begin; k < side.end; ++k) samples.push_back(k);
    ShapeTable points = part(shape, rows, number, entry), faces = part(at_boundary, samples, number, unused);
    BoundaryPoints boundary;
    boundary.append(sharp.boundary, static_cast<std::size_t>(side.begin), static_cast<std::size_t>(side.end));
    for (std::size_t k = 0; k < side.border_node.size(); ++k) {  // the border's, as further samples
      boundary.add(X[side.border_node[k]], side.border_area[k]);
      faces.node.push_back(number[side.border_node[k]]);
      faces.N.push_back(1);
      faces.begin.push_back(static_cast<int>(faces.node.size()));
    }
    correctGradients(points, side_point_X, side_volume, side_X, boundary, faces, tolerance);
    for (std::size_t e = 0; e < entry.size(); ++e) shape.gradN[entry[e]] = points.gradN[e];
  }
}

std::vector<GroupBits> bitsOf(const std::vector<int>& group) {
  std::vector<GroupBits> bits;
  for (const int g : group) bits.push_back(GroupBits{1} << g);
  return bits;
}

VolumeVertices volumeVertices(const std::vector<GroupBits>& node, const std::vector<std::array<int, 4>>& cells,
                              const std::vector<int>& cell_group) {
  VolumeVertices vertices;
  std::map<std::pair<int, int>, int> side;  // of a node and a group that is not its first
  vertices.group.resize(node.size());
  for (int i = 0; i < static_cast<int>(node.size()); ++i) {
    vertices.group[i] = node[i] & (~node[i] + 1);
    for (GroupBits rest = node[i] ^ vertices.group[i]; rest != 0; rest &= rest - 1) {
      side[{i, std::countr_zero(rest)}] = static_cast<int>(node.size() + vertices.side_node.size());
      vertices.side_node.push_back(i);
      vertices.group.push_back(rest & (~rest + 1));
    }
  }
  vertices.cells = cells;
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (int& i : vertices.cells[c])
      if ((vertices.group[i] >> cell_group[c] & 1) == 0) i = side.at({i, cell_group[c]});
  return vertices;
}

std::vector<int> SharpInterfaces::borderNodes() const {
  std::vector<int> border(node.size(), -1);
  for (std::size_t i = 0; i < node.size(); ++i)
    if ((node[i] & (node[i] - 1)) != 0) border[i] = static_cast<int>(i);
  return border;
}

ShapeTable withOwnRows(const ShapeTable& table, const std::vector<int>& node) {
  ShapeTable result;
  result.begin.push_back(0);
  for (int r = 0; r < table.rowCount(); ++r) {
    if (node[r] >= 0) {
      result.node.push_back(node[r]);
      result.N.push_back(1);
      if (!table.gradN.empty()) result.gradN.push_back(Vec3::Zero());
    }
    for (int e = table.begin[r]; node[r] < 0 && e < table.begin[r + 1]; ++e) {
      result.node.push_back(table.node[e]);
      result.N.push_back(table.N[e]);
      if (!table.gradN.empty()) result.gradN.push_back(table.gradN[e]);
    }
    result.begin.push_back(static_cast<int>(result.node.size()));
  }
  return result;
}

}  // namespace palpate
