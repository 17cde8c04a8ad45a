#pragma once

#include <cmath>
#include <vector>

#include "contact/contact.h"

namespace palpate {

/// A patch of skin z = 0 over a grid of nodes that are springs to the ground: the smallest tissue that
/// contact can be tested on. Shape functions are biquadratic B-splines (9 nodes, sum 1, not interpolating),
/// time integration is the paper's eq. 12. Its closed forms are those of a Winkler foundation.
struct SpringBed {
  struct Spec {
    double half_width = 0.03;      // m, of the skin
    double node_spacing = 0.005;   // m
    double skin_spacing = 0.0025;  // m
    double foundation = 1.5e5;     // Pa/m, springs along z per area
    double lateral = 1.5e5;        // Pa/m, along x and y
    double tension = 0.0;          // N/m, coupling of neighbouring nodes (a Pasternak layer); 10 is tissue-like
    double surface_density = 5.0;  // kg/m^2
    double damping = 20.0;         // 1/s
    double dt = 2e-4;              // s
    double young = 3000.0;         // Pa, sets the contact layer
    double tool_radius = 0.01;     // m, likewise
  };

  explicit SpringBed(const Spec& s) : spec(s) {
    const int cells = static_cast<int>(std::ceil(2.0 * s.half_width / s.node_spacing));
    side = cells + 2;  // node (i, j) stands in the middle of cell (i - 1, j - 1)
    const int edges = static_cast<int>(std::lround(2.0 * s.half_width / s.skin_spacing));
    TriangleSurface surface;
    ShapeTable shape;
    shape.begin.push_back(0);
    for (int j = 0; j <= edges; ++j) {
      for (int i = 0; i <= edges; ++i) {
        const double x = 2.0 * s.half_width * i / edges, y = 2.0 * s.half_width * j / edges;
        surface.vertices.emplace_back(x - s.half_width, y - s.half_width, 0.0);
        const auto [cx, wx] = splineWeights(x / s.node_spacing, cells);
        const auto [cy, wy] = splineWeights(y / s.node_spacing, cells);
        for (int b = 0; b < 3; ++b) {
          for (int a = 0; a < 3; ++a) {
            shape.node.push_back((cy + b) * side + cx + a);
            shape.N.push_back(wx[a] * wy[b]);
          }
        }
        shape.begin.push_back(static_cast<int>(shape.node.size()));
      }
    }
    const int row = edges + 1;
    for (int j = 0; j < edges; ++j) {
      for (int i = 0; i < edges; ++i) {
        const int v = j * row + i;
        // Diagonals by turns, so that areas have no preferred direction.
        if ((i + j) % 2 == 0) {
          surface.triangles.push_back({v, v + 1, v + row + 1});
          surface.triangles.push_back({v, v + row + 1, v + row});
        } else {
          surface.triangles.push_back({v, v + 1, v + row});
          surface.triangles.push_back({v + 1, v + row + 1, v + row});
        }
      }
    }
    skin = buildSkinModel(surface, shape);
    skin.layer_depth = 0.002 * s.tool_radius;
    skin.layer.assign(skin.area.size(), static_cast<float>(s.young / skin.layer_depth));
    skin.topology = std::make_shared<const SkinTopology>(makeSkinTopology(surface));
    scratch = ContactScratch(skin);
    const double node_area = s.node_spacing * s.node_spacing;
    const std::size_t n = static_cast<std::size_t>(side) * side;
    mass = s.surface_density * node_area;
    // Each spring stands for the skin's area that hangs on its node, so that an even pressure on the
    // skin gives an even displacement, up to the border.
    area.assign(n, 0.0);
    for (int v = 0; v < skin.vertexCount(); ++v) {
      for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e) area[skin.node[e]] += skin.N[e] * skin.area[v];
    }
    inverse_mass.assign(n, static_cast<float>(1.0 / mass));
    u.assign(n, Float4{});
    du.assign(n, Float4{});
    u_low.assign(n, Float4{});
  }

  /// The contact of a step; returns the force on the tool, N.
  Vec3 solve(const ToolShape& tool, const Pose& to, const Pose& from, double friction, double alpha) {
    TouchingTool one{&tool, to, from, friction, &contact, &scratch};
    sweeps =
        solveContacts({skin, static_cast<float>(alpha), inverse_mass.data(), u.data(), du.data()}, {{&one, 1}}).sweeps;
    return one.force;
  }

  /// One step of eq. 12 with contact; returns the force on the tool, N.
  Vec3 step(const ToolShape& tool, const Pose& to, double friction = 0.0) {
    const double c = spec.damping, h = spec.dt;
    const double alpha = 2.0 * h * h / (2.0 + c * h), beta = (2.0 - c * h) / (2.0 + c * h);
    for (int i = 0; i < side * side; ++i) {
      const Vec3 f = springForce(i) - spec.tension * stretchAt(i, u);
      du[i] = toFloat4(beta * toVec3(du[i]) + alpha / mass * f);
    }
    const Vec3 force = solve(tool, to, pose, friction, alpha);
    for (std::size_t i = 0; i < u.size(); ++i) {  // Kahan, as the simulator does
      for (float Float4::*lane : {&Float4::x, &Float4::y, &Float4::z}) {
        const float increment = du[i].*lane - u_low[i].*lane;
        const float sum = u[i].*lane + increment;
        u_low[i].*lane = (sum - u[i].*lane) - increment;
        u[i].*lane = sum;
      }
    }
    pose = to;
    return force;
  }

  /// One tick of `substeps` steps towards `target`; the last step's force.
  Vec3 tick(const ToolShape& tool, const Pose& target, int substeps, double friction = 0.0) {
    const Pose from = pose;
    findContactCandidates(skin, u.data(), tool, from, largestTravel(tool, from, target), contact, scratch);
    findFaceSamples(skin, u.data(), tool, from, largestTravel(tool, from, target), contact, scratch);
    Vec3 force = Vec3::Zero();
    for (int k = 1; k <= substeps; ++k) {
      const double t = static_cast<double>(k) / substeps;
      Pose to;
      to.position = from.position + t * (target.position - from.position);
      to.orientation = from.orientation.slerp(t, target.orientation);
      force = step(tool, to, friction);
    }
    return force;
  }

  void place(const ToolShape& tool, const Pose& at) {
    pose = at;
    contact = makeContactState(skin, tool);
  }

  /// Pa/m, of the contact layer, which is the same everywhere.
  double layer() const { return static_cast<double>(skin.layer[0]); }
  void stiffenLayer(double times) {
    for (float& k : skin.layer) k *= static_cast<float>(times);
  }

  /// Force of the ground on node i, N.
  Vec3 springForce(int i) const {
    return -area[i] * Vec3(spec.lateral, spec.lateral, spec.foundation).cwiseProduct(toVec3(u[i]));
  }

  /// Force of the ground on the whole bed, N.
  Vec3 springForce() const {
    Vec3 f = Vec3::Zero();
    for (int i = 0; i < side * side; ++i) f += springForce(i);
    return f;
  }

  /// Kinetic energy (at the half step) plus the springs' and the contact layer's, J.
  double energy() const {
    double e = 0.0;
    // Central differences conserve the springs' energy as the product of successive displacements.
    for (int i = 0; i < side * side; ++i) {
      const Vec3 increment = toVec3(du[i]), now = toVec3(u[i]), before = now - increment;
      e += 0.5 * mass * increment.squaredNorm() / (spec.dt * spec.dt);
      e += 0.5 * (spec.tension * stretchAt(i, u) - springForce(i)).dot(before);
    }
    for (int k = 0; k < contact.count; ++k) {
      const double K = layer() * skin.area[contact.vertex[k]];
      e += 0.5 * toVec3(contact.force[k]).squaredNorm() / K;
    }
    return e;
  }

  /// Deepest skin vertex inside the tool, all vertices looked at, m (negative: none touches).
  double deepest(const ToolShape& tool) const {
    double depth = -1.0;
    for (int v = 0; v < skin.vertexCount(); ++v) {
      depth = std::max(depth, -toolDistance(tool, pose.toLocal(skinPosition(skin, v, u.data()))).distance);
    }
    return depth;
  }

  /// sum over neighbours of (field_i - field_j), m.
  Vec3 stretchAt(int i, const AlignedVector<Float4>& field) const {
    Vec3 sum = Vec3::Zero();
    if (spec.tension == 0.0) return sum;
    const int x = i % side, y = i / side;
    if (x > 0) sum += toVec3(field[i]) - toVec3(field[i - 1]);
    if (x + 1 < side) sum += toVec3(field[i]) - toVec3(field[i + 1]);
    if (y > 0) sum += toVec3(field[i]) - toVec3(field[i - side]);
    if (y + 1 < side) sum += toVec3(field[i]) - toVec3(field[i + side]);
    return sum;
  }

  Spec spec;
  int side = 0;  // nodes per edge
  SkinModel skin;
  double mass = 0;           // kg, per node
  std::vector<double> area;  // (node_count) m^2
  AlignedVector<float> inverse_mass;
  AlignedVector<Float4> u, du, u_low;
  Pose pose;
  ContactState contact;
  ContactScratch scratch{SkinModel{}};
  int sweeps = 0;  // of the last step

 private:
  struct Weights {
    int cell;
    double w[3];
  };
  static Weights splineWeights(double at, int cells) {
    const int cell = std::min(static_cast<int>(at), cells - 1);
    const double t = at - cell;
    return {cell, {0.5 * (1 - t) * (1 - t), 0.5 + t * (1 - t), 0.5 * t * t}};
  }
};

/// A pose with the tip at `position`, the tool pointing down (its axis along +z).
inline Pose tipAt(double x, double y, double z) {
  Pose pose;
  pose.position = {x, y, z};
  return pose;
}

}  // namespace palpate
