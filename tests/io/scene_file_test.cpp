#include "io/scene_file.h"
#include "base/build_info.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "contact/tools/tool_list.h"
#include "discretization/surface/surface_geometry.h"
#include "io/scene_keys.h"
#include "io/scene_texts.h"
#include "io/surface_file.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using Catch::Contains;

TEST_CASE("Every key of a scene arrives where it belongs", "[io][scene]") {
  TempFolder folder;
  const std::string path = folder.write("full.toml", full_scene);
  const Scene s = readScene(path);
  CHECK(s.name == "Everything");
  CHECK(s.organs[0].solid == OrganSpec::Solid::Cylinder);
  CHECK(s.organs[0].radius == 0.015);
  CHECK(s.organs[0].height == 0.017);
  CHECK(s.organs[0].colour == Vec3(0.1, 0.2, 0.3));
  CHECK(s.discretization.spacing == 0.004);
  CHECK(s.discretization.seed == 9);
  CHECK(s.discretization.quadrature.points_per_cell == 1);
  CHECK(s.discretization.basis_degree == 1);
  CHECK(s.discretization.support_factor == 2);
  CHECK(s.discretization.mmls_weight == 0.05);
  REQUIRE(s.discretization.refine.size() == 1);
  CHECK(s.discretization.refine[0].centre == Vec3(0, 0, 0.017));
  CHECK(s.discretization.refine[0].radius == 0.003);
  CHECK(s.discretization.refine[0].spacing == 0.001);
  CHECK(s.discretization.refine[0].blend == 0.004);
  REQUIRE(s.materials.size() == 2);
  CHECK(s.materials[0].material == Material::neoHookean(1000, 0.45, 1000));
  CHECK(s.materials[0].everywhere);
  const double mu[] = {600, 43.6}, alpha[] = {-1.1, 2};
  CHECK(s.materials[1].material == Material::ogden(mu, alpha, 2, 1.2598e-4, 970));
  CHECK_FALSE(s.materials[1].everywhere);
  CHECK(s.materials[1].region.kind == Region::Kind::Sphere);
  CHECK(s.materials[1].region.point == Vec3(0, 0, 0.01));
  CHECK(s.materials[1].region.radius == 0.005);
  REQUIRE(s.boundaries.size() == 2);
  CHECK(s.boundaries[0].region.kind == Region::Kind::NearPlane);
  CHECK(s.boundaries[0].region.normal == Vec3(0, 0, 1));
  CHECK(s.boundaries[0].region.distance == 1e-5);
  CHECK(s.boundaries[0].component[0]);
  CHECK(s.boundaries[0].duration == 0);
  CHECK(s.boundaries[1].region.kind == Region::Kind::Box);
  CHECK(s.boundaries[1].region.min == Vec3(-0.01, -0.01, 0.016));
  CHECK(s.boundaries[1].region.max == Vec3(0.01, 0.01, 0.018));
  CHECK_FALSE(s.boundaries[1].component[0]);
  CHECK_FALSE(s.boundaries[1].component[1]);
  CHECK(s.boundaries[1].component[2]);
  CHECK(s.boundaries[1].surface_only);
  CHECK(s.boundaries[1].translation == Vec3(0, 0, -0.002));
  CHECK(s.boundaries[1].duration == 0.5);
  CHECK(s.dynamics.rate_hz == 1000);
  CHECK(s.dynamics.time_step == 0.0005);
  CHECK(s.dynamics.step_safety == 0.5);
  CHECK(s.dynamics.damping == 10);
  CHECK(s.dynamics.threads == 2);
  CHECK(s.tools[0].shape.kind == ToolKind::FlatCylinder);
  CHECK(s.tools[0].shape.radius == 0.005);
  CHECK(s.tools[0].shape.length == 0.03);
  CHECK(s.tools[0].shape.parameter[0] == 0.0005);
  CHECK(s.tools[0].position == Vec3(0, 0, 0.03));
  CHECK((s.tools[0].direction - Vec3(0, 0.6, -0.8)).norm() < 1e-15);
  CHECK(s.tools[0].max_speed == 0.5);
  CHECK(s.tools[0].friction == 0.2);
  CHECK(s.force.cutoff_hz == 40);
  CHECK(s.force.rate_limit == 100);
  CHECK(s.camera.target == Vec3(0, 0, 0.01));
  CHECK(s.camera.distance == 0.2);
  CHECK(s.camera.azimuth_deg == 30);
  CHECK(s.camera.elevation_deg == 10);
  CHECK(s.camera.fov_deg == 40);

  // Places
  CHECK(s.place.text() == path);
  CHECK(s.places.at("dynamics.time_step").text() == path + ":45:1");
  CHECK(s.places.at("material[1].D1").text() == path + ":27:1");
  CHECK(s.places.at("discretization.refine[0].spacing").line == 17);
  CHECK(s.places.at("tool").line == 49);
  CHECK(s.materials[1].place.line == 23);
  CHECK(s.materials[1].region.place.line == 29);
  CHECK(s.boundaries[1].place.line == 35);
  CHECK(s.discretization.refine[0].place.line == 14);
}

TEST_CASE("A surface organ is found from the scene's folder and scaled by its unit", "[io][scene]") {
  TempFolder folder;
  folder.write("a.obj", "v 0 0 0\n");
  const auto scene = [&](const std::string& organ) {
    return readScene(
        folder.write("s.toml", replaced(minimal_scene, "solid = \"box\"\nsize = [0.1, 0.1, 0.05]", organ)));
  };
  CHECK(scene("surface = \"a.obj\"\nunit = \"mm\"").organs[0].surface_scale == 0.001);
  CHECK(scene("surface = \"./a.obj\"\nunit = \"cm\"").organs[0].surface_scale == 0.01);
  CHECK(scene("surface = \"a.obj\"\nscale = 0.0254").organs[0].surface_scale == 0.0254);
  CHECK(scene("surface = \"" + folder.path("a.obj") + "\"\nunit = \"m\"").organs[0].surface_file ==
        folder.path("a.obj"));
  CHECK(scene("surface = \"./a.obj\"\nunit = \"m\"").organs[0].surface_file == folder.path("a.obj"));
  CHECK_THAT(refusal([&] { scene("surface = \"a.obj\""); }), Contains("s.toml:2:1: the surface's unit is missing"));
  CHECK_THAT(refusal([&] { scene("surface = \"a.obj\"\nunit = \"m\"\nscale = 1"); }),
             Contains("both \"unit\" and \"scale\""));
  CHECK_THAT(refusal([&] { scene("surface = \"a.obj\"\nunit = \"inch\""); }), Contains("give mm, cm or m"));
}

TEST_CASE("Regions contain what they should", "[io][scene]") {
  Region r;
  r.kind = Region::Kind::HalfSpace;
  r.point = {0, 0, 1};
  r.normal = Vec3(0, 0.6, 0.8);
  CHECK(r.contains({0, 0, 1}));
  CHECK(r.contains({0, 0, 0}));
  CHECK_FALSE(r.contains({0, 0.1, 1}));
  r.kind = Region::Kind::NearPlane;
  r.distance = 0.1;
  CHECK(r.contains(r.point + 0.1 * r.normal));
  CHECK(r.contains(r.point - 0.1 * r.normal));
  CHECK_FALSE(r.contains(r.point + 0.11 * r.normal));
  CHECK_FALSE(r.contains({0, 0, 0}));
  r.kind = Region::Kind::Sphere;
  r.radius = 0.5;
  CHECK(r.contains({0, 0, 0.5}));
  CHECK_FALSE(r.contains({0.4, 0.4, 1}));
  CHECK(r.contains({0, 0, 1.51}, 0.02));
  r.kind = Region::Kind::Box;
  r.min = {-1, -2, -3};
  r.max = {1, 2, 3};
  CHECK(r.contains({1, 2, -3}));
  CHECK_FALSE(r.contains({1.1, 0, 0}));
  CHECK_FALSE(r.contains({0, 0, -3.1}));
  r.kind = Region::Kind::Cylinder;
  r.point = {1, 0, 0};
  r.normal = Vec3::UnitX();
  r.radius = 0.5;
  r.height = 2;
  CHECK(r.contains({1, 0, 0.5}));
  CHECK(r.contains({3, 0.3, 0.4}));
  CHECK_FALSE(r.contains({2, 0.4, 0.4}));
  CHECK_FALSE(r.contains({0.99, 0, 0}));
  CHECK_FALSE(r.contains({3.01, 0, 0}));
  r.kind = Region::Kind::Shell;
  r.distance = 0.1;
  CHECK(r.contains({2, 2, 2}, 1e-9, 0.1));
  CHECK_FALSE(r.contains({1, 0, 0}, 1e-9, 0.11));
  CHECK_FALSE(r.contains({1, 0, 0}));
}

TEST_CASE("Every scene in assets/scenes parses and its surface bounds a solid", "[io][scene][assets]") {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sourceFolder() + "/assets/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    ++count;
    INFO(entry.path());
    const Scene s = readScene(entry.path().string());
    CHECK_FALSE(s.name.empty());
    if (s.organs[0].solid == OrganSpec::Solid::Surface) {
      const TriangleSurface organ = readClosedSurface(s.organs[0].surface_file, s.organs[0].surface_scale);
      const Box3 box = boundingBox(organ);
      CHECK(box.sizes().maxCoeff() > 0.05);  // an organ in metres
      CHECK(box.sizes().maxCoeff() < 0.5);
      CHECK_FALSE(box.contains(s.tools[0].position));
      // The tool starts over the organ and points at it.
      CHECK(box.sizes().norm() > (s.tools[0].position - box.center()).norm());
      CHECK((box.center() - s.tools[0].position).dot(s.tools[0].direction) > 0);
      CHECK(box.contains(s.camera.target));
    }
  }
  CHECK(count >= 5);
}
