#include <catch2/catch.hpp>

#include "io/scene_file.h"
#include "support/block_text.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using Catch::Contains;

TEST_CASE("A changed key is what it would be in the file", "[scene_change]") {
  const TempFolder folder;
  const std::string path = folder.write("block.toml", test::touched_block_text);
  const std::vector<SceneChange> changes{{"material[0].young", "4000"},
                                         {"tool.position", "[0.01, 0, 0.04]"},
                                         {"dynamics.damping", "30"},
                                         {"name", "\"changed\""}};
  const Scene changed = readScene(path, changes);
  std::string text = replaced(test::touched_block_text, "young = 3000", "young = 4000");
  text = replaced(text, "position = [0, 0, 0.035]", "position = [0.01, 0, 0.04]\n[dynamics]\ndamping = 30");
  const Scene written = readScene(folder.write("written.toml", replaced(text, "\"block\"", "\"changed\"")));
  CHECK(changed.name == "changed");
  CHECK(changed.materials[0].material == written.materials[0].material);
  CHECK(changed.tools[0].position == written.tools[0].position);
  CHECK(changed.dynamics.damping == 30);
  CHECK(changed.set_up_values == written.set_up_values);
  CHECK(changed.set_up_values != readScene(path).set_up_values);
}

TEST_CASE("A change that can't be made is refused with the file and the key", "[scene_change]") {
  const TempFolder folder;
  const std::string path = folder.write("block.toml", test::touched_block_text);
  const auto refused = [&](const std::string& key, const std::string& value) {
    const std::vector<SceneChange> change{{key, value}};
    return refusal([&] { readScene(path, change); });
  };
  CHECK_THAT(refused("material[0].young", "-1"), Contains("block.toml") && Contains("young"));
  CHECK_THAT(refused("material[0].yuong", "1"), Contains("block.toml") && Contains("yuong"));
  CHECK_THAT(refused("material[1].young", "1"), Contains("no \"material[1].young\""));
  CHECK_THAT(refused("material[x].young", "1"), Contains("names no entry of a list"));
  CHECK_THAT(refused("material.young", "1"), Contains("no \"material.young\""));
  CHECK_THAT(refused("name.first", "1"), Contains("no \"name.first\""));
  CHECK_THAT(refused("tool.radius", "0.01\n[camera]"), Contains("tool.radius"));
  CHECK_THAT(refused("tool.radius", "="), Contains("block.toml") && Contains("tool.radius"));
  CHECK_THAT(refused("dynamics.damping", "\"much\""), Contains("block.toml") && Contains("damping"));
}

TEST_CASE("A change in one text is a key and what stands after its first =", "[scene_change]") {
  const auto parts = [](const std::string& text) {
    const SceneChange change = changeFrom(text);
    return change.key + "|" + change.value;
  };
  CHECK(parts("material[0].young=4000") == "material[0].young|4000");
  CHECK(parts("  name =  \"a = b\" ") == "name|\"a = b\"");
  for (const char* text : {"", "name", "name =", "= 3", " = "})
    CHECK_THAT(refusal([&] { changeFrom(text); }), Contains("sets no key to a value"));
}

TEST_CASE("A scene that is no file is read as one, its paths from a folder of its own", "[scene_change]") {
  const TempFolder folder;
  folder.write("points.csv", "X,Y,Z\n0,0,0.01\n");
  const std::string text = test::touched_block_text + "[solve]\nprobes = \"points.csv\"\n";
  const Scene from_text = readScene(SceneText{text, folder.path(""), "mine"});
  const Scene from_file = readScene(folder.write("block.toml", text));
  CHECK(from_text.set_up_values == from_file.set_up_values);
  CHECK(from_text.solve.probes_file == from_file.solve.probes_file);
  CHECK(from_text.place.file == "mine");
  CHECK_THAT(refusal([&] { readScene(SceneText{text, "", "mine"}); }), Contains("mine:") && Contains("points.csv"));
}
