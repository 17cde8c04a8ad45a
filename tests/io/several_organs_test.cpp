#include <catch2/catch.hpp>

#include "base/build_info.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "model/model_hash.h"
#include "setup/free_axes.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using Catch::Matchers::Contains;

namespace {

const std::string two_text = R"(
discretization = { spacing = 0.012 }
fixed = [{ shape = "near-plane", point = [0, 0, 0], normal = [0, 0, 1], distance = 1e-6 }]
tool = { shape = "sphere", radius = 0.01, position = [0, 0, 0.1], direction = [0, 0, -1] }

[[organ]]
name = "lower"
solid = "box"
size = [0.04, 0.04, 0.02]

[[organ]]
name = "upper"
solid = "box"
size = [0.04, 0.04, 0.02]
position = [0, 0.001, 0.0205]
axis = [0, 0, 2]
angle = 90
colour = [0.1, 0.2, 0.3]
friction = 0.4

[[material]]
model = "neo-hookean"
young = 3000
poisson = 0.4
density = 1000

[[material]]
organ = "upper"
model = "neo-hookean"
young = 6000
poisson = 0.4
density = 1000
)";

Scene sceneOf(const std::string& text) { return readScene(SceneText{text, ".", "two.toml"}, {}); }

Model modelOf(const std::string& text) { return loadModel(sceneOf(text), {}, ModelCache("")); }

}  // namespace

TEST_CASE("Several organs are read with their places and materials, and are bodies of their own",
          "[io][several_organs]") {
  const Scene scene = sceneOf(two_text);
  REQUIRE(scene.organs.size() == 2);
  CHECK(scene.organs[1].colour == Vec3(0.1, 0.2, 0.3));
  const Model model = modelOf(two_text);
  REQUIRE(model.bodies.count == 2);
  CHECK(model.bodies.organ == std::vector<int>{0, 1});
  CHECK(model.bodies.friction[1] == 0.4F);
  for (int i = 0; i < model.nodeCount(); ++i)
    CHECK(model.node_organ[static_cast<std::size_t>(i)] == (model.X[static_cast<std::size_t>(i)].z() > 0.0202 ? 1 : 0));
  for (int q = 0; q < model.pointCount(); ++q)
    CHECK(model.point_material[static_cast<std::size_t>(q)] ==
          (model.point_X[static_cast<std::size_t>(q)].z() > 0.0202 ? 1 : 0));
  CHECK(modelHash(model) != modelHash(modelOf(replaced(two_text, "friction = 0.4", "friction = 0.5"))));
  CHECK(model.cell_volume == Approx(2 * 0.04 * 0.04 * 0.02));

  CHECK_THAT(looseWarning(model), Contains("two.toml:11") && Contains("nothing holds \"upper\""));
  CHECK(looseWarning(
            modelOf(two_text + "[[rigid]]\nregion = { shape = \"box\", min = [-1, -1, -1], max = [1, 1, -0.01] }\n"))
            .empty());

  const Model following = modelOf(replaced(two_text, "discretization = { spacing = 0.012 }", ""));
  CHECK(following.bodies.organ == model.bodies.organ);
  CHECK(following.cell_volume == Approx(model.cell_volume));
}

TEST_CASE("What is wrong with several organs is said with its place", "[io][several_organs]") {
  CHECK_THAT(refusal([] { sceneOf(replaced(two_text, "organ = \"upper\"", "organ = \"uper\"")); }),
             Contains("two.toml:28") && Contains("\"uper\"") && Contains("\"lower\", \"upper\""));
  CHECK_THAT(refusal([] { sceneOf(replaced(two_text, "name = \"upper\"", "name = \"lower\"")); }),
             Contains("a second organ has the name \"lower\""));
  const std::string bare = replaced(two_text, "[[material]]\nmodel", "[[material]]\norgan = \"upper\"\nmodel");
  CHECK_THAT(refusal([&] { sceneOf(bare); }), Contains("\"lower\" has no material"));
  CHECK_THAT(refusal([] { modelOf(replaced(two_text, "0.0205]", "0.015]")); }), Contains("overlap by 5 mm"));
  CHECK_THAT(refusal([] { modelOf(replaced(two_text, "point = [0, 0, 0]", "point = [0, 0, 0.2]")); }),
             Contains("no node lies in this region"));
  CHECK_THAT(refusal([] { modelOf(replaced(two_text, "0.0205]", "20000]")); }),
             Contains("two.toml") && Contains("m from the origin") && Contains("move it nearer"));
  const std::string other = replaced(two_text, "fixed = [{", "fixed = [{ organ = \"upper\",");
  CHECK_THAT(refusal([&] { modelOf(other); }), Contains("no node lies in this region"));
}

TEST_CASE("The scene of two organs loads", "[io][several_organs][whole]") {
  const Model model = loadModel(readScene(sourceFolder() + "/assets/scenes/liver_kidney.toml"), {}, ModelCache(""));
  CHECK(model.bodies.count == 2);
}
