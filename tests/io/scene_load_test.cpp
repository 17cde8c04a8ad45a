#include <catch2/catch.hpp>

#include "io/scene_file.h"
#include "io/scene_texts.h"
#include "model/preparation.h"
#include "support/bad_texts.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using Catch::Contains;

namespace {

const std::string loads = R"([[load]]
name = "gas"
pressure = 1600
duration = 2
[[load]]
region = { shape = "sphere", centre = [0, 0, 0.05], radius = 0.02 }
traction = [0, 10, 0]
curve_table = [[0, 0], [0.5, 1], [1, 0]]
[[load]]
region = { shape = "near-plane", point = [0, 0, 0.05], normal = [0, 0, 1], distance = 1e-6 }
pressure = -200
kind = "dead"
duration = 1
curve = "linear"
)";

}  // namespace

TEST_CASE("Loads of a scene arrive where they belong, and no kept set-up depends on them", "[io][scene][load]") {
  TempFolder folder;
  const auto scene = [&](const std::string& text) { return readScene(folder.write("s.toml", text)); };
  const Scene s = scene(minimal_scene + loads);
  REQUIRE(s.loads.size() == 3);
  CHECK(s.loads[0].name == "gas");
  CHECK(s.loads[0].whole);
  CHECK(s.loads[0].kind == LoadSpec::Kind::FollowerPressure);
  CHECK(s.loads[0].pressure == 1600);
  CHECK(s.loads[0].duration == 2);
  CHECK(s.loads[0].curve.kind == LoadCurve::Kind::Smooth);
  CHECK(s.loads[1].name == "load 2");
  CHECK_FALSE(s.loads[1].whole);
  CHECK(s.loads[1].region.kind == Region::Kind::Sphere);
  CHECK(s.loads[1].kind == LoadSpec::Kind::Traction);
  CHECK(s.loads[1].traction == Vec3(0, 10, 0));
  CHECK(s.loads[1].curve.at(0.75, s.loads[1].duration) == 0.5);
  CHECK(s.loads[1].end() == 1);
  CHECK(s.loads[2].kind == LoadSpec::Kind::DeadPressure);
  CHECK(s.loads[2].pressure == -200);
  CHECK(s.loads[2].curve.kind == LoadCurve::Kind::Linear);
  const TriangleSurface organ;
  CHECK(preparationKey(s, organ) == preparationKey(scene(minimal_scene), organ));
}

TEST_CASE("Bad loads are refused at their place, with advice", "[io][scene][load][refusal]") {
  TempFolder folder;
  const auto before = std::count(minimal_scene.begin(), minimal_scene.end(), '\n');
  const auto at = [&](int line_of_loads) { return ":" + std::to_string(before + line_of_loads) + ":"; };
  const std::vector<BadText> bad = {
      {"pressure = 1600", "", at(1), "neither \"pressure\" nor \"traction\"", "give pressure"},
      {"pressure = 1600", "pressure = 1600\ntraction = [0, 0, 1]", at(4), "both \"pressure\" and \"traction\"",
       "give pressure"},
      {"pressure = 1600", "pressure = inf", at(3), "not finite", "finite"},
      {"pressure = 1600", "pressure = nan", at(3), "not finite", "finite"},
      {"[0, 10, 0]", "[0, inf, 0]", at(7), "not finite", "finite"},
      {"[0, 10, 0]", "[0, 10]", at(7), "\"traction\"", "3 numbers"},
      {"traction = [0, 10, 0]", "traction = [0, 10, 0]\nkind = \"dead\"", at(8), "\"kind\" means nothing to a traction",
       "remove it"},
      {"\"dead\"", "\"alive\"", at(12), "\"kind\" is \"alive\"", "follower or dead"},
      {"duration = 2", "", at(1), "the key \"duration\" is missing", "a load without \"curve_table\" needs it"},
      {"duration = 2", "duration = 0", at(4), "out of range", "> 0"},
      {", radius = 0.02 }", " }", at(6), "the key \"radius\" is missing", "a sphere needs it"},
      {"name = \"gas\"", "name = \"load 2\"", at(5), "the name \"load 2\" is taken", "[[load]] a name of its own"},
      {"name = \"gas\"", "name = \"fixed 1\"", at(2), "the name \"fixed 1\" is taken", "[[load]] a name of its own"},
      {"name = \"gas\"", "name = \"a,b\"", at(2), "\"name\" is \"a,b\"", "without commas"},
      {"pressure = 1600", "presure = 1600", at(3), "unknown key \"presure\"", "did you mean \"pressure\"?"},
  };
  checkRefused(folder, "s.toml", minimal_scene + loads, bad, [](const std::string& path) { readScene(path); });
}
