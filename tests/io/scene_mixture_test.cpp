#include <catch2/catch.hpp>

#include "imaging/membership.h"
#include "imaging/nifti.h"
#include "io/scene_file.h"
#include "io/scene_texts.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using Catch::Matchers::Contains;

namespace {

const std::string fluid =
    "[[material]]\nmodel = \"neo-hookean\"\nyoung = 100\npoisson = 0.49\nmembership = \"csf.nii.gz\"\n";

std::string imageBytes(int size, double edge = 1e-3) {
  return niftiFrom(Image(ImageGrid({size, size, size}, edge * Mat3::Identity(), Vec3::Zero()), 0.5F),
                   NiftiType::Float32, true);
}

}  // namespace

TEST_CASE("A membership is read beside the scene, with its mask", "[io][scene_file]") {
  TempFolder folder;
  folder.write("csf.nii.gz", imageBytes(3));
  folder.write("mask.nii.gz", imageBytes(3));
  const Scene scene = readScene(folder.write("s.toml", minimal_scene + fluid + "mask = \"mask.nii.gz\"\n"));
  REQUIRE(scene.materials.size() == 2);
  REQUIRE(scene.materials[1].membership);
  CHECK_FALSE(scene.materials[1].everywhere);
  CHECK(scene.materials[1].membership->share(1, 1, 1) == 0.5F);
  CHECK(scene.materials[1].membership->mask);
}

TEST_CASE("Memberships that can't be mixed are refused with the reason", "[io][scene_file]") {
  TempFolder folder;
  folder.write("csf.nii.gz", imageBytes(3));
  folder.write("other.nii.gz", imageBytes(4));
  const auto refused = [&](const std::string& text) {
    return refusal([&] { readScene(folder.write("s.toml", text)); });
  };
  CHECK_THAT(refused(minimal_scene + replaced(fluid, "csf.nii.gz", "no.nii.gz")), Contains("no image"));
  CHECK_THAT(refused(minimal_scene + fluid + fluid), Contains("second material with a membership"));
  CHECK_THAT(refused(minimal_scene + fluid + "mask = \"other.nii.gz\"\n"), Contains("not those of the membership"));
  CHECK_THAT(refused(minimal_scene + fluid + "region = { shape = \"sphere\", centre = [0, 0, 0], radius = 1 }\n"),
             Contains("region"));
  CHECK_THAT(refused(minimal_scene + replaced(fluid, "poisson = 0.49\n", "poisson = 0.49\nrelaxation = [[0.1, 1]]\n")),
             Contains("without relaxation"));
  folder.write("percent.nii.gz", niftiFrom(Image(ImageGrid({3, 3, 3}, 1e-3 * Mat3::Identity(), Vec3::Zero()), 30),
                                           NiftiType::Float32, true));
  CHECK_THAT(refused(minimal_scene + replaced(fluid, "csf.nii.gz", "percent.nii.gz")),
             Contains("values from 30 to 30") && Contains("0 to 1"));
  const std::string ogden = replaced(minimal_scene, "\"neo-hookean\"\nyoung = 3000\npoisson = 0.49",
                                     "\"ogden\"\nmu = [1000]\nalpha = [2]\nD1 = 1e-4");
  CHECK_THAT(refused(ogden + fluid), Contains("only neo-Hookean"));
  const std::string first =
      replaced(minimal_scene, "poisson = 0.49\n", "poisson = 0.49\nmembership = \"csf.nii.gz\"\n");
  CHECK_THAT(refused(first), Contains("first material has a membership"));
}

TEST_CASE("Measured points take no region and no motion", "[io][scene_file]") {
  TempFolder folder;
  folder.write("e.csv", "x,y,z\n0,0,50\n");
  const std::string points = "[[prescribed]]\npoints = \"e.csv\"\nunit = \"mm\"\nduration = 1\n";
  const auto refused = [&](const std::string& text) {
    return refusal([&] { readScene(folder.write("s.toml", minimal_scene + text)); });
  };
  CHECK_THAT(refused(points), Contains("frame"));
  CHECK_THAT(refused(points + "frame = \"ras\"\ntranslation = [0, 0, 1]\n"), Contains("translation"));
  CHECK_THAT(refused(points + "frame = \"ras\"\nshape = \"sphere\"\n"), Contains("shape"));
  CHECK_THAT(refused(replaced(points, "e.csv", "f.csv") + "frame = \"ras\"\n"), Contains("f.csv does not exist"));
  CHECK_THAT(refused("[[prescribed]]\nshape = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1\ntranslation = [0, 0, 1]\n"
                     "duration = 1\nunit = \"mm\"\n"),
             Contains("unit"));
}
