#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <set>

#include "base/build_info.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "io/scene_keys.h"
#include "io/text_file.h"
#include "io/tool_script.h"
#include "support/temp_folder.h"

using namespace palpate;

namespace {

const std::string begin_mark = "<!-- reference -->\n", end_mark = "<!-- end of reference -->\n";

/// Compares what stands between the marks of a README; with PALPATE_WRITE_REFERENCE set, writes it.
void requireReference(const std::string& path, const std::string& reference) {
  std::string text = readWholeFile(path);
  const std::size_t begin = text.find(begin_mark), end = text.find(end_mark);
  REQUIRE(begin != std::string::npos);
  REQUIRE(end != std::string::npos);
  const std::size_t inside = begin + begin_mark.size();
  const std::string wanted = "\n" + reference + "\n";
  if (std::getenv("PALPATE_WRITE_REFERENCE") != nullptr) {
    text.replace(inside, end - inside, wanted);
    std::ofstream(path, std::ios::binary) << text;
    return;
  }
  INFO("PALPATE_WRITE_REFERENCE=1 "
       << "io_tests \"[reference]\" writes it anew: " << path);
  CHECK(text.substr(inside, end - inside) == wanted);
}

}  // namespace

TEST_CASE("assets/scenes/README.md has the parser's keys", "[io][reference]") {
  requireReference(sourceFolder() + "/assets/scenes/README.md", sceneReference());
}

TEST_CASE("assets/tools/README.md has the parser's keys", "[io][reference]") {
  requireReference(sourceFolder() + "/assets/tools/README.md", toolScriptReference());
}

TEST_CASE("The reference has a row for every key, and no key twice in a table", "[io][reference]") {
  const std::string reference = sceneReference();
  std::set<std::pair<std::string, std::string>> seen;
  for (const KeySpec& key : sceneKeys()) {
    INFO(key.table << "." << key.name);
    CHECK(seen.insert({key.table, key.name}).second);
    CHECK(reference.find(std::string("| `") + key.name + "` | ") != std::string::npos);
    CHECK(reference.find(key.meaning) != std::string::npos);
  }
}

TEST_CASE("The tutorial's scene has nine lines, each with a comment, and loads", "[io][reference][whole]") {
  const std::string text = readWholeFile(sourceFolder() + "/assets/scenes/README.md");
  const std::string fence = "```toml\n";
  const std::size_t begin = text.find(fence) + fence.size();
  REQUIRE(begin < text.find("## Reference"));
  const std::string block = text.substr(begin, text.find("```", begin) - begin);
  CHECK(std::count(block.begin(), block.end(), '\n') == 9);
  CHECK(std::count(block.begin(), block.end(), '#') == 9);

  const TempFolder folder;
  const Model model = loadModel(readScene(folder.write("my.toml", block)), {}, ModelCache(""));
  CHECK(model.tools.first().first_contact_travel == Approx(0.01).margin(1e-4));  // "10 mm above the slab"
  CHECK(model.materials[0].density == 1050);  // "all keys from here on describe the tissue"
}
