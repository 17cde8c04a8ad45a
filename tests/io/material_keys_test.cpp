#include <catch2/catch.hpp>
#include <string>

#include "io/material_texts.h"
#include "io/scene_file.h"
#include "support/law_values.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;

namespace {

std::string problem(const std::string& text) {
  TempFolder folder;
  try {
    readScene(folder.write("s.toml", text));
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

}  // namespace

TEST_CASE("What can't relax is refused with its place and what to do", "[io][scene][material]") {
  const auto with = [](const std::string& pairs) {
    return problem(replaced(minimal_scene, "poisson = 0.49\n", "poisson = 0.49\nrelaxation = " + pairs + "\n"));
  };
  CHECK(with("[[0.3, 0.1]]") == "read");
  CHECK(with("[[0.3, 0.1], [0.2, 100], [0.49, 1e-3]]") == "read");
  CHECK_THAT(with("[]"), Catch::Contains("s.toml:10:1: ") && Catch::Contains("has 0 terms") &&
                             Catch::Contains("give 1 to 3 pairs [g, tau]"));
  CHECK_THAT(with("[[0.1, 1], [0.1, 2], [0.1, 3], [0.1, 4]]"), Catch::Contains("has 4 terms"));
  CHECK_THAT(with("[[0.5, 1], [0.5, 2]]"), Catch::Contains("add up to 1 or more") && Catch::Contains("leave some"));
  for (const char* pairs : {"[[0, 1]]", "[[1, 1]]", "[[-0.1, 1]]"})
    CHECK_THAT(with(pairs), Catch::Contains("a share g of \"relaxation\" is not above 0 and below 1"));
  for (const char* pairs : {"[[0.3, 0]]", "[[0.3, -1]]", "[[0.3, 101]]"})
    CHECK_THAT(with(pairs), Catch::Contains("a time tau of \"relaxation\" is not above 0 and up to 100 s"));
  for (const char* pairs : {"[0.3, 1]", "[[0.3]]", "[[0.3, 1, 2]]"})
    CHECK_THAT(with(pairs), Catch::Contains("is not a pair of numbers") && Catch::Contains("like [[0.3, 0.1]"));
  CHECK_THAT(with("0.3"), Catch::Contains("is a number") && Catch::Contains("list of pairs of numbers"));
  CHECK_THAT(with("[[0.3, nan]]"), Catch::Contains("relaxation[0][1] is not finite"));
}

TEST_CASE("A scene may choose each registered law, and has all of its parameters", "[io][scene][material]") {
  for (const MaterialLaw& law : materialLaws()) {
    INFO(law.name);
    Material m = test::sampleMaterial(law);
    for (const CommonMaterialParameter& common : commonMaterialParameters())
      if (!common.is_key) m.*common.member = Material().*common.member;
    TempFolder folder;
    CHECK(readScene(folder.write("s.toml", sceneOf(m))).materials.at(0).material == m);
    for (const Parameter& p : law.parameters) {
      if (p.isRequired()) {
        const std::string missing = std::string("the key \"") + p.name + "\" is missing";
        CHECK_THAT(problem(sceneOf(m, p.name)), Catch::Contains(missing));
      } else {
        const Material read = readScene(folder.write("s.toml", sceneOf(m, p.name))).materials.at(0).material;
        CHECK(read == Material(m).set(p.name, p.fallbackValue()));
      }
    }
    for (const MaterialLaw& other : materialLaws())
      forEachParameter(test::sampleMaterial(other), [&](const Parameter& p, std::span<const double> values) {
        if (!isSceneKey(p) || sceneOf(m).find(std::string("\n") + p.name + " = ") != std::string::npos) return;
        std::string text = sceneOf(m);
        text.insert(text.find("model = "), keyLine(p, values));
        CHECK_THAT(problem(text), Catch::Contains(std::string("\"") + p.name + "\" means nothing to a"));
      });
  }
}
