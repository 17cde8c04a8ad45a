#include "io/toml_depth.h"

#include <catch2/catch.hpp>

#include "io/scene_file.h"
#include "io/scene_texts.h"
#include "io/toml_table.h"
#include "support/temp_folder.h"

using namespace palpate;
using Catch::Contains;

namespace {

constexpr int deep = 50000;

std::string repeated(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

}  // namespace

TEST_CASE("TOML nested deeper than any key of ours is refused before it uses up the stack", "[io][toml][refusal]") {
  const auto message = [](const std::string& text) { return refusal([&] { parseToml(text, "s.toml"); }); };
  CHECK_THAT(message("x = 1\na" + repeated(".a", deep) + " = 1\n"),
             Contains("s.toml:2:64: a key of more than 32 parts"));
  CHECK_THAT(message("[a" + repeated(".a", deep) + "]\n"), Contains("s.toml:1:65: a key of"));
  CHECK_THAT(message("[[a" + repeated(" . \"a.b\"", deep) + "]]\n"), Contains("s.toml:1:") && Contains("a key of"));
  CHECK_THAT(message("k = { a" + repeated(".'a'", deep) + " = 1 }\n"), Contains("s.toml:1:") && Contains("a key of"));
  CHECK_THAT(message("a = '''\n...\n'''\nb = " + repeated("[", deep)),
             Contains("s.toml:4:37: more than 32 lists or tables within one another"));
  CHECK_THAT(message("b = " + repeated("{ a = ", deep)), Contains("s.toml:1:197: more than 32 lists"));
}

TEST_CASE("A scene nested too deep is refused at its place", "[io][toml][refusal]") {
  TempFolder folder;
  const std::string path = folder.write("deep.toml", minimal_scene + "a" + repeated(".a", deep) + " = 1\n");
  CHECK_THAT(refusal([&] { readScene(path); }), Contains("deep.toml:14:64: a key of more than 32 parts"));
}

TEST_CASE("TOML that only looks nested is read", "[io][toml]") {
  const auto read = [](const std::string& text) { return parseToml(text, "s.toml").size(); };
  const std::string dots = repeated(".", 100), brackets = repeated("[", 100);
  // Points and brackets in strings and comments.
  CHECK(read("a = \"" + dots + "\\\"" + brackets + "\" # " + dots + brackets + "\nb = 1\n") == 2);
  CHECK(read("a = '" + dots + "\\' # " + brackets + "\nb = '''" + dots + "''\n" + dots + "'''''\nc = 1\n") == 3);
  CHECK(read("a = \"\"\"\"" + brackets + "\\\"\"\"\\\"" + dots + "\"\"\"\nb.c = 1\n") == 2);
  // Many side by side.
  CHECK(read("a = [" + repeated("[1.5, 2.5], ", 1000) + "]\n" + repeated("[[b.c]]\nx = [1.0]\n", 1000)) == 2);
  // As deep as is allowed.
  CHECK(read("a" + repeated(".a", 31) + " = " + repeated("[", 32) + repeated("]", 32) + "\n") == 1);
}
