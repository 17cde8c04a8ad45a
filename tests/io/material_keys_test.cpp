#include <catch2/catch.hpp>
#include <string>

#include "io/material_texts.h"
#include "io/scene_file.h"
#include "support/law_values.h"
#include "support/temp_folder.h"

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

TEST_CASE("A scene may choose each registered law, and has all of its parameters", "[io][scene][material]") {
  for (const MaterialLaw& law : materialLaws()) {
    INFO(law.name);
    const Material m = test::sampleMaterial(law);
    TempFolder folder;
    CHECK(readScene(folder.write("s.toml", sceneOf(m))).materials.at(0).material == m);
    for (const Parameter& p : law.parameters)
      CHECK_THAT(problem(sceneOf(m, p.name)), Catch::Contains(std::string("the key \"") + p.name + "\" is missing"));
    for (const MaterialLaw& other : materialLaws())
      forEachParameter(test::sampleMaterial(other), [&](const Parameter& p, std::span<const double> values) {
        if (sceneOf(m).find(std::string("\n") + p.name + " = ") != std::string::npos) return;
        std::string text = sceneOf(m);
        text.insert(text.find("model = "), keyLine(p, values));
        CHECK_THAT(problem(text), Catch::Contains(std::string("\"") + p.name + "\" means nothing to a"));
      });
  }
}
