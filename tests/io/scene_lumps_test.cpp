#include "io/scene_lumps.h"

#include <catch2/catch.hpp>

#include "discretization/surface/surface_tree.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "io/scene_texts.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;

TEST_CASE("A lump is a stiffer material with a finer spacing around it", "[io][lumps]") {
  TempFolder folder;
  const Scene s = readScene(
      folder.write("a.toml", minimal_scene + "[[lump]]\ncentre = [0, 0, 0.03]\nradius = 0.008\nyoung = 30000\n"));
  REQUIRE(s.materials.size() == 2);
  const Material &tissue = s.materials[0].material, &lump = s.materials[1].material;
  CHECK(lump.shear_modulus == Approx(10 * tissue.shear_modulus));  // the tissue has 3 kPa
  CHECK(s.materials[1].region.radius == 0.008);
  REQUIRE(s.discretization.refine.size() == 1);
  CHECK(s.discretization.refine[0].spacing < s.discretization.spacing);
  CHECK(s.discretization.refine[0].centre == Vec3(0, 0, 0.03));
}

TEST_CASE("Lumps at random lie below the skin within their level, apart, and the same for the same seed",
          "[io][lumps]") {
  TempFolder folder;
  for (int level = 1; level <= 3; ++level) {
    const std::string text = minimal_scene + "[lumps]\ncount = 3\nlevel = " + std::to_string(level) + "\nseed = 5\n";
    const Scene s = readScene(folder.write("a.toml", text));
    const SurfaceTree tree(organSurface(s));
    const LumpLevel& limits = lumpLevel(level);
    REQUIRE(s.materials.size() == 4);
    for (std::size_t m = 1; m < 4; ++m) {
      const Region& ball = s.materials[m].region;
      CHECK(ball.radius >= limits.least_radius);
      CHECK(ball.radius <= limits.most_radius);
      const double top = -tree.signedDistance(ball.point) - ball.radius;
      CHECK(top > 0.9 * limits.least_top - 0.1 * limits.most_radius);
      CHECK(top <= limits.most_top + 1e-9);
      for (std::size_t other = 1; other < m; ++other)
        CHECK((s.materials[other].region.point - ball.point).norm() > s.materials[other].region.radius + ball.radius);
    }
    const Scene again = readScene(folder.write("b.toml", text));
    CHECK(again.materials[2].region.point == s.materials[2].region.point);
    const Scene first = readScene(folder.write("c.toml", text + "layout = 1\n"));
    CHECK(first.materials[2].region.point == s.materials[2].region.point);
    const Scene next = readScene(folder.write("d.toml", text + "layout = 2\n"));
    REQUIRE(next.lump_draw);
    CHECK(next.lump_draw->level == level);
    CHECK(next.lump_draw->seed == 5);
    CHECK(next.lump_draw->layout == 2);
    CHECK(next.materials.size() == 4);
    CHECK(next.materials[1].region.point != s.materials[1].region.point);
  }
}

TEST_CASE("Lumps that make no sense are refused with their place", "[io][lumps]") {
  TempFolder folder;
  using Catch::Contains;
  const auto message = [&](const std::string& text) {
    return refusal([&] { readScene(folder.write("a.toml", minimal_scene + text)); });
  };
  CHECK_THAT(message("[[lump]]\ncentre = [0, 0, 0.03]\nradius = 0.008\nyoung = 2000\n"),
             Contains("a.toml:") && Contains("larger \"young\""));
  CHECK_THAT(message("[lumps]\ncount = 20\nlevel = 1\n"), Contains("of 20 lumps fit"));
}
