#include "io/tool_script.h"
#include "base/build_info.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "support/temp_folder.h"

using namespace palpate;
using Catch::Contains;

namespace {

const std::string script_text =
    "interpolation = \"linear\"\n"
    "[[keyframe]]\ntime = 1.0\nadvance = -0.002\n"
    "[[keyframe]]\ntime = 2\nadvance = 0.004\nslide = [0.01, 0.02]\n"
    "[[keyframe]]\ntime = 4\nadvance_radii = 0.5\nslide_radii = [0, -1]\n";

Pose tilted() {
  Pose start;
  start.position = {1, 2, 3};
  // Tool axis (+z, into the handle) along world +x: the tool advances along -x.
  start.orientation = Quat(Eigen::AngleAxisd(EIGEN_PI / 2, Vec3::UnitY()));
  return start;
}

}  // namespace

TEST_CASE("A tool script moves along the tip and sideways from the start pose", "[io][tool]") {
  TempFolder folder;
  const ToolScript script = readToolScript(folder.write("s.toml", script_text), 0.01);
  const double touch = 0.05;
  const Pose start = tilted();
  const auto advance = [&](double time) { return start.toLocal(poseAt(script, start, touch, time).position); };
  CHECK(script.name == "s");
  CHECK(script.duration() == 4);
  // From the start pose to 2 mm above the skin: 48 mm in 1 s.
  CHECK(poseAt(script, start, touch, 0).position == start.position);
  CHECK((advance(0.5) - Vec3(0, 0, -0.024)).norm() < 1e-15);
  CHECK((advance(1.0) - Vec3(0, 0, -0.048)).norm() < 1e-15);
  CHECK((advance(1.5) - Vec3(0.005, 0.01, -0.051)).norm() < 1e-15);
  CHECK((advance(2.0) - Vec3(0.01, 0.02, -0.054)).norm() < 1e-15);
  CHECK((advance(4.0) - Vec3(0, -0.01, -0.055)).norm() < 1e-15);
  CHECK((advance(9.0) - Vec3(0, -0.01, -0.055)).norm() < 1e-15);
  // In the world: -x.
  CHECK((poseAt(script, start, touch, 1.0).position - Vec3(1 - 0.048, 2, 3)).norm() < 1e-15);
  CHECK(poseAt(script, start, touch, 1.7).orientation.coeffs() == start.orientation.coeffs());
}

TEST_CASE("Smooth scripts rest at each keyframe and pass the middle half way", "[io][tool]") {
  TempFolder folder;
  const ToolScript script = readToolScript(
      folder.write(
          "s.toml",
          "from_touch = false\n[[keyframe]]\ntime = 0\nadvance = 0.001\n[[keyframe]]\ntime = 2\nadvance = 0.011\n"),
      1);
  const auto depth = [&](double time) { return -poseAt(script, Pose{}, 99, time).position.z(); };
  CHECK(depth(0) == 0.001);
  CHECK(depth(1) == Approx(0.006).epsilon(1e-12));
  CHECK(depth(2) == 0.011);
  CHECK(depth(0.5) == Approx(0.001 + 0.01 * (10 / 64.0 - 15 / 256.0 + 6 / 1024.0)).epsilon(1e-12));
  CHECK(depth(0.01) - depth(0) < 1.3e-8);  // 10 t^3 of 10 mm, t = 0.005
  CHECK(depth(2) - depth(1.99) < 1.3e-8);
}

TEST_CASE("Bad tool scripts are refused at their place", "[io][tool][refusal]") {
  TempFolder folder;
  const auto message = [&](const std::string& text) {
    return refusal([&] { readToolScript(folder.write("s.toml", text), 0.01); });
  };
  CHECK_THAT(message(""), Contains("\"keyframe\" is missing") && Contains("[[keyframe]]"));
  CHECK_THAT(message("keyframe = []\n"), Contains("s.toml:1:12: \"keyframe\" is empty"));
  CHECK_THAT(message("[[keyframe]]\ntime = 1\n"), Contains("s.toml:1:1: neither \"advance\" nor \"advance_radii\""));
  CHECK_THAT(message("[[keyframe]]\ntime = 1\nadvance = 0\nadvance_radii = 1\n"), Contains("s.toml:3:1: both"));
  CHECK_THAT(message("[[keyframe]]\nadvance = 0\n"), Contains("\"time\" is missing in [[keyframe]]"));
  CHECK_THAT(message("[[keyframe]]\ntime = -1\nadvance = 0\n"), Contains("s.toml:2:8:") && Contains("0 .. 1e+06 s"));
  CHECK_THAT(message("[[keyframe]]\ntime = 1\nadvance = 0\n[[keyframe]]\ntime = 1\nadvance = 0\n"),
             Contains("s.toml:5:1: this keyframe is not later"));
  CHECK_THAT(message("[[keyframe]]\ntime = 1\ndepth = 0\n"),
             Contains("s.toml:3:1: unknown key \"depth\"") && Contains("\"advance\"?"));
  std::string deep = "a";
  for (int i = 0; i < 50000; ++i) deep += ".a";
  CHECK_THAT(message("interpolation = \"linear\"\n" + deep + " = 1\n"), Contains("s.toml:2:64: a key of more than"));
  CHECK_THAT(message("name = \"press\\r\"\n"), Contains("s.toml:1:1: \"name\" is \"press?\""));
  CHECK_THAT(message("[[keyframe]]\ntime = 1\nadvance = 0\nslide = [1.7e308, 1.7e308]\n"),
             Contains("s.toml:4:10: slide[0]") && Contains("-10 .. 10 m"));
  // What would overflow a number of ticks, or leave the world.
  CHECK_THAT(message("[[keyframe]]\ntime = 1e308\nadvance = 0\n"), Contains("s.toml:2:8:") && Contains("1e+06"));
  CHECK_THAT(message("[[keyframe]]\ntime = inf\nadvance = 0\n"), Contains("s.toml:2:8:"));
  CHECK_THAT(message("[[keyframe]]\ntime = 1\nadvance = 1e308\n"), Contains("s.toml:3:11:") && Contains("-10 .. 10"));
  CHECK_THAT(message("[[keyframe]]\ntime = 1\nadvance_radii = -1e308\n"), Contains("s.toml:3:17:"));
  CHECK_THAT(message("[[keyframe]]\ntime = 1\nadvance = 0\nslide = [0, 1e300]\n"), Contains("s.toml:4:"));
  CHECK_THAT(message("interpolation = \"cubic\"\n" + script_text.substr(script_text.find("[["))),
             Contains("linear or smooth"));
}

TEST_CASE("The scripts in assets/tools start at the start pose, press gently, and end lifted off",
          "[io][tool][assets]") {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(sourceFolder() + "/assets/tools")) {
    if (entry.path().extension() != ".toml") continue;
    ++count;
    INFO(entry.path());
    const double radius = 0.01, touch = 0.02;
    const ToolScript script = readToolScript(entry.path().string(), radius);
    double deepest = -1, fastest = 0;
    Vec3 before = poseAt(script, Pose{}, touch, 0).position;
    CHECK(before.norm() == 0);
    for (double time = 0.002; time <= script.duration(); time += 0.002) {
      const Vec3 now = poseAt(script, Pose{}, touch, time).position;
      deepest = std::max(deepest, -now.z() - touch);
      fastest = std::max(fastest, (now - before).norm() / 0.002);
      before = now;
    }
    CHECK(deepest > 0.2 * radius);
    CHECK(deepest <= 0.5 * radius + 1e-12);
    CHECK(fastest < 0.1);  // m/s
    CHECK(-before.z() < touch);
  }
  CHECK(count >= 2);
}
