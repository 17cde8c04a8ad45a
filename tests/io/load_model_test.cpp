#include "io/load_model.h"

#include <catch2/catch.hpp>
#include <map>

#include "support/equal_models.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;

TEST_CASE("A set-up can be ended within each long stage, keeps nothing then, and is not changed by being watched", "[load_model]") {
  const Scene scene = test::blockScene();
  const ModelCache none("");
  std::map<std::string, int> calls;
  double last = 0;
  const Model watched = loadModel(scene, [&](const std::string& stage, double fraction) {
    ++calls[stage];
    CHECK(fraction >= last);
    last = fraction;
  }, none);
  CHECK(last == 1);
  test::requireSameModel(watched, loadModel(scene, {}, none));

  struct Ended {};
  const TempFolder folder;
  for (const char* stage : {"nodes and cells", "shape functions", "consistent gradients", "mass and stable step"}) {
    INFO(stage);
    REQUIRE(calls[stage] > 5);
    int left = calls[stage] / 2;
    CHECK_THROWS_AS(loadModel(scene, [&](const std::string& what, double) {
      if (what == stage && left-- == 0) throw Ended();
    }, ModelCache(folder.path("cache"))), Ended);
  }
  CHECK((!std::filesystem::exists(folder.path("cache")) || std::filesystem::is_empty(folder.path("cache"))));
}
