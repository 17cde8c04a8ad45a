#include "app/run/options.h"
#include "io/find_asset.h"

#include <catch2/catch.hpp>

#include <vector>

#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::app;

namespace {

ParsedOptions parse(std::vector<const char*> words) {
  words.insert(words.begin(), "palpate");
  return parseOptions(static_cast<int>(words.size()), words.data());
}

}  // namespace

TEST_CASE("A scene alone means a window of 1280x800 and the scene's own values", "[options]") {
  const ParsedOptions parsed = parse({"liver"});
  REQUIRE(parsed.options);
  const Options& o = *parsed.options;
  CHECK(o.scene == "liver");
  CHECK_FALSE(o.offscreen);
  CHECK_FALSE(o.as_fast_as_possible);
  CHECK_FALSE(o.seconds);
  CHECK_FALSE(o.rate_hz);
  CHECK_FALSE(o.threads);
  CHECK(o.use_cache);
  CHECK(o.width == 1280);
  CHECK(o.height == 800);
}

TEST_CASE("Each option reaches its field", "[options]") {
  const ParsedOptions parsed = parse({"a.toml",
                                      "--offscreen",
                                      "--seconds",
                                      "2.5",
                                      "--rate",
                                      "1000",
                                      "--tool",
                                      "t.toml",
                                      "--record",
                                      "r.rec",
                                      "--out",
                                      "dir",
                                      "--size",
                                      "640x480",
                                      "--snapshot-at",
                                      "1.5",
                                      "--threads",
                                      "2",
                                      "--as-fast-as-possible",
                                      "--no-cache"});
  INFO(parsed.message);
  REQUIRE(parsed.options);
  const Options& o = *parsed.options;
  CHECK(o.scene == "a.toml");
  CHECK(o.offscreen);
  CHECK(o.seconds.value() == 2.5);
  CHECK(o.rate_hz.value() == 1000);
  CHECK(o.tool_script == "t.toml");
  CHECK(o.record == "r.rec");
  CHECK(o.out == "dir");
  CHECK(o.width == 640);
  CHECK(o.height == 480);
  CHECK(o.snapshot_at == std::vector<double>{1.5});
  CHECK(o.threads.value() == 2);
  CHECK(o.as_fast_as_possible);
  CHECK_FALSE(o.use_cache);
  CHECK(parse({"a.toml", "--replay", "r.rec"}).options.value().replay == "r.rec");
  CHECK_FALSE(o.soak_minutes);
  const Options soak = parse({"--soak", "60", "kidney", "--fast"}).options.value();
  CHECK(soak.soak_minutes.value() == 60);
  CHECK(soak.scene == "kidney");
  CHECK(soak.as_fast_as_possible);
  CHECK_FALSE(soak.rough);
  const Options rough = parse({"--soak", "2", "--rough", "--seed", "7"}).options.value();
  CHECK(rough.rough);
  CHECK(rough.seed.value() == 7);
  CHECK(parse({"--soak", "1.5"}).options.value().scene == "liver");
  CHECK(parse({"--scores", "out"}).options.value().scores == "out");
  CHECK(parse({"a.toml", "--trainee-name", "A. M"}).options.value().trainee_name == "A. M");
}

TEST_CASE("--help names every option with an example and is no error", "[options]") {
  const ParsedOptions parsed = parse({"--help"});
  CHECK_FALSE(parsed.options);
  CHECK(parsed.exit_code == 0);
  for (const char* option : {"--offscreen", "--seconds",     "--rate",
                             "--tool",      "--record",      "--replay",
                             "--out",       "--size",        "--as-fast-as-possible",
                             "--threads",   "--snapshot-at", "--no-cache",
                             "--soak",      "--rough",       "--seed",
                             "--camera",    "--view",        "--field",
                             "--range",     "--show",        "--hide",
                             "--compare",   "--tolerance",   "--expect",
                             "--strict",    "--answers",     "--trainee-name",
                             "--scores"}) {
    INFO(option);
    const auto at = parsed.message.find("  " + std::string(option));
    REQUIRE(at != std::string::npos);
    // The option's own text, up to the next option, has an example.
    const std::string text = parsed.message.substr(at, parsed.message.find("\n  --", at + 1) - at);
    CHECK(text.find("e.g.") != std::string::npos);
  }
}

TEST_CASE("A line that can't be used is refused with exit code 2 and a message that names the culprit", "[options]") {
  struct Case {
    std::vector<const char*> words;
    const char* named;
  };
  const Case cases[] = {
      {{}, "SCENE"},
      {{"liver", "--seconds", "-1"}, "--seconds"},
      {{"liver", "--seconds", "nan"}, "--seconds"},
      {{"liver", "--seconds", "soon"}, "--seconds"},
      {{"liver", "--rate", "50"}, "--rate"},
      {{"liver", "--rate", "2001"}, "--rate"},
      {{"liver", "--threads", "0"}, "--threads"},
      {{"liver", "--threads", "1.5"}, "--threads"},
      {{"liver", "--size", "1280"}, "--size"},
      {{"liver", "--size", "1280x"}, "--size"},
      {{"liver", "--size", "-1280x800"}, "--size"},
      {{"liver", "--size", "10x10"}, "--size"},
      {{"liver", "--size", "99999x800"}, "--size"},
      {{"liver", "--faster"}, "--faster"},
      {{"liver", "--soak", "0"}, "--soak"},
      {{"liver", "--soak"}, "--soak"},
      {{"liver", "--soak", "5", "--seconds", "2"}, "--seconds"},
      {{"liver", "--soak", "5", "--tool", "a"}, "--tool"},
      {{"liver", "--soak", "5", "--replay", "a"}, "--replay"},
      {{"liver", "--soak", "5", "--record", "a"}, "--record"},
      {{"liver", "--rough"}, "--soak"},
      {{"liver", "--seed", "3"}, "--soak"},
      {{"liver", "--soak", "5", "--seed", "-3"}, "--seed"},
      {{"liver", "kidney"}, "kidney"},
      {{"liver", "--tool", "a", "--replay", "b"}, "--replay"},
      {{"liver", "--snapshot-at", "1"}, "--snapshot-at"},
      {{"liver", "--offscreen", "--seconds", "1", "--snapshot-at", "2"}, "--snapshot-at"},
      {{"liver", "--offscreen", "--snapshot-at", "1,soon"}, "--snapshot-at"},
      {{"liver", "--no-panels"}, "--no-panels"},
      {{"liver", "--offscreen", "--camera", "left"}, "--camera"},
      {{"liver", "--offscreen", "--view", "inside"}, "--view"},
      {{"liver", "--offscreen", "--field", "heat"}, "--field"},
      {{"liver", "--offscreen", "--range", "0:1"}, "--range"},
      {{"liver", "--offscreen", "--field", "J", "--range", "1:0"}, "--range"},
      {{"liver", "--offscreen", "--show", "bones"}, "bones"},
      {{"liver", "--compare", "a.png"}, "--compare"},
      {{"liver", "--answers", "--replay", "a.rec"}, "--answers"},
      {{"liver", "--scores", "out"}, "--scores"},
      {{"liver", "--animation", "a.png"}, "--animation"},
      {{"liver", "--offscreen", "--animation", "a.png"}, "--animation"},
      {{"liver", "--offscreen", "--animation", "a.png", "--seconds", "100"}, "--animation"},
  };
  for (const Case& c : cases) {
    const ParsedOptions parsed = parse(c.words);
    INFO(parsed.message);
    CHECK_FALSE(parsed.options);
    CHECK(parsed.exit_code == 2);
    CHECK(parsed.message.find(c.named) != std::string::npos);
    CHECK(parsed.message.find('\n') == std::string::npos);  // one message, one line
  }
}

TEST_CASE("A scene is a file, or the name of one in the scenes folder", "[options]") {
  const TempFolder folder;
  for (const char* name : {"liver.toml", "kidney.toml", "README.md"}) folder.write(name, "\n");
  const std::string scenes = folder.path("");
  CHECK(findScene("liver", scenes) == folder.path("liver.toml"));
  CHECK(findScene(folder.path("README.md"), scenes) == folder.path("README.md"));  // a file that is there is taken
  CHECK(findScene(folder.path("."), scenes) == folder.path("."));                  // a folder: the reader says so

  using Catch::Contains;
  const auto message = [&](const char* scene) { return refusal([&] { findScene(scene, scenes); }); };
  CHECK_THAT(message("livr"), Contains("no scene file \"livr\"; did you mean liver? ") &&
                                  Contains("kidney and liver") && !Contains("README"));
  CHECK_THAT(message("./kidny.toml"), Contains("did you mean kidney?"));
  CHECK_THAT(message("spleen"), !Contains("did you mean") && Contains("kidney and liver"));
  CHECK_THAT(refusal([&] { findScene("liver", folder.path("none")); }),
             Contains("no scene file \"liver\"; name a file"));
}

TEST_CASE("A tool script is a file, or the name of one in assets/tools", "[options]") {
  using Catch::Contains;
  CHECK(findToolScript("drag_across") == assetFolder("tools") + "/drag_across.toml");
  CHECK(findToolScript(findToolScript("drag_across")) == findToolScript("drag_across"));
  CHECK_THAT(refusal([] { findToolScript("drag_acros.toml"); }),
             Contains("no tool script \"drag_acros.toml\"; did you mean drag_across? ") &&
                 Contains("one of drag_across") && Contains("indent_hold_retract"));
}

TEST_CASE("The demo is the window's, and rests after as long as is asked", "[options]") {
  CHECK(parse({"liver"}).options->idle_seconds == 30);
  const ParsedOptions parsed = parse({"liver", "--demo", "--idle", "60"});
  REQUIRE(parsed.options);
  CHECK(parsed.options->demo);
  CHECK(parsed.options->idle_seconds == 60);
  CHECK(parse({"liver", "--demo", "--offscreen"}).exit_code == 2);
  CHECK(parse({"liver", "--idle", "0"}).exit_code == 2);
  CHECK(parse({"liver", "--close"}).exit_code == 2);  // of off-screen pictures
  CHECK(parse({"liver", "--close", "--offscreen"}).options->picture.close);
}
