#include "model/preparation.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "discretization/surface/facet_rule.h"

namespace palpate {
namespace {

bool within(int index, std::size_t count, int lowest = 0) {
  return index >= lowest && (index < 0 || static_cast<std::size_t>(index) < count);
}

bool allWithin(const std::vector<int>& indices, std::size_t count, int lowest = 0) {
  return std::all_of(indices.begin(), indices.end(), [&](int i) { return within(i, count, lowest); });
}

template <std::size_t size>
bool allWithin(const std::vector<std::array<int, size>>& rows, std::size_t count) {
  return std::all_of(rows.begin(), rows.end(), [&](const auto& row) {
    return std::all_of(row.begin(), row.end(), [&](int i) { return within(i, count); });
  });
}

template <class Real, class Allocator>
bool allFinite(const std::vector<Real, Allocator>& values) {
  return std::all_of(values.begin(), values.end(), [](Real a) { return std::isfinite(a); });
}

bool allPositive(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double a) { return std::isfinite(a) && a > 0; });
}

bool allFinite(const std::vector<Vec3>& values) {
  return std::all_of(values.begin(), values.end(), [](const Vec3& a) { return a.allFinite(); });
}

/// Rows in order, each with ascending nodes of `nodes`: of a ShapeTable or SkinModel.
template <class Rows>
bool areRows(const Rows& table, std::size_t rows, std::size_t nodes) {
  if (rows == 0 && table.begin.empty()) return table.node.empty() && table.N.empty();
  const std::size_t entries = table.node.size();
  if (table.begin.size() != rows + 1 || table.begin.front() != 0 ||
      static_cast<std::size_t>(table.begin.back()) != entries ||
      !std::is_sorted(table.begin.begin(), table.begin.end()) || table.N.size() != entries)
    return false;
  for (std::size_t r = 0; r < rows; ++r)
    for (int e = table.begin[r] + 1; e < table.begin[r + 1]; ++e)
      if (table.node[e - 1] >= table.node[e]) return false;
  return allWithin(table.node, nodes) && allFinite(table.N);
}

bool isTable(const ShapeTable& table, std::size_t rows, std::size_t nodes, bool gradients) {
  return areRows(table, rows, nodes) && table.gradN.size() == (gradients ? table.node.size() : 0) &&
         allFinite(table.gradN);
}

/// Each imposed node once, and only such nodes at the facets.
bool isEssential(const EssentialNodes& essential, std::size_t nodes, std::size_t boundary_count) {
  std::vector<char> imposed(nodes, 0);
  for (const ImposedNode& node : essential.nodes) {
    const bool is_point = node.node == ImposedNode::point;
    if (!is_point && (!within(node.node, nodes) || imposed[node.node])) return false;
    if (is_point && *std::max_element(node.boundary.begin(), node.boundary.end()) < 0) return false;
    if (!is_point) imposed[node.node] = 1;
    for (const int boundary : node.boundary)
      if (!within(boundary, boundary_count, -1)) return false;
  }
  if (!allWithin(essential.facets, nodes)) return false;
  for (const auto& facet : essential.facets)
    for (const int node : facet)
      if (!imposed[node]) return false;
  const std::size_t samples = essential.facets.size() * FacetRule::size;
  return essential.facet_weight.size() == samples && allFinite(essential.facet_weight) &&
         isTable(essential.facet_phi, samples, nodes, false);
}

/// Of bodies with some each, one after another.
bool areEnds(const std::vector<int>& ends, std::size_t count) {
  int begin = 0;
  for (const int end : ends) {
    if (end <= begin) return false;
    begin = end;
  }
  return begin == static_cast<int>(count);
}

bool hasSoundPoints(const Preparation& p, std::size_t material_count) {
  const std::size_t points = p.point_X.size(), cells = p.cells.size();
  return points != 0 && p.point_volume.size() == points && p.point_material.size() == points &&
         p.point_cell.size() == points && (p.point_other_cell.empty() || p.point_other_cell.size() == points) &&
         allFinite(p.point_X) && allFinite(p.point_volume) && allWithin(p.point_material, material_count) &&
         allWithin(p.point_cell, cells) && allWithin(p.point_other_cell, cells, -1);
}

}  // namespace

double Preparation::addedMass() const {
  return std::accumulate(mass.begin(), mass.end(), 0.0) / std::accumulate(own_mass.begin(), own_mass.end(), 0.0) - 1;
}

double layerError(const Preparation& preparation, std::span<const Material> materials) {
  const std::vector<MissedShare>& shares = preparation.missed_shares;
  if (shares.empty()) return preparation.layer_error;
  double largest = 0, sum = 0;
  for (std::size_t k = 0; k < shares.size(); ++k) {
    const auto [softer, stiffer] = std::minmax(materials[static_cast<std::size_t>(shares[k].material)].shear_modulus,
                                               materials[static_cast<std::size_t>(shares[k].other)].shear_modulus);
    const bool begins = k == 0 || shares[k].body != shares[k - 1].body || shares[k].material != shares[k - 1].material;
    sum = (begins ? 0 : sum) + 0.5 * shares[k].share * (1 - softer / stiffer);
    largest = std::max(largest, sum);
  }
  return largest;
}

ShapeTable vertexShape(const ShapeTable& node_shape, const std::vector<int>& side_node) {
  ShapeTable shape = node_shape;
  for (const int i : side_node) {
    shape.node.push_back(i);
    shape.N.push_back(1);
    shape.begin.push_back(static_cast<int>(shape.node.size()));
  }
  return shape;
}

int Preparation::bodyOfNode(int node) const {
  return static_cast<int>(std::upper_bound(end_node.begin(), end_node.end(), node) - end_node.begin());
}

int Preparation::bodyOfPoint(int point) const {
  return static_cast<int>(std::upper_bound(end_point.begin(), end_point.end(), point) - end_point.begin());
}

bool isSound(const Preparation& p, std::size_t material_count, std::size_t boundary_count) {
  const std::size_t nodes = p.X.size(), vertices = p.skin.surface.vertices.size();
  return nodes != 0 && p.support_radius.size() == nodes && p.mass.size() == nodes && allFinite(p.X) &&
         allPositive(p.support_radius) && allPositive(p.mass) && p.own_mass.size() == nodes &&
         allPositive(p.own_mass) && allWithin(p.cells, nodes) && hasSoundPoints(p, material_count) &&
         isTable(p.point_shape, p.point_X.size(), nodes, true) && allWithin(p.side_node, nodes) &&
         allWithin(p.volume_cells, nodes + p.side_node.size()) &&
         p.volume_cells.size() == (p.vertex_group.empty() ? 0 : p.cells.size()) &&
         p.vertex_group.size() == (p.vertex_group.empty() ? p.side_node.size() : nodes + p.side_node.size()) &&
         isTable(p.node_shape, nodes, nodes, false) && areEnds(p.end_node, nodes) &&
         areEnds(p.end_point, p.point_X.size()) && p.end_node.size() == p.end_point.size() &&
         areRows(p.skin, vertices, nodes) && allFinite(p.skin.surface.vertices) &&
         allWithin(p.skin.surface.triangles, vertices) && isEssential(p.essential, nodes, boundary_count) &&
         within(p.limit.worst_node, nodes) && p.thin_layer >= -1 && p.thin_layer < static_cast<int>(material_count) &&
         std::isfinite(p.layer_error) &&
         std::all_of(p.missed_shares.begin(), p.missed_shares.end(),
                     [&](const MissedShare& s) {
                       return within(s.material, material_count) && within(s.other, material_count) &&
                              std::isfinite(s.share);
                     }) &&
         allPositive({p.limit.dt, p.limit.dt_proven, p.surface_volume, p.cell_volume}) &&
         p.cloud.on_surface.size() == p.cloud.X.size() && p.cloud.coarsest.size() == p.cloud.X.size() &&
         allFinite(p.cloud.X) && std::isfinite(p.pair_moment) &&
         std::all_of(p.cloud.coarsest.begin(), p.cloud.coarsest.end(), [](double h) { return h > 0; });
}

}  // namespace palpate
