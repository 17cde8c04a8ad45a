// What a scene may ask for: steps in a tick, nodes in a body, faces of a skin. Refused at the key that asks.

#include <catch2/catch.hpp>

#include "contact/tools/tool_list.h"
#include "discretization/surface/solids.h"
#include "io/load_model.h"
#include "setup/choose_time_step.h"
#include "setup/discretize.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;
using Catch::Contains;
using test::blockModel;
using test::blockScene;

namespace {

Scene placedScene() {
  Scene scene = blockScene();
  scene.place = {"block.toml"};
  scene.places["dynamics.time_step"] = {"block.toml", 21, 3};
  scene.places["dynamics.step_safety"] = {"block.toml", 22, 3};
  scene.places["discretization.spacing"] = {"block.toml", 5, 3};
  scene.places["tool.radius"] = {"block.toml", 31, 3};
  scene.places["tool.max_speed"] = {"block.toml", 32, 3};
  scene.materials[0].place = {"block.toml", 9, 1};
  return scene;
}

}  // namespace

TEST_CASE("More steps to a tick than an int can count, or anybody means, are refused at the key that asks for them",
          "[choose_time_step][whole]") {
  const auto refused = [](const Scene& scene) { return refusal([&] { blockModel(scene); }); };
  for (const double step : {1e-300, 1e-12, 1 / 500.0 / 10'001}) {
    Scene scene = placedScene();
    scene.dynamics.time_step = step;
    CHECK_THAT(refused(scene), Contains("block.toml:21:3") && Contains("steps would make a tick") &&
                                   Contains("more than the 1e+04") && Contains("at least 2e-07 s"));
  }
  for (const double safety : {1e-300, 1e-7}) {
    Scene scene = placedScene();
    scene.dynamics.step_safety = safety;
    CHECK_THAT(refused(scene), Contains("block.toml:22:3") && Contains("steps would make a tick") &&
                                   Contains("raise dynamics.step_safety to more than"));
    scene.dynamics.mass_scaling = 10;  // no search for the mass that would spare them
    CHECK_THAT(refused(scene), Contains("block.toml:22:3"));
  }
  Scene stiff = placedScene();
  stiff.materials[0].material.set("young", 1e16);
  CHECK_THAT(refused(stiff), Contains("block.toml:9:1") && Contains("the critical step is") && Contains("in Pa?") &&
                                 Contains("spacing"));
  Scene fast = placedScene();
  fast.tools[0].shape.radius = 1e-7;
  fast.tools[0].max_speed = 10;
  CHECK_THAT(refusal([&] { checkStepsAsked(fast); }),
             Contains("block.toml:32:3") && Contains("4e+05 steps") && Contains("lower tool.max_speed to 0.25 m/s"));
  fast.tools[0].shape.radius = 0.01;
  fast.discretization.spacing = 2e-7;  // a quarter of it is as far
  CHECK_THAT(refusal([&] { checkStepsAsked(fast); }),
             Contains("4e+05 steps") && Contains("or raise tool.radius and the spacing"));

  // What is asked for by the scene alone is refused before anything is made of it.
  Scene early = placedScene();
  early.dynamics.time_step = 1e-300;
  int stages = 0;
  CHECK_THAT(refusal([&] { loadModel(early, [&](const std::string&, double) { ++stages; }); }),
             Contains("block.toml:21:3"));
  CHECK(stages == 0);

  // The last that is granted.
  Scene most = blockScene();
  most.dynamics.time_step = 1 / most.dynamics.rate_hz / max_steps_per_tick;
  CHECK(blockModel(most).substeps_per_tick == max_steps_per_tick);
}

TEST_CASE("However many steps a sliver asks for, the fewest that added mass can spare are found in a few looks",
          "[choose_time_step]") {
  Scene scene = blockScene();
  const auto granted = [&](double fewest, double now) {
    const double tick = 1 / scene.dynamics.rate_hz;
    int looks = 0;
    const double longest = longestCriticalStep(scene, tick / now / scene.dynamics.step_safety, [&](double wanted) {
      ++looks;
      return wanted < 1.001 * tick / fewest / scene.dynamics.step_safety;
    });
    CHECK(looks < 25);
    return longest > 0 ? tick / longest / scene.dynamics.step_safety : now;
  };
  for (const double now : {5.0, 300.0, 1.5e6}) {
    INFO(now);
    CHECK(granted(3, now) == Approx(3));
    CHECK(granted(4, now) == Approx(4));
  }
  CHECK(granted(777, 1.5e6) == Approx(777));
  CHECK(granted(20'000, 1.5e6) == Approx(1.5e6));  // none
}

TEST_CASE("Nodes and faces beyond what the set-up holds are refused before they are made", "[discretize]") {
  const double volume = 0.06 * 0.06 * 0.03, area = 2 * 0.06 * 0.06 + 4 * 0.06 * 0.03;
  CHECK_NOTHROW(checkCounts(placedScene(), volume, area));
  for (const double spacing : {3e-4, 1e-6, 1e-300}) {
    Scene scene = placedScene();
    scene.discretization.spacing = spacing;
    CHECK_THAT(refusal([&] { checkCounts(scene, volume, area); }),
               Contains("block.toml:5:3") && Contains(spacing > 1e-5 ? "about 5.71e+06 nodes" : "nodes"));
    // Also where the solid would have to be made first: no face of it is.
    CHECK_THAT(refusal([&] { organSurface(scene); }), Contains("block.toml:5:3") && Contains("more than 6e+04"));
  }
  Scene thin = placedScene();
  thin.tools[0].shape.radius = 1e-5;
  CHECK_THAT(refusal([&] { checkCounts(thin, volume, area); }),
             Contains("block.toml:31:3") && Contains("faces to touch") && Contains("raise it to"));
  CHECK_THAT(refusal([&] { organSurface(thin); }), Contains("block.toml:31:3"));
}

TEST_CASE("A skin whose faces can't be counted beforehand is refused with the key that asks for them", "[discretize]") {
  Scene scene = placedScene();
  scene.discretization.refine.push_back({Vec3(0, 0, 0.03), 0.02, 1e-5, 0, {"block.toml", 12, 1}});
  CHECK_THAT(refusal([&] { refineForContact(scene, boxSurface(scene.organs[0].size, 0.004), 20'000); }),
             Contains("block.toml:12:1") && Contains("more than 2e+04 faces") && Contains("refine"));
  // Of several the finest is to blame.
  scene.discretization.refine.insert(scene.discretization.refine.begin(),
                                     {Vec3(0, 0, 0.03), 0.02, 5e-3, 0, {"block.toml", 8, 1}});
  CHECK_THAT(refusal([&] { refineForContact(scene, boxSurface(scene.organs[0].size, 0.004), 20'000); }),
             Contains("block.toml:12:1"));
}

TEST_CASE("Steps too short for where a thin layer crowds the nodes are refused with the layer, not its stiffness",
          "[discretize]") {
  Scene scene = placedScene();
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].name = "capsule";
  scene.materials[1].everywhere = false;
  scene.materials[1].material.set("young", 100000);
  scene.materials[1].place = {"block.toml", 20, 1};
  Model model;
  CriticalTimeStep limit;
  limit.worst_node = 0;
  const std::vector<Vec3> X{Vec3(0, 0, 0.03)};
  limit.dt = 1e-9;  // nodes 1e-8 m apart
  CHECK_THAT(refusal([&] { chooseTimeStep(scene, limit, X, model); }),
             Contains("block.toml:20:1") && Contains("material 2 (\"capsule\")") && Contains("layer's thickness") &&
                 !Contains("Soften"));
  scene.materials[1].material.set("young", 1e15);
  CHECK_THAT(refusal([&] { chooseTimeStep(scene, limit, X, model); }), Contains("stiffness in Pa? Soften it"));
}

TEST_CASE("A sharp tip has a finer skin below it than a blunt one of the same radius", "[discretize]") {
  Scene scene = placedScene();
  const auto faces = [&](double tip) {
    scene.tools[0].shape = ToolShape::of(ToolKind::Cone, 0.01);
    scene.tools[0].shape.parameter[1] = tip;
    return static_cast<double>(refineForContact(scene, boxSurface(scene.organs[0].size, 0.004)).triangles.size());
  };
  const double blunt = faces(0.007);
  scene.tools[0].shape = ToolShape::of(ToolKind::Sphere, 0.01);
  CHECK(blunt ==
        static_cast<double>(refineForContact(scene, boxSurface(scene.organs[0].size, 0.004)).triangles.size()));
  CHECK(faces(0.001) > 3 * blunt);
}
