#include <catch2/catch.hpp>

#include "support/small_scene.h"

using namespace palpate;
using test::blockModel;
using test::blockScene;

TEST_CASE("A model says what it is made of", "[build_model]") {
  const Model model = blockModel();
  double mass = 0, volume = 0;
  for (double m : model.mass) {
    REQUIRE(m > 0);
    mass += m;
  }
  for (double v : model.point_volume) volume += v;
  const double box = 0.06 * 0.06 * 0.03;
  CHECK(volume == Approx(box).epsilon(1e-12));  // flat faces: nothing is lost
  CHECK(mass == Approx(1000 * box).epsilon(1e-12));
  CHECK(model.touch_travel == Approx(0.002).epsilon(1e-6));
  CHECK(model.dt <= model.scene.step_safety * model.dt_critical);
  CHECK(model.dt * model.substeps_per_tick == Approx(1 / model.scene.rate_hz).epsilon(1e-14));
  CHECK(model.dt_proven < model.dt_critical);
  CHECK(model.point_shape.meanSupport() > 15);
}

TEST_CASE("Supports are a partition of unity that reproduces linear fields, at points and on the skin", "[build_model]") {
  const Model model = blockModel();
  for (const ShapeTable* table : {&model.point_shape, &model.skin_shape}) {
    double worst = 0;
    for (int r = 0; r < table->rowCount(); ++r) {
      double one = 0;
      Vec3 x = Vec3::Zero();
      for (int e = table->begin[r]; e < table->begin[r + 1]; ++e) {
        one += table->N[e];
        x += table->N[e] * model.X[table->node[e]];
      }
      const Vec3 at = table == &model.point_shape ? model.point_X[r] : model.skin.surface.vertices[r];
      worst = std::max({worst, std::abs(one - 1), (x - at).norm() / 0.06});
    }
    CHECK(worst < 1e-9);
  }
}

TEST_CASE("What can't be used is refused with the place that says so", "[build_model]") {
  const auto refuse = [](Scene scene, const char* place, const char* problem) {
    scene.places["dynamics.time_step"] = {"block.toml", 21, 3};
    scene.places["tool.position"] = {"block.toml", 30, 1};
    scene.places["discretization.support_factor"] = {"block.toml", 12, 1};
    for (auto& b : scene.boundaries) b.place = {"block.toml", 17, 1};
    CHECK_THROWS_WITH(blockModel(scene), Catch::Contains(place) && Catch::Contains(problem));
  };
  Scene scene = blockScene();
  scene.rate_hz = 100;
  scene.time_step = 1.0 / 100;  // one step a tick: far beyond the limit
  refuse(scene, "block.toml:21:3", "exceeds the critical");
  scene.rate_hz = 500;
  scene.time_step = 0.0003;
  refuse(scene, "block.toml:21:3", "not a whole number");
  scene = blockScene();
  scene.boundaries[0].region.point = Vec3(0, 0, 1);
  refuse(scene, "block.toml:17:1", "no node");
  scene = blockScene();
  scene.tool_position = Vec3(0, 0, 0.02);
  refuse(scene, "block.toml:30:1", "inside the organ");
  scene = blockScene();
  scene.support_factor = 0.1;  // no node reaches another, not even after enlargement
  refuse(scene, "block.toml:12:1", "inadmissible");
  scene = blockScene();
  scene.boundaries.push_back(scene.boundaries[0]);
  scene.boundaries[1].translation = Vec3(0, 0, 1e-3);
  scene.boundaries[1].duration = 1;
  refuse(scene, "block.toml:17:1", "another motion");
}

TEST_CASE("A material region changes the points inside it alone", "[build_model]") {
  Scene scene = blockScene();
  MaterialSpec stiff = scene.materials[0];
  stiff.everywhere = false;
  stiff.young = 9000;
  stiff.density = 2000;
  stiff.region.kind = Region::Kind::HalfSpace;
  stiff.region.point = Vec3(0.01, 0, 0);
  stiff.region.normal = -Vec3::UnitX();  // x >= 0.01
  scene.materials.push_back(stiff);
  const Model model = blockModel(scene);
  for (int q = 0; q < model.pointCount(); ++q) CHECK((model.point_material[q] == 1) == (model.point_X[q].x() >= 0.01));
  double mass = 0;
  for (double m : model.mass) mass += m;
  const double box = 0.06 * 0.06 * 0.03;
  CHECK(mass > 1.2 * 1000 * box);
  CHECK(mass < 1.5 * 1000 * box);
}
