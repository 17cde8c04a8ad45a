#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "contact/contact.h"
#include "contact/tools/tool_list.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

// Two thirds of a body deep, where the skin under the tool is stretched to several times its size.

namespace {

/// A cube of 90 mm, soft enough in volume to be squeezed so far by every discretization.
Model cube(const ToolShape& tool) {
  Scene scene = test::blockScene(0.015);
  scene.organs[0].size = Vec3(0.09, 0.09, 0.09);
  scene.materials[0].material.set("poisson", 0.3);
  scene.tools[0].shape = tool;
  scene.tools[0].position = Vec3(0.001, 0.002, 0.091);
  scene.dynamics.step_safety = 0.1;
  return buildModel(scene, boxSurface(scene.organs[0].size, 0.01));
}

struct Standing {
  double deepest = 0;  // m, of the points of the skin's faces inside the tool
  int inside = 0;      // 1 where the middle of the tool's tip is inside the body
  double stretch = 1;  // largest, of an edge near the tool
};

Standing standing(const Model& model, const State& state) {
  const SkinModel& skin = model.skin;
  const ToolProfile tool = toolProfile(model.scene.tools[0].shape);
  std::vector<Vec3> x;
  for (int v = 0; v < skin.vertexCount(); ++v) x.push_back(skinPosition(skin, v, state.u.data()));
  const Vec3 middle = state.tool[0].pose.toWorld({0, 0, tool.radius});
  const auto cross = [](const Vec3& p, const Vec3& q) { return p.x() * q.y() - p.y() * q.x(); };
  Standing s;
  for (const auto& [a, b, c] : skin.surface.triangles) {
    // What a ray from the middle upwards passes through: from inside out, once more than from outside in.
    const double ab = cross(x[a] - middle, x[b] - middle), bc = cross(x[b] - middle, x[c] - middle),
                 ca = cross(x[c] - middle, x[a] - middle), area = ab + bc + ca;
    if ((ab >= 0 && bc >= 0 && ca >= 0) || (ab < 0 && bc < 0 && ca < 0)) {
      const double z = (bc * x[a].z() + ca * x[b].z() + ab * x[c].z()) / area;
      if (z > middle.z()) s.inside += area > 0 ? 1 : -1;
    }
    if (std::min({(x[a] - middle).norm(), (x[b] - middle).norm(), (x[c] - middle).norm()}) > 4 * tool.radius) continue;
    for (int i = 0; i <= 4; ++i) {
      for (int j = 0; i + j <= 4; ++j) {
        const Vec3 p = (i * x[a] + j * x[b] + (4 - i - j) * x[c]) / 4;
        s.deepest = std::max(s.deepest, -toolDistance(tool, state.tool[0].pose.toLocal(p)).distance);
      }
    }
  }
  for (std::size_t e = 0; e < skin.topology->edge.size(); ++e) {
    const auto [a, b] = skin.topology->edge[e];
    if ((x[a] - middle).norm() < 2 * tool.radius)
      s.stretch = std::max(s.stretch, (x[a] - x[b]).norm() / static_cast<double>(skin.topology->edge_length[e]));
  }
  return s;
}

}  // namespace

TEST_CASE("A tool two thirds of a body deep is felt all the way and across, and stays outside of it",
          "[contact][deep][whole]") {
  struct Case {
    ToolKind kind;
    double depth;  // of the skin's faces in the tool at most, radii; felt by vertices alone a ball gets to 0.21
  };
  for (const auto& [kind, allowed] : {Case{ToolKind::Sphere, 0.13}, {ToolKind::FlatCylinder, 0.2}}) {
    const ToolShape tool = ToolShape::of(kind, 0.01);
    CAPTURE(toolType(kind).name);
    const Model model = cube(tool);
    State state = initialState(model);
    Workspace workspace(model, 1);
    double peak = 0, change = 0, drag_change = 0, least = 1e9, highest = 0, deepest = 0, stretch = 1;
    Vec3 last = Vec3::Zero();
    for (int k = 1; k <= 800; ++k) {
      // 60 mm in at 50 mm/s, then across at 10 mm/s; the hand takes 50 ms to change its speed.
      const double stopped = std::max(0, 625 - k);  // ticks before it stands
      const double depth = 0.06 - (stopped > 50 ? 1e-4 * (stopped - 25) : 1e-6 * stopped * stopped);
      const int dragged = std::max(0, k - 625);
      const double slide = dragged > 25 ? 2e-5 * (dragged - 12.5) : 4e-7 * dragged * dragged;
      Command command;
      command.tools[0].pose = test::toolAt(model, model.tools.first().first_contact_travel + depth, slide);
      const StepReport report = tick(model, state, command, workspace);
      REQUIRE((report.flags & ~kDeepContact) == 0);
      const double force = report.tool_force.norm();
      double& worst = k <= 625 ? change : drag_change;
      if (k > 50) worst = std::max(worst, (report.tool_force - last).norm());  // the first touch is a blow
      last = report.tool_force;
      peak = std::max(peak, force);
      if (k <= 575 && k % 25 == 0) {
        CHECK(force > highest);  // deeper is harder
        highest = force;
      }
      if (k > 625) least = std::min(least, force);
      if (k % 50 == 0) {
        const Standing s = standing(model, state);
        CHECK(s.inside == 0);
        deepest = std::max(deepest, s.deepest);
        stretch = std::max(stretch, s.stretch);
      }
    }
    std::printf(
        "deep: %s: peak %.2f N, least on the way across %.2f of it, skin stretched to %.1f, in the tool by %.3f R; "
        "worst tick: in %.2f, across %.2f %%\n",
        toolType(kind).name, peak, least / peak, stretch, deepest / tool.radius, 100 * change / peak,
        100 * drag_change / peak);
    CHECK(stretch > 2.4);
    CHECK(deepest < allowed * tool.radius);
    CHECK(least > 0.4 * peak);
    CHECK(change < 0.03 * peak);
    CHECK(drag_change < 0.03 * peak);
  }
}
