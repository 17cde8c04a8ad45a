#include "setup/body_points.h"

#include <algorithm>
#include <limits>

#include "setup/approximate.h"

namespace palpate {
namespace {

// Integration points around a place, that of its cell among them: of 20,000 places in the livers with lumps and kidney
// the cell's is beyond 6 of 275 and 295, beyond 12 of 80 and 100, beyond 24 of 53 and 69, beyond 48 of as many: these
// lie outside of all cells, below a bulging skin.
constexpr int looked_at = 24;

/// Of the groups of cells that end at borders between materials, that of an integration point.
std::uint64_t groupOf(const Body& model, int q) {
  return model.vertex_group[model.volume_cells[model.point_cell[q]].front()];
}

SupportGroups groupsAt(const Body& model, const std::vector<Vec3>& points, const std::vector<int>& body) {
  SupportGroups groups;
  if (model.vertex_group.empty()) return groups;
  groups.node.assign(model.vertex_group.begin(), model.vertex_group.begin() + model.nodeCount());
  for (std::size_t k = 0; k < model.side_node.size(); ++k)
    groups.node[model.side_node[k]] |= model.vertex_group[model.X.size() + k];
  for (const int q : nearestPoints(model, points, body)) groups.row.push_back(groupOf(model, q));
  return groups;
}

/// Calls each(p, rows) for the rows of each body that has some.
template <class Each>
void forEachBody(const Body& model, const std::vector<int>& body, Each each) {
  for (int p = 0; p < model.bodyCount(); ++p) {
    std::vector<int> rows;
    for (std::size_t r = 0; r < body.size(); ++r)
      if (body[r] == p) rows.push_back(static_cast<int>(r));
    if (!rows.empty()) each(p, rows);
  }
}

template <class T>
std::vector<T> picked(const std::vector<T>& all, const std::vector<int>& rows) {
  std::vector<T> some;
  some.reserve(rows.size());
  for (const int r : rows) some.push_back(all[static_cast<std::size_t>(r)]);
  return some;
}

/// Tables of some rows each, as one. @param rows  which of the whole those of each table are
ShapeTable merged(const std::vector<ShapeTable>& tables, const std::vector<std::vector<int>>& rows, std::size_t count) {
  std::vector<std::pair<int, int>> from(count);  // table, its row
  for (std::size_t t = 0; t < rows.size(); ++t)
    for (std::size_t r = 0; r < rows[t].size(); ++r)
      from[static_cast<std::size_t>(rows[t][r])] = {static_cast<int>(t), static_cast<int>(r)};
  ShapeTable all;
  all.begin.push_back(0);
  for (const auto& [t, r] : from) {
    const ShapeTable& table = tables[static_cast<std::size_t>(t)];
    all.append(table, r);
  }
  return all;
}

/// The smallest of a point's barycentric coordinates in a cell: not negative inside of it.
double depthIn(const Body& model, int cell, const Vec3& x) {
  const auto& corner = model.cells[static_cast<std::size_t>(cell)];
  const auto at = [&](int k) -> const Vec3& { return model.X[static_cast<std::size_t>(corner[k])]; };
  Mat3 edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = at(k + 1) - at(0);
  const Vec3 share = edges.partialPivLu().solve(x - at(0));
  return std::min(share.minCoeff(), 1 - share.sum());
}

/// Of integration points in the order of their distance the one whose cell has the point, where borders are near.
int ownPoint(const Body& model, const std::vector<int>& by_distance, const Vec3& x) {
  constexpr double rounding = 1e-9;
  const auto isOther = [&](int q) { return groupOf(model, q) != groupOf(model, by_distance.front()); };
  if (std::none_of(by_distance.begin(), by_distance.end(), isOther)) return by_distance.front();
  int deepest = by_distance.front();
  double most = -std::numeric_limits<double>::infinity();
  for (const int q : by_distance) {
    double depth = depthIn(model, model.point_cell[q], x);
    if (!model.point_other_cell.empty() && model.point_other_cell[q] >= 0)
      depth = std::max(depth, depthIn(model, model.point_other_cell[q], x));
    if (depth > -rounding) return q;
    if (depth > most) most = depth, deepest = q;
  }
  return deepest;
}

std::vector<int> nearestOf(const std::vector<Vec3>& X, double spacing, const std::vector<Vec3>& points) {
  const Neighbours tree(X, std::vector<double>(X.size(), spacing));
  std::vector<int> nearest;
  for (const Vec3& x : points) nearest.push_back(tree.nearest(x, 1).front());
  return nearest;
}

}  // namespace

std::vector<int> bodiesAt(const Body& model, const std::vector<Vec3>& points) {
  if (model.bodyCount() == 1) return std::vector<int>(points.size(), 0);
  std::vector<int> body = nearestOf(model.point_X, model.scene.discretization.spacing, points);
  for (int& q : body) q = model.bodyOfPoint(q);
  return body;
}

std::vector<int> nearestPoints(const Body& model, const std::vector<Vec3>& points, const std::vector<int>& body) {
  std::vector<int> nearest(points.size());
  forEachBody(model, body, [&](int p, const std::vector<int>& rows) {
    const int begin = p == 0 ? 0 : model.end_point[static_cast<std::size_t>(p) - 1];
    const std::vector<Vec3> own(model.point_X.begin() + begin,
                                model.point_X.begin() + model.end_point[static_cast<std::size_t>(p)]);
    const Neighbours tree(own, std::vector<double>(own.size(), model.scene.discretization.spacing));
    for (const int row : rows) {
      const auto r = static_cast<std::size_t>(row);
      std::vector<int> found = tree.nearest(points[r], model.vertex_group.empty() ? 1 : looked_at);
      for (int& q : found) q += begin;
      nearest[r] = model.vertex_group.empty() ? found.front() : ownPoint(model, found, points[r]);
    }
  });
  return nearest;
}

ShapeTable shapeAt(const Body& model, const std::vector<Vec3>& points, const std::vector<int>& body) {
  const MmlsOptions options{model.scene.discretization.basis_degree, model.scene.discretization.mmls_weight};
  const SupportGroups groups = groupsAt(model, points, body);
  const std::vector<std::uint8_t> lonely = lonelyNodes(model.point_shape, model.X.size());
  std::vector<ShapeTable> tables;
  std::vector<std::vector<int>> of;
  forEachBody(model, body, [&](int p, const std::vector<int>& rows) {
    SupportGroups own = groups;
    if (!own.row.empty()) own.row = picked(groups.row, rows);
    Sight sight(*model.gaps[static_cast<std::size_t>(p)], model.X.size(), model.cells);
    sight.lonely = lonely;
    const std::vector<Vec3> at = picked(points, rows);
    const Neighbours neighbours(model.X, model.support_radius, sight.limit());
    std::vector<InadmissibleSupport> failed;
    ShapeTable table = shapeFunctions(at, model.X, model.support_radius, neighbours, options, failed, own);
    const auto mayFollow = [&](int row, int q) {
      return model.bodyOfPoint(q) == p &&
             (own.row.empty() || (own.row[static_cast<std::size_t>(row)] & groupOf(model, q)) != 0);
    };
    if (!failed.empty()) followPoints(at, failed, model.point_X, model.point_shape, mayFollow, sight.gaps, table);
    tables.push_back(std::move(table));
    of.push_back(rows);
  });
  return tables.size() == 1 ? std::move(tables.front()) : merged(tables, of, points.size());
}

}  // namespace palpate
