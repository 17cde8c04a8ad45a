#include "model/held_tissue.h"

#include <algorithm>
#include <limits>

namespace palpate {
namespace {

using Holders = std::array<int, 3>;
constexpr Holders free_node{-1, -1, -1};

/// By node: the boundaries that hold its components; free_node: one is free, or moved.
std::vector<Holders> holdersOf(const Body& body) {
  std::vector<Holders> holders(body.X.size(), free_node);
  for (const ImposedNode& imposed : body.essential.nodes) {
    if (imposed.node == ImposedNode::point) continue;
    const auto stands = [&](int b) { return b >= 0 && !body.essential.motions[static_cast<std::size_t>(b)].moves(); };
    if (std::all_of(imposed.boundary.begin(), imposed.boundary.end(), stands))
      holders[static_cast<std::size_t>(imposed.node)] = imposed.boundary;
  }
  return holders;
}

}  // namespace

HeldTissue heldTissue(const Body& body) {
  HeldTissue held;
  const std::vector<Holders> holders = holdersOf(body);
  if (std::all_of(holders.begin(), holders.end(), [](const Holders& h) { return h == free_node; })) return held;

  // Of those that a row has entries of, which are all around a point; -1: there is no other.
  const auto nearestIn = [&](const std::vector<int>& begin, const std::vector<int>& node, std::size_t row,
                             const Vec3& x, int but) {
    int nearest = -1;
    for (int e = begin[row]; e < begin[row + 1]; ++e) {
      const int i = node[e];
      if (i != but && (nearest < 0 || (body.X[i] - x).squaredNorm() < (body.X[nearest] - x).squaredNorm())) nearest = i;
    }
    return nearest;
  };
  held.least_clearance = std::numeric_limits<double>::infinity();
  const auto add = [&](const Vec3& x, const Vec3& outward, std::size_t node) {
    const Vec3& X = body.X[node];
    const int other = nearestIn(body.node_shape.begin, body.node_shape.node, node, X, static_cast<int>(node));
    const double apart = other < 0 ? 0 : (body.X[other] - X).norm();
    held.points.push_back({x, outward, HeldTissue::clearance * apart, holders[node]});
    const Vec3 around = Vec3::Constant(held.points.back().clearance);
    held.box.extend(x + around).extend(x - around);
    held.least_clearance = std::min(held.least_clearance, around.x());
  };
  const std::vector<Vec3>& normal = body.bodies.normal;
  std::vector<bool> at_skin(body.X.size(), false);
  for (std::size_t v = 0; v < normal.size(); ++v) {
    const Vec3& x = body.skin.surface.vertices[v];
    const auto node = static_cast<std::size_t>(nearestIn(body.skin.begin, body.skin.node, v, x, -1));
    at_skin[node] = true;
    if (holders[node] != free_node) add(x, normal[v], node);
  }
  for (std::size_t i = 0; i < holders.size(); ++i)
    if (holders[i] != free_node && !at_skin[i]) add(body.X[i], Vec3::Zero(), i);
  return held;
}

}  // namespace palpate
