#include "setup/thin_layers.h"

#include <catch2/catch.hpp>

#include "imaging/membership.h"
#include "step/resolution.h"
#include "step/step.h"
#include "step/tool_bodies.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

/// The block with another material up to a height, m.
Scene layered(double height, double young, double spacing) {
  Scene scene = test::blockScene(spacing);
  scene.materials[0].material.set("poisson", 0.3);
  scene.materials.push_back(scene.materials[0]);
  MaterialSpec& layer = scene.materials[1];
  layer.name = "bottom";
  layer.everywhere = false;
  layer.material.set("young", young);
  layer.region.kind = Region::Kind::HalfSpace;
  layer.region.point = Vec3(0, 0, height);
  layer.region.normal = Vec3::UnitZ();
  return scene;
}

/// The tool's travel in tick k.
double pressing(int k) { return 0.002 + 0.004 * std::min(1.0, k / 100.0); }

}  // namespace

TEST_CASE("A layer that the cells see little of is told by name, and doubted", "[simulation][resolution]") {
  const Model model = test::blockModel(layered(0.002, 100, 0.012));
  CHECK(model.thin_layer == 1);
  CHECK(model.layer_error > 0.1);
  CHECK(layerWarning(model).find("material 2 (\"bottom\") is a layer thinner than the nodes") != std::string::npos);
  Workspace workspace(model, 1);
  State state = initialState(model);
  const StepReport report = test::moveAlong(model, state, workspace, 300, pressing);
  REQUIRE(report.tool_force.norm() > 0);
  CHECK(report.expected_error >= model.layer_error);
  CHECK(doubtOf(model, report) == Doubt::Resolution);
}

TEST_CASE("Materials that are set live make a layer of what was none, or none of it", "[simulation][resolution]") {
  for (const bool becomes : {true, false}) {
    const Model model = test::blockModel(layered(0.002, becomes ? 3000 : 100, 0.012));
    State state = initialState(model);
    Material other = model.materials[becomes ? 1 : 0];
    other.set("young", 100);
    other.updateModuli();
    setMaterial(model, becomes ? 1 : 0, other, state);
    CAPTURE(becomes, model.layer_error);
    const double error = layerError(model, state.live.kernel.materials);
    CHECK((error > 0.1) == becomes);
    CHECK((model.layer_error > 0.1) == !becomes);
    CHECK(layerError(model, model.materials) == model.layer_error);
    if (!becomes) continue;
    const Model loaded = test::blockModel(layered(0.002, 100, 0.012));
    CHECK(error == Approx(loaded.layer_error).epsilon(1e-6));
    Workspace workspace(model, 1);
    const StepReport report = test::moveAlong(model, state, workspace, 300, pressing);
    CHECK(report.expected_error >= error);
  }
}

TEST_CASE("Layers that nodes resolve, and those that hardly differ, are no error", "[simulation][resolution]") {
  for (const Scene& scene : {layered(0.015, 100, 0.012), layered(0.003, 100, 0.003), layered(0.002, 2900, 0.012)}) {
    const Model model = test::blockModel(scene);
    CHECK(model.layer_error < 0.02);
    CHECK(layerWarning(model).empty() == (model.thin_layer < 0));
  }
}

TEST_CASE("A layer that lies within cells, with no node in it, is told and doubted, too", "[simulation][resolution]") {
  Scene scene = layered(0.015, 100, 0.012);  // nodes are put on a border, but not on this slab's
  scene.materials[1].region.kind = Region::Kind::NearPlane;
  scene.materials[1].region.point = Vec3(0, 0, 0.0249);
  scene.materials[1].region.distance = 0.0004;
  for (const double height : {0.0249, 0.021, 0.018, 0.027}) {
    scene.materials[1].region.point.z() = height;
    const Model model = test::blockModel(scene);
    CAPTURE(height, model.nodeCount());
    CHECK(model.thin_layer == 1);
    CHECK(model.layer_error > 0.15);
  }
  // A crumb is not.
  scene.materials[1].region.kind = Region::Kind::Sphere;
  scene.materials[1].region.point = Vec3(0.003, 0.002, 0.02);
  scene.materials[1].region.radius = 0.001;
  CHECK(test::blockModel(scene).thin_layer < 0);
}

TEST_CASE("An image's border within cells is an error to expect: as much as tissue in series is softer",
          "[simulation][resolution]") {
  // 30 mm of 20 kPa, of which 10 are 2 kPa: by the image, in voxels of 1 mm.
  Scene scene = test::blockScene(0.006);
  scene.materials[0].material.set("young", 20e3);
  scene.materials.push_back(scene.materials[0]);
  MaterialSpec& soft = scene.materials[1];
  soft.material.set("young", 2e3);
  soft.everywhere = false;
  auto image = std::make_shared<Membership>();
  image->share = Image(ImageGrid({62, 62, 32}, 1e-3 * Mat3::Identity(), Vec3(-0.0305, -0.0305, -0.0005)));
  for (int k = 10; k < 20; ++k)
    for (int j = 0; j < 62; ++j)
      for (int i = 0; i < 62; ++i) image->share(i, j, k) = 1;
  soft.membership = image;
  const Model model = test::blockModel(scene);
  // With all in series, of what the cells have: between none, and what a third of the layer's thickness would be.
  CHECK(model.layer_error > 0.1);
  CHECK(model.layer_error < 1);
  CHECK_THAT(layerWarning(model), Catch::Contains("membership's image run through cells"));
  soft.material.set("young", 20e3);
  CHECK(test::blockModel(scene).layer_error < 1e-6);
}
