#include "setup/body_points.h"

#include "setup/approximate.h"

namespace palpate {
namespace {

SupportGroups groupsAt(const Body& model, const std::vector<Vec3>& points) {
  SupportGroups groups;
  if (model.vertex_group.empty()) return groups;
  groups.node.assign(model.vertex_group.begin(), model.vertex_group.begin() + model.nodeCount());
  for (std::size_t k = 0; k < model.side_node.size(); ++k)
    groups.node[model.side_node[k]] |= model.vertex_group[model.X.size() + k];
  for (const int q : nearestPoints(model, points))
    groups.row.push_back(model.vertex_group[model.volume_cells[model.point_cell[q]].front()]);
  return groups;
}

}  // namespace

std::vector<int> nearestPoints(const Body& model, const std::vector<Vec3>& points) {
  const Neighbours tree(model.point_X, std::vector<double>(model.point_X.size(), model.scene.discretization.spacing));
  std::vector<int> nearest;
  for (const Vec3& X : points) nearest.push_back(tree.nearest(X, 1).front());
  return nearest;
}

ShapeTable shapeAt(const Body& model, const std::vector<Vec3>& points, std::vector<InadmissibleSupport>& failed) {
  return shapeFunctions(points, model.X, model.support_radius,
                        Neighbours(model.X, model.support_radius, endingAt(*model.gaps)),
                        {model.scene.discretization.basis_degree, model.scene.discretization.mmls_weight}, failed, {},
                        groupsAt(model, points));
}

}  // namespace palpate
