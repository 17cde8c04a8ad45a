#include "setup/imposed_nodes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "discretization/surface/facet_rule.h"
#include "scene/scene_messages.h"
#include "scene/scene_regions.h"

namespace palpate {
BoundaryMotion motionOf(const BoundarySpec& spec) {
  return {spec.translation, spec.axis_point, spec.axis, spec.angle, spec.duration, spec.curve};
}

namespace {

/// True where both impose the same displacement on what stands at X, at all times.
bool agree(const BoundarySpec& a, const BoundarySpec& b, const Vec3& X, int component) {
  const BoundaryMotion p = motionOf(a), q = motionOf(b);
  if (!p.moves() && !q.moves()) return true;
  // Curves are polynomials or linear between their tables' times: equal at these and at a few times more, they are
  // equal.
  constexpr int samples = 16;
  const double end = std::max({p.duration, q.duration, p.curve.time.empty() ? 0 : p.curve.time.back(),
                               q.curve.time.empty() ? 0 : q.curve.time.back()});
  std::vector<double> times;
  for (int k = 1; k <= samples; ++k) times.push_back(end * k / samples);
  for (const auto* curve : {&p.curve, &q.curve})
    for (std::size_t k = 1; k < curve->time.size(); ++k) {
      times.push_back(curve->time[k]);
      times.push_back((curve->time[k - 1] + curve->time[k]) / 2);
    }
  return std::all_of(times.begin(), times.end(),
                     [&](double t) { return std::abs((p.at(X, t) - q.at(X, t))[component]) <= 1e-12; });
}

}  // namespace

namespace {

bool isChosen(const BoundarySpec& spec, const NodeCloud& cloud, int i, const SurfaceTree& organ) {
  return (!spec.surface_only || cloud.on_surface[i]) && contains(spec.region, cloud.X[i], organ);
}

/// Adds a row for a point between the nodes. Nodes that are imposed nearer than half the spacing would leave the two no
/// independent displacements.
void addPoint(const Scene& scene, int b, const NodeCloud& cloud, EssentialNodes& essential) {
  const BoundarySpec& spec = scene.boundaries[b];
  const Vec3& X = spec.region.point;
  for (std::size_t k = 0; k < essential.nodes.size(); ++k) {
    const ImposedNode& other = essential.nodes[k];
    const Vec3& at = other.node < 0 ? essential.X[k] : cloud.X[other.node];
    if ((at - X).norm() >= 0.5 * scene.discretization.spacing) continue;
    const int owner = *std::max_element(other.boundary.begin(), other.boundary.end());
    throw InputError(spec.region.place.file.empty() ? spec.place : spec.region.place,
                     inQuotes(spec.name) + ", at " + coordinates(X) +
                         ", is nearer than half the spacing to what is imposed at " +
                         scene.boundaries[owner].place.text(),
                     "make that region smaller, or leave the point out");
  }
  ImposedNode row{ImposedNode::point, {-1, -1, -1}};
  for (int c = 0; c < 3; ++c)
    if (spec.component[c]) row.boundary[c] = b;
  essential.nodes.push_back(row);
  essential.X.push_back(X);
}

}  // namespace

EssentialNodes chooseImposed(const Scene& scene, const NodeCloud& cloud, const SurfaceTree& organ) {
  EssentialNodes essential;
  std::vector<int> slot(cloud.X.size(), -1);
  for (int b = 0; b < static_cast<int>(scene.boundaries.size()); ++b) {
    const auto& spec = scene.boundaries[b];
    essential.motions.push_back(motionOf(spec));
    if (spec.region.kind == Region::Kind::Point) {
      addPoint(scene, b, cloud, essential);
      continue;
    }
    for (int i = 0; i < static_cast<int>(cloud.X.size()); ++i) {
      if (!isChosen(spec, cloud, i, organ)) continue;
      if (slot[i] < 0) {
        slot[i] = static_cast<int>(essential.nodes.size());
        essential.nodes.push_back({i, {-1, -1, -1}});
        essential.X.push_back(cloud.X[i]);
      }
      auto& owner = essential.nodes[slot[i]].boundary;
      for (int c = 0; c < 3; ++c) {
        if (!spec.component[c]) continue;
        if (owner[c] < 0) owner[c] = b;  // of boundaries that agree the first has the reaction
        if (!agree(spec, scene.boundaries[owner[c]], cloud.X[i], c))
          throw InputError(spec.place,
                           "the node at " + coordinates(cloud.X[i]) + " is also imposed, with another motion, at " +
                               scene.boundaries[owner[c]].place.text(),
                           "make the regions disjoint, or impose other components");
      }
    }
  }
  return essential;
}

bool choosesNode(const BoundarySpec& spec, const NodeCloud& cloud, const SurfaceTree& organ) {
  if (spec.region.kind == Region::Kind::Point) return true;
  for (int i = 0; i < static_cast<int>(cloud.X.size()); ++i)
    if (isChosen(spec, cloud, i, organ)) return true;
  return false;
}

void refuseEmpty(const Scene& scene, const BoundarySpec& spec) {
  throw InputError(spec.place, "no node lies in this region",
                   "move or enlarge it (node spacing is " + number(scene.discretization.spacing) + " m)");
}

void checkHeld(const Scene& scene, const EssentialNodes& essential, std::size_t node_count) {
  const auto stands = [&](const ImposedNode& row) {
    return std::all_of(row.boundary.begin(), row.boundary.end(),
                       [&](int b) { return b >= 0 && scene.boundaries[static_cast<std::size_t>(b)].duration == 0; });
  };
  if (static_cast<std::size_t>(std::count_if(essential.nodes.begin(), essential.nodes.end(), stands)) == node_count)
    throw InputError(scene.boundaries.front().place, "all nodes are fixed: nothing of the organ can move",
                     "make the region smaller, or surface_only = true");
  if (!scene.rigid.empty()) return;  // it may lie on them
  if (std::any_of(scene.boundaries.begin(), scene.boundaries.end(),
                  [](const BoundarySpec& b) { return b.duration == 0; }))
    return;
  const Box3 box = boxOf(essential.X);
  const double length = std::max(box.diagonal().norm(), scene.discretization.spacing);
  // Each imposed component of a place X stops one mix of the shifts t and the turns w: (t + w x X) e_c.
  Eigen::Matrix<double, 6, 6> stopped = Eigen::Matrix<double, 6, 6>::Zero();
  for (std::size_t k = 0; k < essential.nodes.size(); ++k)
    for (int c = 0; c < 3; ++c) {
      if (essential.nodes[k].boundary[c] < 0) continue;
      Eigen::Matrix<double, 6, 1> row;
      row << Vec3::Unit(c), (essential.X[k] - box.center()).cross(Vec3::Unit(c)) / length;
      stopped += row * row.transpose();
    }
  const Eigen::Matrix<double, 6, 1> hold =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>>(stopped, Eigen::EigenvaluesOnly).eigenvalues();
  constexpr double least = 1e-4;  // of the best: a lever of a hundredth of what is imposed
  const auto free = (hold.array() < least * hold.maxCoeff()).count();
  if (free == 0) return;
  throw InputError(scene.boundaries.front().place,
                   "nothing is fixed, and what is prescribed leaves the organ " + std::to_string(free) +
                       " of its six motions as a whole (three shifts, three turns)",
                   "add [[fixed]], or prescribe all components at three places that are not in line");
}

std::vector<Vec3> essentialFacets(const NodeCloud& cloud, const std::vector<std::array<int, 3>>& outer,
                                  EssentialNodes& essential) {
  std::vector<bool> imposed(cloud.X.size(), false);
  for (const auto& node : essential.nodes)
    if (node.node >= 0) imposed[node.node] = true;
  std::vector<Vec3> points;
  essential.facet_points = FacetRule::size;
  for (const auto& f : outer) {
    if (!imposed[f[0]] || !imposed[f[1]] || !imposed[f[2]]) continue;
    essential.facets.push_back(f);
    const double area = (cloud.X[f[1]] - cloud.X[f[0]]).cross(cloud.X[f[2]] - cloud.X[f[0]]).norm() / 2;
    for (int k = 0; k < FacetRule::size; ++k) {
      points.push_back(FacetRule::point(k, cloud.X[f[0]], cloud.X[f[1]], cloud.X[f[2]]));
      essential.facet_weight.push_back(area * FacetRule::weight(k) * FacetRule::corners(k));
    }
  }
  return points;
}

std::vector<std::uint8_t> imposedComponents(const std::vector<ImposedNode>& nodes, std::size_t node_count) {
  std::vector<std::uint8_t> imposed(node_count, 0);
  for (const auto& node : nodes)
    for (int c = 0; c < 3; ++c)
      if (node.node >= 0 && node.boundary[c] >= 0) imposed[node.node] |= static_cast<std::uint8_t>(1u << c);
  return imposed;
}

ShapeTable rowsOf(const ShapeTable& table, const std::vector<ImposedNode>& nodes, const ShapeTable& point_table) {
  ShapeTable rows;
  rows.begin.push_back(0);
  int point = 0;
  for (const auto& node : nodes)
    node.node < 0 ? rows.appendValues(point_table, point++) : rows.appendValues(table, node.node);
  return rows;
}

}  // namespace palpate
