#include "io/load_model.h"
#include "base/build_info.h"

#include <catch2/catch.hpp>
#include <map>

#include "discretization/surface/solids.h"
#include "io/scene_file.h"
#include "setup/place.h"
#include "support/equal_models.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;
using Catch::Contains;

TEST_CASE("A set-up can be ended within each long stage, keeps nothing then, and is not changed by being watched",
          "[load_model]") {
  Scene scene = test::blockScene();
  scene.set_up_values = "a block";  // so that it would be kept
  const ModelCache none("");
  std::map<std::string, int> calls;
  double last = 0;
  const Model watched = loadModel(
      scene,
      [&](const std::string& stage, double fraction) {
        ++calls[stage];
        CHECK(fraction >= last);
        last = fraction;
      },
      none);
  CHECK(last == 1);
  test::requireSameModel(watched, loadModel(scene, {}, none));

  struct Ended {};
  const TempFolder folder;
  for (const char* stage : {"nodes and cells", "shape functions", "consistent gradients", "mass and stable step"}) {
    INFO(stage);
    REQUIRE(calls[stage] > 5);
    int left = calls[stage] / 2;
    CHECK_THROWS_AS(loadModel(
                        scene,
                        [&](const std::string& what, double) {
                          if (what == stage && left-- == 0) throw Ended();
                        },
                        ModelCache(folder.path("cache"))),
                    Ended);
  }
  CHECK((!std::filesystem::exists(folder.path("cache")) || std::filesystem::is_empty(folder.path("cache"))));
}

TEST_CASE("An organ of an unlikely size is warned of, with its length and the key to check", "[load_model]") {
  const auto warned = [](const Scene& scene, double edge) {
    return sizeWarning(scene, boxSurface(Vec3(edge / 2, edge / 3, edge), edge));
  };
  Scene scene;
  scene.organs[0].solid = OrganSpec::Solid::Surface;
  scene.organs[0].surface_scale = 1;
  scene.places["organ.unit"] = {"small.toml", 4, 1};
  CHECK(warned(scene, 0.00016) == "small.toml:4:1: the organ is 0.16 mm long; is unit = \"m\" right?");
  CHECK(warned(scene, 160) == "small.toml:4:1: the organ is 160 m long; is unit = \"m\" right?");
  for (const double likely : {0.001001, 0.16, 2.999}) CHECK(warned(scene, likely).empty());
  scene.organs[0].surface_scale = 0.001;
  CHECK_THAT(warned(scene, 0.00016), Contains("unit = \"mm\""));
  scene.places.clear();
  CHECK(warned(scene, 3.5) == "the organ is 3.5 m long; is scale = 0.001 right?");
  CHECK_THAT(warned(test::blockScene(), 5), Contains("5 m long; are its lengths in m?"));
}

TEST_CASE("No scene of assets/scenes has an unlikely size", "[load_model]") {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sourceFolder() + "/assets/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    INFO(entry.path());
    const Scene scene = readScene(entry.path().string());
    CHECK(sizeWarning(scene, organSurface(scene)).empty());
    ++scenes;
  }
  CHECK(scenes > 5);
}

TEST_CASE("The warning of a size comes before the set-up takes time, and once", "[load_model]") {
  Scene scene = test::blockScene();
  std::vector<std::string> warnings;
  const auto keep = [&](const std::string& line) { warnings.push_back(line); };
  loadModel(scene, {}, ModelCache(), keep);
  CHECK(warnings.empty());
  scene.organs[0].size = Vec3(4, 4, 2);
  scene.discretization.spacing = scene.tools[0].shape.radius = 0.5;
  struct Ended {};
  CHECK_THROWS_AS(loadModel(
                      scene,
                      [&](const std::string& stage, double) {
                        if (stage != "surface") throw Ended();
                      },
                      ModelCache(), keep),
                  Ended);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("the organ is 4 m long"));

  Scene soft = test::blockScene();
  soft.materials[0].material.set("young", 3);  // kPa
  warnings.clear();
  loadModel(soft, {}, ModelCache(), keep);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("a shear modulus of 1.01 Pa is softer than any organ: are the moduli in Pa?"));
}

TEST_CASE("Tools that start at one place are refused - of one that never touches there is a warning", "[load_model]") {
  Scene scene = test::blockScene();
  std::vector<std::string> warnings;
  const auto keep = [&](const std::string& line) { warnings.push_back(line); };
  scene.tools[0].position.x() = 0.2;
  loadModel(scene, {}, ModelCache(), keep);
  CHECK(warnings.empty());  // a scene without a tool
  scene.tools[0].place = scene.places["tool[0].position"] = {"block.toml", 7, 1};
  loadModel(scene, {}, ModelCache(), keep);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("block.toml:7:1: straight on the tool never touches the organ"));
  ToolSpec second;
  second.shape = scene.tools[0].shape;
  second.position = scene.tools[0].position;
  scene.tools.push_back(second);
  CHECK_THROWS_WITH(loadModel(scene), Contains("tools 1 and 2 start at one place"));
}

TEST_CASE("A material whose region has nothing of the organ is told, with its place", "[load_model]") {
  Scene scene = test::blockScene();
  MaterialSpec material = scene.materials[0];
  material.name = "cyst";
  material.everywhere = false;
  material.place = {"block.toml", 9, 1};
  material.region.kind = Region::Kind::Sphere;
  material.region.radius = 0.002;
  std::vector<std::string> warnings;
  const auto told = [&](const Vec3& centre) {
    warnings.clear();
    material.region.point = centre;
    scene.materials.resize(1);
    scene.materials.push_back(material);
    loadModel(scene, {}, ModelCache(), [&](const std::string& line) { warnings.push_back(line); });
    return !warnings.empty();
  };
  CHECK(told(Vec3(1, 1, 1)));
  CHECK_THAT(warnings.at(0), Contains("block.toml:9:1: material 2 (\"cyst\") is nowhere in the organ"));
  CHECK_FALSE(told(Vec3(0.01, 0.01, 0.015)));  // however small
}

TEST_CASE("Where the cloud follows, a model is that of the place where the tool will be", "[load_model][whole]") {
  Scene scene = test::barScene();
  scene.discretization.follow = true;
  const ModelCache none("");
  const Vec3 there(0.05, 0, 0.032);
  const Model start = loadModel(scene, {}, none), end = loadModel(scene, {}, none, {}, [&](const Model&model) {
                                                    ToolPostures tools;
                                                    tools[0].pose = model.tools.first().start.pose;
                                                    tools[0].pose.position = there;
                                                    return tools;
                                                  });
  const auto near = [&](const Model& model, const Vec3& x) {
    return std::count_if(model.X.begin(), model.X.end(), [&](const Vec3& X) { return (X - x).norm() < 0.02; });
  };
  CHECK(near(end, there) > 1.5 * static_cast<double>(near(start, there)));
  CHECK(near(start, scene.tools[0].position) > 1.5 * static_cast<double>(near(end, scene.tools[0].position)));
  CHECK_FALSE(end.scene.discretization.follow);
  REQUIRE(end.scene.discretization.refine.size() == 1);
  CHECK(end.scene.discretization.refine[0].spacing == Approx(0.5 * scene.tools[0].shape.radius));
}

TEST_CASE("A solid that is small beside its tool is as round as it is", "[load_model]") {
  Scene scene = test::blockScene();
  OrganSpec& organ = scene.organs[0];
  organ.solid = OrganSpec::Solid::Ellipsoid;
  organ.semi_axes = Vec3(0.006, 0.006, 0.0045);
  scene.tools[0].shape.radius = 0.01;
  scene.discretization.spacing = followSpacing(scene);
  double highest = 0;
  for (const Vec3& x : organSurface(scene).vertices) highest = std::max(highest, x.z());
  CHECK(highest == Approx(0.0045).epsilon(0.03));  // 0.005 with edges of half a tool's radius
}
