#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "contact/contact.h"
#include "contact/tools/tool_list.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "simulation/step.h"
#include "simulation/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

// Two thirds of a body deep, where the skin under the tool is stretched to several times its size.

namespace {

/// A cube of 90 mm, soft enough in volume to be squeezed so far by every discretization.
Model cube(const ToolShape& tool) {
  Scene scene = test::blockScene(0.015);
  scene.size = Vec3(0.09, 0.09, 0.09);
  scene.materials[0].material.set("poisson", 0.3);
  scene.tool = tool;
  scene.tool_position = Vec3(0.001, 0.002, 0.091);
  scene.step_safety = 0.1;
  return buildModel(scene, boxSurface(scene.size, 0.01));
}

struct Standing {
  double deepest = 0;  // m, of the points of the skin's faces inside the tool
  int inside = 0;      // 1 where the middle of the tool's tip is inside the body
  double stretch = 1;  // largest, of an edge near the tool
};

Standing standing(const Model& model, const State& state) {
  const SkinModel& skin = model.skin;
  const ToolProfile tool = toolProfile(model.scene.tool);
  std::vector<Vec3> x;
  for (int v = 0; v < skin.vertexCount(); ++v) x.push_back(skinPosition(skin, v, state.u.data()));
  const Vec3 middle = state.tool_pose.toWorld({0, 0, tool.radius});
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
        s.deepest = std::max(s.deepest, -toolDistance(tool, state.tool_pose.toLocal(p)).distance);
      }
    }
  }
  for (std::size_t e = 0; e < skin.topology.edge.size(); ++e) {
    const auto [a, b] = skin.topology.edge[e];
    if ((x[a] - middle).norm() < 2 * tool.radius)
      s.stretch = std::max(s.stretch, (x[a] - x[b]).norm() / static_cast<double>(skin.topology.edge_length[e]));
  }
  return s;
}

}  // namespace

TEST_CASE("A tool two thirds of a body deep is felt all the way and across, and stays outside of it",
          "[contact][deep]") {
  for (const ToolKind kind : {ToolKind::Sphere, ToolKind::FlatCylinder}) {
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
      command.tool_target = test::toolAt(model, model.first_contact_travel + depth, slide);
      const StepReport report = tick(model, state, command, workspace);
      REQUIRE((report.flags & ~kDeepContact) == 0);
      const double force = report.tool_force.norm();
      (k <= 625 ? change : drag_change) =
          std::max(k <= 625 ? change : drag_change, k == 1 ? 0 : (report.tool_force - last).norm());
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
        if (std::getenv("PRINT"))
          std::printf(
              "%4d depth %4.1f mm F %6.3f %6.3f %6.3f N, deepest %.2f R, stretch %.2f, %d in contact, samples %d, "
              "listed %d, penetration %.2f mm, min J %.2f, share %.2f\n",
              k, 1e3 * depth, last.x(), last.y(), last.z(), s.deepest / tool.radius, s.stretch, report.contact_count,
              state.contact.samples.count, state.contact.count, 1e3 * report.max_penetration, report.min_J,
              report.step_share);
      }
    }
    std::printf(
        "deep: %s: peak %.2f N, least on the way across %.2f of it, skin stretched to %.1f, in the tool by %.3f R; "
        "worst tick: in %.2f, across %.2f %%\n",
        toolType(kind).name, peak, least / peak, stretch, deepest / tool.radius, 100 * change / peak,
        100 * drag_change / peak);
    CHECK(stretch > 2.5);
    CHECK(deepest < 0.15 * tool.radius);
    CHECK(least > 0.4 * peak);
    CHECK(change < 0.03 * peak);
    CHECK(drag_change < 0.03 * peak);
  }
}

TEST_CASE("Experiment", "[.deep]") {
  Scene scene = readScene(std::getenv("LIVER"));
  const Model model = loadModel(scene);
  State state = initialState(model);
  Workspace workspace(model, 1);
  double peak = 0, change = 0;
  Vec3 last = Vec3::Zero();
  int worst_k = 0;
  const double full = std::getenv("DEPTH") ? std::atof(std::getenv("DEPTH")) : 0.06;
  for (int k = 1; k <= 1000; ++k) {
    const double depth = std::min(full, 0.0001 * k), slide = k <= 700 ? 0 : 2e-5 * (k - 700);
    Command command;
    command.tool_target = test::toolAt(model, model.first_contact_travel + depth, slide);
    const StepReport r = tick(model, state, command, workspace);
    peak = std::max(peak, r.tool_force.norm());
    const double c = (r.tool_force - last).norm();
    if (c > change) change = c, worst_k = k;
    last = r.tool_force;
    if (k % 50 == 0) {
      const Standing s = standing(model, state);
      std::printf(
          "%4d depth %4.1f mm F %6.3f %6.3f %6.3f N, worst tick %.3f at %d, deepest %.2f R, inside %d, stretch %.2f, "
          "%d in "
          "contact, samples %d of %d listed, longest %.1f mm, penetration %.2f mm, min J %.2f, share %.2f flags %x\n",
          k, 1e3 * depth, r.tool_force.x(), r.tool_force.y(), r.tool_force.z(), change, worst_k, s.deepest / 0.01,
          s.inside, s.stretch, r.contact_count, state.contact.samples.count, state.contact.count,
          1e3 * state.contact.samples.longest_edge, 1e3 * r.max_penetration, r.min_J, r.step_share, r.flags);
      change = 0;
    }
    if (r.flags & 3) {
      std::printf("lost at %d\n", k);
      break;
    }
  }
}
