#include "simulation/sharp_interfaces.h"

#include <algorithm>
#include <bit>
#include <set>

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
      some.gradN.push_back(table.gradN[e]);
    }
    some.begin.push_back(static_cast<int>(some.node.size()));
  }
  return some;
}

}  // namespace

SharpInterfaces sharpInterfaces(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                                const std::vector<int>& cell_material, const std::vector<int>& node_material,
                                const std::vector<int>& point_cell, const std::vector<std::uint8_t>& lumped) {
  SharpInterfaces sharp;
  sharp.node = materialsOfNodes(cells, cell_material, node_material);
  for (const int c : point_cell) sharp.point_material.push_back(cell_material[c]);
  std::set<std::array<int, 3>> outer;
  for (const auto& face : boundaryFacets(cells)) outer.insert(sorted(face));
  const int materials = 1 + *std::max_element(cell_material.begin(), cell_material.end());
  for (int m = 0; m < materials; ++m) {
    std::vector<std::array<int, 4>> own;
    for (std::size_t c = 0; c < cells.size(); ++c)
      if (cell_material[c] == m) own.push_back(cells[c]);
    if (own.empty()) continue;
    SharpInterfaces::Side side;
    side.material = m;
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
    const BoundaryPoints samples = boundaryPoints(X, free, lumped);
    side.begin = static_cast<int>(sharp.boundary.X.size());
    sharp.boundary.X.insert(sharp.boundary.X.end(), samples.X.begin(), samples.X.end());
    sharp.boundary.area.insert(sharp.boundary.area.end(), samples.area.begin(), samples.area.end());
    side.end = static_cast<int>(sharp.boundary.X.size());
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
      if ((sharp.node[i] >> side.material & 1) == 0) continue;
      number[i] = static_cast<int>(side_X.size());
      side_X.push_back(X[i]);
    }
    std::vector<int> rows, samples;
    std::vector<double> side_volume;
    for (std::size_t q = 0; q < point_X.size(); ++q) {
      if (sharp.point_material[q] != side.material) continue;
      rows.push_back(static_cast<int>(q));
      side_point_X.push_back(point_X[q]);
      side_volume.push_back(volume[q]);
    }
    for (int k = side.begin; k < side.end; ++k) samples.push_back(k);
    ShapeTable points = part(shape, rows, number, entry), faces = part(at_boundary, samples, number, unused);
    BoundaryPoints boundary;
    boundary.X.assign(sharp.boundary.X.begin() + side.begin, sharp.boundary.X.begin() + side.end);
    boundary.area.assign(sharp.boundary.area.begin() + side.begin, sharp.boundary.area.begin() + side.end);
    for (std::size_t k = 0; k < side.border_node.size(); ++k) {  // the border's, as further samples
      boundary.X.push_back(X[side.border_node[k]]);
      boundary.area.push_back(side.border_area[k]);
      faces.node.push_back(number[side.border_node[k]]);
      faces.N.push_back(1);
      faces.begin.push_back(static_cast<int>(faces.node.size()));
    }
    correctGradients(points, side_point_X, side_volume, side_X, boundary, faces, tolerance);
    for (std::size_t e = 0; e < entry.size(); ++e) shape.gradN[entry[e]] = points.gradN[e];
  }
}

std::vector<MaterialBits> bitsOf(const std::vector<int>& material) {
  std::vector<MaterialBits> bits;
  for (const int m : material) bits.push_back(MaterialBits{1} << m);
  return bits;
}

std::vector<MaterialBits> firstBits(const std::vector<MaterialBits>& bits) {
  std::vector<MaterialBits> first;
  for (const MaterialBits b : bits) first.push_back(MaterialBits{1} << std::countr_zero(b));
  return first;
}

}  // namespace palpate
