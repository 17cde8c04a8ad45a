#include <catch2/catch.hpp>

#include "contact/rigid_bodies.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "io/scene_texts.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using Catch::Contains;

namespace {

const std::string table = "region = { shape = \"half-space\", point = [0, 0, 0], normal = [0, 0, 2] }\n";

/// A block that lies on what is said.
std::string lying(const std::string& rigid) {
  return "organ = { solid = \"box\", size = [0.05, 0.05, 0.03] }\ndiscretization = { spacing = 0.012 }\n"
         "[[material]]\nmodel = \"neo-hookean\"\nyoung = 3000\npoisson = 0.45\ndensity = 1000\n" +
         rigid;
}

}  // namespace

TEST_CASE("Rigid bodies are read, a skull as one of them", "[io][scene][rigid]") {
  TempFolder folder;
  folder.write("t.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  const Scene scene = readScene(folder.write(
      "s.toml", lying("[[rigid]]\nname = \"table\"\nfriction = 0.4\n" + table +
                      "[[rigid]]\nsurface = \"t.obj\"\nunit = \"mm\"\nclearance = 0.002\ntranslation = [0, 0, 0.01]\n"
                      "curve_table = [[0, 0], [2, 1]]\n[skull]\nfrom = \"organ\"\nclearance = 0.001\n")));
  REQUIRE(scene.rigid.size() == 3);
  CHECK((scene.rigid[0].name == "skull" && scene.rigid[0].encloses && scene.rigid[0].of_organ));
  CHECK((scene.rigid[1].name == "table" && scene.rigid[1].friction == 0.4 && !scene.rigid[1].motion.moves()));
  CHECK(scene.rigid[1].region.normal == Vec3::UnitZ());
  CHECK((scene.rigid[2].name == "rigid 2" && scene.rigid[2].surface && !scene.rigid[2].encloses));
  CHECK(motionEnd(scene) == 2);
  CHECK(largestToolSpeed(scene) == scene.tools[0].max_speed);  // 5 mm/s is slower
}

TEST_CASE("Bad rigid bodies are refused at their place, with advice", "[io][scene][rigid]") {
  TempFolder folder;
  const auto says = [&](const std::string& rigid) {
    return refusal([&] { readScene(folder.write("s.toml", lying(rigid))); });
  };
  const std::string body = "[[rigid]]\n";
  CHECK_THAT(says(""), Contains("[[rigid]] that it lies on"));
  CHECK_THAT(says(body), Contains("s.toml:8:") && Contains("neither region nor surface"));
  CHECK_THAT(says(body + table + "surface = \"t.obj\"\n"), Contains("both \"region\" and \"surface\""));
  CHECK_THAT(says(body + table + "unit = \"mm\"\n"), Contains("means nothing to a region"));
  CHECK_THAT(says(body + table + "friction = -1\n"), Contains("out of range"));
  CHECK_THAT(says(body + table + "name = \"tool 2\"\n"), Contains("does not begin with \"tool\""));
  CHECK_THAT(says(body + table + body + table + "name = \"rigid 1\"\n"), Contains("is taken"));
  CHECK_THAT(says(body + table + "translation = [0, 0, 1]\n"), Contains("duration"));
  CHECK_THAT(says(body + table + "duration = 1\n"), Contains("neither a translation nor a rotation"));
  CHECK_THAT(says(body + "region = { shape = \"shell\", distance = 0.01 }\n"), Contains("can't be a near-plane"));
  CHECK_THAT(says(body + "region = { shape = \"box\", min = [0, 0, 0], max = [1, 1, 0] }\n"), Contains("no thickness"));
  CHECK_THAT(says(body + "surface = \"none.obj\"\nunit = \"mm\"\n"), Contains("none.obj"));
  std::string many;
  for (int k = 0; k <= max_rigid_bodies; ++k) many += body + table;
  CHECK_THAT(says(many), Contains("more than 8 rigid bodies"));

  const std::string file = folder.write(
      "deep.toml", lying(body + "region = { shape = \"half-space\", point = [0, 0, 0.004], normal = [0, 0, 1] }\n"));
  CHECK_THAT(refusal([&] { loadModel(readScene(file)); }),
             Contains("deep.toml:8:") && Contains("reaches 4 mm into the rigid body \"rigid 1\" at ("));
}
