#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "api/pressed_block.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::test;

namespace {

/// A model from a text with changes, or why there is none.
struct Loaded {
  explicit Loaded(const std::string& text, std::vector<const char*> set = {}, const char* folder = nullptr) {
    auto options = sized<palpate_options>();
    options.set = set.data();
    options.set_count = static_cast<int>(set.size());
    palpate_model* made = nullptr;
    code = palpate_load_text(text.c_str(), folder, "my text", &options, &made, &error);
    model.reset(made);
  }
  palpate_error error = sized<palpate_error>();
  std::int32_t code = 0;
  ModelHandle model;
};

}  // namespace

TEST_CASE("A scene's text in memory is what it is in a file, with changes as if they stood there", "[api]") {
  const Loaded text(touched_block_text);
  REQUIRE(text.code == PALPATE_OK);
  CHECK(describe(text.model).hash == describe(loadBlock()).hash);

  const std::string stiffer = replaced(touched_block_text, "young = 3000", "young = 4000");
  const std::uint64_t expected = describe(loadBlock(stiffer)).hash;
  CHECK(expected != describe(text.model).hash);
  const Loaded changed(touched_block_text, {"material[0].young = 4000"});
  REQUIRE(changed.code == PALPATE_OK);
  CHECK(describe(changed.model).hash == expected);
  const TempFolder folder;
  const std::array set{"material[0].young=4000"};
  auto options = sized<palpate_options>();
  options.set = set.data();
  options.set_count = 1;
  palpate_model* from_file = nullptr;
  REQUIRE(palpate_load(folder.write("block.toml", touched_block_text).c_str(), &options, &from_file, nullptr) ==
          PALPATE_OK);
  CHECK(describe(ModelHandle(from_file)).hash == expected);
}

TEST_CASE("A text's paths start from the folder that it is given", "[api]") {
  const TempFolder folder;
  folder.write("probes.csv", "X,Y,Z\n0,0,0.01\n");
  const std::string text = touched_block_text + "[solve]\nprobes = \"probes.csv\"\n";
  CHECK(Loaded(text, {}, folder.path("").c_str()).code == PALPATE_OK);
  const Loaded elsewhere(text);
  CHECK(elsewhere.code == PALPATE_BAD_INPUT);
  CHECK_THAT(elsewhere.error.text, Catch::StartsWith("my text:") && Catch::Contains("probes.csv"));
}

TEST_CASE("A text or a change that can't be used is told by its name and place", "[api]") {
  const auto refused = [](const Loaded& loaded, std::int32_t code, const std::string& start, const std::string& text) {
    CHECK(loaded.code == code);
    CHECK(loaded.model == nullptr);
    CHECK_THAT(loaded.error.text, Catch::StartsWith(start) && Catch::Contains(text));
  };
  const std::string& good = touched_block_text;
  refused(Loaded(replaced(good, "young = 3000", "young = -1")), PALPATE_BAD_INPUT, "my text:9:9: ", "young");
  refused(Loaded("no TOML at all"), PALPATE_BAD_INPUT, "my text:1:", "");
  refused(Loaded(""), PALPATE_BAD_INPUT, "my text", "organ");
  refused(Loaded(good, {"material[0].young"}), PALPATE_BAD_INPUT, "\"material[0].young\"", "sets no key");
  refused(Loaded(good, {"material[0].young = "}), PALPATE_BAD_INPUT, "\"material[0].young", "sets no key");
  refused(Loaded(good, {"= 5"}), PALPATE_BAD_INPUT, "\"= 5\"", "sets no key");
  refused(Loaded(good, {"material[0].yuong = 5"}), PALPATE_BAD_INPUT, "my text", "yuong");
  refused(Loaded(good, {"material[1].young = 5"}), PALPATE_BAD_INPUT, "my text", "no \"material[1].young\"");
  refused(Loaded(good, {"tool.radius = 0.01\n[camera]"}), PALPATE_BAD_INPUT, "my text", "tool.radius");
  refused(Loaded(good, {"name = \"a\"", nullptr}), PALPATE_BAD_ARGUMENT, "options.set[1] is NULL", "");

  palpate_model* none = nullptr;
  auto options = sized<palpate_options>();
  options.set_count = 1;
  CHECK(palpate_load_text(good.c_str(), nullptr, nullptr, &options, &none, nullptr) == PALPATE_BAD_ARGUMENT);
  options.set_count = -1;
  CHECK(palpate_load_text(good.c_str(), nullptr, nullptr, &options, &none, nullptr) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_load_text(nullptr, nullptr, nullptr, nullptr, &none, nullptr) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_load_text(good.c_str(), nullptr, nullptr, nullptr, nullptr, nullptr) == PALPATE_BAD_ARGUMENT);

  // A caller that was compiled before there were changes.
  options = {};
  options.size = offsetof(palpate_options, set);
  options.set_count = 7;
  REQUIRE(palpate_load_text(good.c_str(), nullptr, nullptr, &options, &none, nullptr) == PALPATE_OK);
  palpate_model_destroy(none);
}

TEST_CASE("Materials, tools and regions have names", "[api]") {
  const std::string tool = "[[tool]]\nshape = \"sphere\"\nradius = 0.01\n";
  const Loaded loaded(block_text + R"([[material]]
name = "lump"
model = "neo-hookean"
young = 9000
poisson = 0.45
[material.region]
shape = "sphere"
centre = [0, 0, 0.015]
radius = 0.01
[[fixed]]
shape = "near-plane"
point = [0.03, 0, 0]
normal = [1, 0, 0]
distance = 1e-6
)" + tool + "position = [0, 0, 0.05]\n" +
                      tool + "position = [0, 0, 0.08]\n" +
                      "[[tool]]\nshape = \"capsule\"\nradius = 0.004\nopening = 0.01\nposition = [0.1, 0, 0.05]\n");
  INFO(loaded.error.text);
  REQUIRE(loaded.code == PALPATE_OK);
  const palpate_model* const model = loaded.model.get();
  const auto names = [&](std::int32_t kind) {
    std::int32_t count = 0;
    REQUIRE(palpate_count(model, kind, &count) == PALPATE_OK);
    std::vector<std::string> result;
    for (int k = 0; k < count; ++k) {
      result.emplace_back(palpate_name(model, kind, k));
      CHECK(palpate_index(model, kind, palpate_name(model, kind, k)) == k);
    }
    CHECK(palpate_name(model, kind, count) == nullptr);
    return result;
  };
  CHECK(names(PALPATE_MATERIAL) == std::vector<std::string>{"material 1", "lump"});
  CHECK(names(PALPATE_TOOL) == std::vector<std::string>{"sphere 1", "sphere 2", "jaws"});
  CHECK(names(PALPATE_REGION) == std::vector<std::string>{"base", "fixed 2"});

  std::int32_t count = 7;
  CHECK(palpate_count(nullptr, PALPATE_TOOL, &count) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_count(model, 4, &count) == PALPATE_BAD_ARGUMENT);
  CHECK(palpate_count(model, PALPATE_TOOL, nullptr) == PALPATE_BAD_ARGUMENT);
  CHECK(count == 7);
  CHECK(palpate_name(nullptr, PALPATE_TOOL, 0) == nullptr);
  CHECK(palpate_name(model, -1, 0) == nullptr);
  CHECK(palpate_name(model, PALPATE_TOOL, -1) == nullptr);
  CHECK(palpate_index(model, PALPATE_TOOL, nullptr) == -1);
  CHECK(palpate_index(model, PALPATE_TOOL, "lump") == -1);
  CHECK(palpate_index(nullptr, PALPATE_MATERIAL, "lump") == -1);
}
