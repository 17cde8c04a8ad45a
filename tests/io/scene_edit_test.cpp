#include "io/scene_edit.h"

#include <catch2/catch.hpp>

using palpate::withSceneKey;

TEST_CASE("A key of a scene's text changes its value and nothing else", "[scene_edit]") {
  const std::string text =
      "name = \"a # b\"   # the name\n"
      "[discretization]   # how fine\n"
      "  spacing = 0.011  # m\n"
      "seed = 3\n"
      "\n"
      "# of the second\n"
      "[dynamics]\n"
      "spacing = 7\n";
  SECTION("where it stands, its comment stays") {
    CHECK(withSceneKey(text, "discretization", "spacing", "0.02") ==
          "name = \"a # b\"   # the name\n[discretization]   # how fine\n  spacing = 0.02  # m\nseed = 3\n\n# of the "
          "second\n[dynamics]\nspacing = 7\n");
  }
  SECTION("a new one stands at the end of its table, before the next one's comment") {
    CHECK(withSceneKey(text, "discretization", "mu", "0.1") ==
          "name = \"a # b\"   # the name\n[discretization]   # how fine\n  spacing = 0.011  # m\nseed = 3\nmu = "
          "0.1\n\n# of the second\n[dynamics]\nspacing = 7\n");
  }
  SECTION("a new table stands at the end") {
    CHECK(withSceneKey(text, "solve", "frames", "3") == text + "\n[solve]\nframes = 3\n");
  }
  SECTION("a key that is a part of another's name is another key") {
    CHECK(withSceneKey("[a]\nmu_max = 1\n", "a", "mu", "2") == "[a]\nmu_max = 1\nmu = 2\n");
  }
  SECTION("a # within quotes is no comment") {
    CHECK(withSceneKey("[organ]\nsurface = \"a#b.obj\" # c\n", "organ", "surface", "\"d.obj\"") ==
          "[organ]\nsurface = \"d.obj\" # c\n");
  }
  SECTION("inline tables and dotted keys get headers first") {
    const std::string headed = palpate::withHeaders(
        "discretization = { spacing = 0.01, seed = 3 }\ndynamics.rate = 400\n[[fixed]]\nshape = \"all\"\n", "a.toml");
    const std::string changed =
        withSceneKey(withSceneKey(headed, "discretization", "spacing", "0.02"), "dynamics", "threads", "2");
    const auto has = [&](const char* part) { return changed.find(part) != std::string::npos; };
    CAPTURE(changed);
    CHECK(has("[discretization]\nseed = 3\nspacing = 0.02\n"));
    CHECK(has("[dynamics]\nrate = 400\nthreads = 2\n"));
    CHECK(has("[[fixed]]\nshape = 'all'\n"));
  }
}
