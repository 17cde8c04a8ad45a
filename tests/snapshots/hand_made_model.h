#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "model/model.h"
#include "realtime/channels/snapshot.h"

namespace palpate {

/// Shape functions that need no solver: quartic-spline weights of the nodes in reach, normalised
/// (Shepard), with their gradients. They reproduce constants, which is all that a picture needs.
inline ShapeTable shepardShape(const std::vector<Vec3>& nodes, double reach, const std::vector<Vec3>& points) {
  ShapeTable shape;
  shape.begin.push_back(0);
  for (const Vec3& p : points) {
    double sum = 0;
    Vec3 grad_sum = Vec3::Zero();
    const std::size_t first = shape.node.size();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Vec3 d = p - nodes[i];
      const double s = d.norm() / reach;
      if (s >= 1) continue;
      const double w = 1 - s * s * (6 - s * (8 - 3 * s));               // 1 - 6 s^2 + 8 s^3 - 3 s^4
      const Vec3 grad = -12 * (1 - s) * (1 - s) / (reach * reach) * d;  // its gradient
      shape.node.push_back(static_cast<int>(i));
      shape.N.push_back(w);
      shape.gradN.push_back(grad);
      sum += w;
      grad_sum += grad;
    }
    for (std::size_t k = first; k < shape.node.size(); ++k) {
      shape.gradN[k] = (shape.gradN[k] - shape.N[k] / sum * grad_sum) / sum;
      shape.N[k] /= sum;
    }
    shape.begin.push_back(static_cast<int>(shape.node.size()));
  }
  return shape;
}

/// A model to look at, made by hand around a roundish surface: a grid of nodes and of
/// integration points in and just around the ellipsoid of its bounding box, Shepard shape functions, soft
/// neo-Hookean tissue, the lowest
/// nodes imposed. Nothing here can be stepped.
inline Model handMadeModel(TriangleSurface surface, double spacing, const ToolShape& tool, double node_reach = 1) {
  Model model;
  model.tools.body[0].shape = model.scene.tools[0].shape = tool;
  Eigen::AlignedBox3d box;
  for (const Vec3& X : surface.vertices) box.extend(X);
  const Vec3 low = box.min() - Vec3::Constant(0.5 * spacing);
  const Eigen::Vector3i count = ((box.max() - low) / spacing).array().ceil().cast<int>() + 1;
  for (int z = 0; z < count.z(); ++z)
    for (int y = 0; y < count.y(); ++y)
      for (int x = 0; x < count.x(); ++x) {
        const Vec3 node = low + spacing * Vec3(x, y, z), half = 0.5 * box.sizes();
        // Far enough out that each point of the skin has nodes on all sides; a box needs its corners.
        if ((node - box.center()).cwiseQuotient(half + Vec3::Constant(0.8 * spacing)).norm() > node_reach) continue;
        model.X.push_back(node);
        model.imposed.push_back(model.X.back().z() < box.min().z() + 0.18 * box.sizes().z() ? 7 : 0);
        const Vec3 point = model.X.back() + Vec3::Constant(0.5 * spacing);
        if ((point - box.center()).cwiseQuotient(half).norm() < 1) model.point_X.push_back(point);
      }
  const double reach = 1.9 * spacing;
  model.support_radius.assign(model.X.size(), reach);
  model.point_volume.assign(model.point_X.size(), spacing * spacing * spacing);
  model.point_material.assign(model.point_X.size(), 0);
  model.point_shape = shepardShape(model.X, reach, model.point_X);
  model.materials = {Material::neoHookean(3000, 0.49, 1000)};
  setRows(shepardShape(model.X, reach, surface.vertices), model.skin);
  model.skin.area.assign(surface.vertices.size(), 0.0);
  for (const auto& t : surface.triangles) {
    const Vec3& a = surface.vertices[t[0]];
    const double third = (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a).norm() / 6;
    for (const int v : t) model.skin.area[v] += third;
  }
  model.skin.surface = std::move(surface);
  return model;
}

/// A sphere of 20 * 4^subdivisions triangles from an icosahedron, stretched to the semi-axes.
inline TriangleSurface ellipsoidSurface(const Vec3& semi_axes, int subdivisions) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  TriangleSurface s;
  s.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  s.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                 {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                 {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int round = 0; round < subdivisions; ++round) {
    std::map<std::pair<int, int>, int> middle;
    const auto between = [&](int a, int b) {
      const auto [entry, fresh] = middle.try_emplace({std::min(a, b), std::max(a, b)}, s.vertices.size());
      if (fresh) s.vertices.push_back(s.vertices[a].normalized() + s.vertices[b].normalized());
      return entry->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : s.triangles) {
      const int ab = between(a, b), bc = between(b, c), ca = between(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    s.triangles = std::move(finer);
  }
  for (Vec3& v : s.vertices) v = v.normalized().cwiseProduct(semi_axes);
  return s;
}

/// The model at rest with the tool standing at `tip`, upright.
inline Snapshot restSnapshot(const Model& model, const Vec3& tip) {
  Snapshot snapshot;
  snapshot.u.assign(model.X.size(), Float4{});
  ToolPosture tool;
  tool.pose.position = tip;
  snapshot.tools.set(0, tool, {});
  return snapshot;
}

/// Presses a dent of `depth` straight down at `place`, fading over `width`, and reports a force there.
inline void pressDent(const Model& model, const Vec3& place, double depth, double width, Snapshot& snapshot) {
  for (std::size_t i = 0; i < model.X.size(); ++i) {
    const double r = (model.X[i] - place).norm() / width;
    snapshot.u[i] = toFloat4(Vec3(0, 0, -depth * std::exp(-r * r)));
  }
  snapshot.force.force_raw = snapshot.force.force_filtered = Vec3(0, 0, 1.5);
  for (std::size_t v = 0; v < model.skin.surface.vertices.size(); ++v)
    if ((model.skin.surface.vertices[v] - place).norm() < 0.4 * width) {
      snapshot.contact_vertex.push_back(static_cast<int>(v));
      snapshot.contact_force.push_back(toFloat4(Vec3(0, 0, -0.02)));
    }
  snapshot.contact_count = static_cast<int>(snapshot.contact_vertex.size());
}

}  // namespace palpate
