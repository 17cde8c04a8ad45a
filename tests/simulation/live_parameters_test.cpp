#include "model/live_parameters.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "model/model_hash.h"
#include "setup/build_model.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

/// The tool `depth` deep after `ticks` ticks.
void press(const Model& model, State& state, Workspace& workspace, double depth, int ticks) {
  test::moveAlong(model, state, workspace, ticks,
                  [&](int k) { return model.tools.first().first_contact_travel + depth * k / ticks; });
}

/// Share of the stable step at rest, and the depth at which mass is first added to keep it below 1, m.
struct Limit {
  double rest_share = 0, depth = 0;
};

Limit limitOf(const Model& model, State state) {
  Workspace workspace(model, 1);
  Limit limit;
  for (int k = 0; k < 3000; ++k) {
    const double depth = 0.012 * k / 3000;
    Command command;
    command.tools[0].pose = test::toolAt(model, model.tools.first().first_contact_travel + depth);
    const StepReport report = tick(model, state, command, workspace);
    if (k == 0) limit.rest_share = report.step_share;
    if (report.added_mass > 0) {
      limit.depth = depth;
      return limit;
    }
  }
  return limit;
}

}  // namespace

TEST_CASE("The state's hash follows live settings where they differ from the loaded ones", "[live_parameters]") {
  const Model model = test::blockModel();
  State state = initialState(model);
  const std::uint64_t loaded = stateHash(model, state);
  state.live.friction[0] = 0.4;
  const std::uint64_t rough = stateHash(model, state);
  CHECK(rough != loaded);
  setMaterial(model, 0, stiffened(model.materials[0], 2), state);
  const std::uint64_t rough_and_stiff = stateHash(model, state);
  CHECK(rough_and_stiff != rough);
  state.live.friction[0] = model.scene.tools[0].friction;
  CHECK(stateHash(model, state) != loaded);
  CHECK(stateHash(model, state) != rough_and_stiff);
  setMaterial(model, 0, model.materials[0], state);
  CHECK(stateHash(model, state) == loaded);
}

TEST_CASE("Equal states give equal futures, live settings included", "[live_parameters]") {
  const Model model = test::blockModel();
  Workspace one(model, 1), other(model, 2);
  State state = initialState(model);
  state.live.friction[0] = 0.4;
  setMaterial(model, 0, stiffened(model.materials[0], 0.5), state);
  press(model, state, one, 0.002, 40);
  State copy = state;
  State with_loaded_settings = state;
  with_loaded_settings.live = loadedParameters(model);
  press(model, state, one, 0.003, 40);
  press(model, copy, other, 0.003, 40);
  press(model, with_loaded_settings, other, 0.003, 40);
  CHECK(stateHash(model, copy) == stateHash(model, state));
  CHECK(toVec3(copy.contact[0].force[0]) == toVec3(state.contact[0].force[0]));
  CHECK(stateHash(model, with_loaded_settings) != stateHash(model, state));
}

TEST_CASE("Patch moduli of a live material are those of a model that was loaded with it", "[live_parameters]") {
  Scene scene = test::blockScene();
  scene.discretization.formulation.node_patches = true;
  const Model soft = test::blockModel(scene);
  scene.materials[0].material = stiffened(scene.materials[0].material, 3);
  const Model stiff = test::blockModel(scene);
  State state = initialState(soft);
  const AlignedVector<float> before = state.live.kernel.patch_bulk;
  REQUIRE_FALSE(before.empty());
  setMaterial(soft, 0, stiff.materials[0], state);
  CHECK(state.live.kernel.patch_bulk == initialState(stiff).live.kernel.patch_bulk);
  CHECK(state.live.kernel.patch_bulk != before);
  CHECK(initialState(soft).live.kernel.patch_bulk == before);  // the model is as it was
}

TEST_CASE("The stiffening is the larger of bulk and shear, over all materials", "[live_parameters]") {
  Model model;
  model.materials = {Material::neoHookean(3000, 0.45, 1000), Material::neoHookean(9000, 0.49, 1000)};
  LiveParameters live;
  live.kernel.materials = model.materials;
  CHECK(stiffening(model, live) == 1);
  live.kernel.materials[1] = stiffened(model.materials[1], 0.5);
  CHECK(stiffening(model, live) == 1);  // the first is as it was
  live.kernel.materials[0] = stiffened(model.materials[0], 0.25);
  CHECK(stiffening(model, live) == 0.5);
  live.kernel.materials[0].bulk_modulus = 4 * model.materials[0].bulk_modulus;
  CHECK(stiffening(model, live) == 4);
}

TEST_CASE("Fibres stiffen a material by what they add to Young's modulus", "[live_parameters]") {
  const double along[] = {0, 0, 1}, across[] = {1, 0, 0};
  const Material loaded =
      Material::of("fibre-reinforced").set("young", 3000).set("poisson", 0.45).set("k1", 1000).set("fibre", along);
  CHECK(stiffening(loaded, stiffened(loaded, 2)) == Approx(2));
  CHECK(stiffening(loaded, Material(loaded).set("k1", 0)) == Approx(1));
  CHECK(stiffening(loaded, Material(loaded).set("k1", 2750)) == Approx(2));             // 3000 + 4 k1
  CHECK(stiffening(loaded, Material(loaded).set("fibre", across)) == Approx(7.0 / 3));  // none were there before
}

TEST_CASE("A slab stiffened live gets mass where one that was loaded as stiff does", "[live_parameters][whole]") {
  constexpr double factor = 2.5;
  Scene scene = test::blockScene();
  Model loaded = test::blockModel(scene);
  loaded.dt = 0.52 * loaded.dt_critical;
  loaded.substeps_per_tick = 1;
  State state = initialState(loaded);
  const Limit soft = limitOf(loaded, state);
  setMaterial(loaded, 0, stiffened(loaded.materials[0], factor), state);
  const Limit live = limitOf(loaded, state);

  scene.materials[0].material = stiffened(scene.materials[0].material, factor);
  Model stiff = test::blockModel(scene);
  stiff.dt = loaded.dt;  // the same steps: those that it would choose are shorter
  stiff.substeps_per_tick = loaded.substeps_per_tick;
  const Limit reference = limitOf(stiff, initialState(stiff));

  CHECK(live.rest_share == Approx(std::sqrt(factor) * soft.rest_share).epsilon(1e-6));
  CHECK(live.rest_share == Approx(reference.rest_share).epsilon(0.02));  // two estimates of an eigenvalue
  INFO("mass from " << 1e3 * live.depth << " mm, loaded as stiff at " << 1e3 * reference.depth << " mm, soft at "
                    << 1e3 * soft.depth << " mm");
  REQUIRE(live.depth > 0);
  REQUIRE(reference.depth > 0);
  CHECK(live.depth == Approx(reference.depth).epsilon(0.05));
  CHECK((soft.depth == 0 || soft.depth > 1.5 * live.depth));  // what the loaded limit would say
}
