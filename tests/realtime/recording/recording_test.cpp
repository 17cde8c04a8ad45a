#include "realtime/recording/recording_file.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <limits>
#include <numbers>
#include <string>

#include "base/input_error.h"
#include "io/output_file.h"
#include "mechanics/materials/material_law.h"
#include "model/model_hash.h"
#include "realtime/fakes.h"
#include "support/law_values.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;

namespace {

/// A file of this test alone.
struct TemporaryFile : TempFolder {
  const std::string file = path("session.rec");
  void put(const std::string& text) const { write("session.rec", text); }
};

Recording everyKind() {
  Recording recording;
  recording.scene = "a scene with spaces";
  recording.model_hash = 0x00ff'1234'5678'9abcULL;
  recording.rate_hz = 1000.0 / 3;
  recording.ticks = 1000;
  Pose pose;
  pose.position = Vec3(0.1, -std::numbers::pi, std::numeric_limits<double>::denorm_min());
  pose.orientation = Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  const double mu[] = {1000, 500.5}, alpha[] = {2, -1.0 / 3};
  const Material ogden = Material::ogden(mu, alpha, 2, 4e-5, 1000);
  Material neo = Material::neoHookean(1e3 / 7, 0.123456789, 1060);
  neo.barrier_strength = 0.1;
  neo.barrier_J0 = 1.0 / 3;
  recording.changes = {{0, Request::moveTool(pose)},
                       {1, Request::pull(411, Vec3(1e-300, 2, 1e300))},
                       {1, Request::simple(Request::Kind::ReleasePull)},
                       {7, Request::setFriction(0.3)},
                       {7, Request::setFriction(0.2, 1)},
                       {8, Request::setMaterial(0, neo)},
                       {8, Request::setMaterial(1, ogden)},
                       {9, Request::setGravity(Vec3(1.0 / 3, 0, -9.81))},
                       {9, Request::setForce(411, Vec3(0.1, -1.0 / 7, 1e-300))},
                       {9, Request::setForce(-1, Vec3::Zero())},
                       {10, Request::pin(411, Vec3(0.1, -1.0 / 7, 1e-300))},
                       {10, Request::unpin(411)},
                       {10, Request::unpin(-1)},
                       {10, Request::moveRegion(3, Vec3(1.0 / 3, 0, -2e-3))},
                       {10, Request::moveRegion(-1, Vec3::Zero())},
                       {999, Request::simple(Request::Kind::Reset)},
                       {999, Request::simple(Request::Kind::Restart)},
                       {999, Request::simple(Request::Kind::Undo)},
                       {999, Request::mark(Vec3(0.1, 1.0 / 3, -2e-3), 3)},
                       {999, Request::simple(Request::Kind::Unmark)},
                       {999, Request::goToPlace({17, 0, -1, -1})},
                       {1000, Request::simple(Request::Kind::Submit)}};
  for (const MaterialLaw& law : materialLaws())
    recording.changes.insert(recording.changes.begin() + 5, {8, Request::setMaterial(0, test::sampleMaterial(law))});
  return recording;
}

const std::string kGood =
    "palpate-recording 3\n"
    "scene liver\n"
    "model 0123456789abcdef\n"
    "rate_hz 500\n"
    "0 tool 0 0 0.1  1 0 0 0\n"
    "12 pull 411 0.01 0 0.12\n"
    "15 release\n"
    "end 500\n";

std::string with(const std::string& from, const std::string& to) { return replaced(kGood, from, to); }

}  // namespace

TEST_CASE("A recording is read as it was written, bit for bit", "[recording]") {
  const TemporaryFile temporary;
  const Recording written = everyKind();
  writeWholeFile(temporary.file, toText(written));
  const Recording read = readRecording(temporary.file);
  CHECK(read.scene == written.scene);
  CHECK(read.model_hash == written.model_hash);
  CHECK(read.rate_hz == written.rate_hz);
  CHECK(read.ticks == written.ticks);
  REQUIRE(read.changes.size() == written.changes.size());
  for (std::size_t c = 0; c < read.changes.size(); ++c) {
    const Request& a = read.changes[c].request;
    const Request& b = written.changes[c].request;
    CHECK(read.changes[c].tick == written.changes[c].tick);
    CHECK(a.kind == b.kind);
    CHECK(a.index == b.index);
    CHECK(a.value == b.value);
    CHECK(a.point == b.point);
    CHECK(a.pose.position == b.pose.position);
    CHECK(a.pose.orientation.coeffs() == b.pose.orientation.coeffs());
    CHECK(a.material == b.material);
    CHECK(a.place == b.place);
  }
  const std::string text = readAll(temporary.file);
  writeWholeFile(temporary.file, toText(read));
  CHECK(readAll(temporary.file) == text);
}

TEST_CASE("The documented form is read", "[recording]") {
  const TemporaryFile temporary;
  temporary.put(kGood);
  const Recording recording = readRecording(temporary.file);
  CHECK(recording.scene == "liver");
  CHECK(recording.model_hash == 0x0123456789abcdefULL);
  CHECK(recording.ticks == 500);
  CHECK(recording.changes.size() == 3);
  CHECK(recording.changes[1].request.point == Vec3(0.01, 0, 0.12));
  temporary.put(with("500\n", "500\r\n"));  // as an editor on Windows leaves it
  CHECK(readRecording(temporary.file).rate_hz == 500);
}

TEST_CASE("Damaged recordings are refused with file and line", "[recording]") {
  struct Damage {
    std::string text;
    int line;
    std::string says;
  };
  const std::vector<Damage> damages = {
      {"", 1, "\"palpate-recording\" is missing"},
      {"time_s,depth_m\n", 1, "\"time_s,depth_m\" stands where \"palpate-recording\" should"},
      {with("recording 3", "recording 1"), 1, "version 1 is not known"},
      {with("scene liver\n", ""), 2, "where \"scene\" should"},
      {with("abcdef", "abcdeg"), 3, "is not a hash"},
      {with("abcdef", "abcdef0"), 3, "has not 16 hex digits"},
      {with("rate_hz 500", "rate_hz -500"), 4, "must be positive"},
      {with("rate_hz 500", "rate_hz nan"), 4, "is not a rate"},
      {with("0.1  1 0 0 0", "0.1  1 0 0"), 5, "the line ends before"},
      {with("0.1  1 0 0 0", "0.1  1 0 0 0 9"), 5, "goes on after its end"},
      {with("0.1  1 0 0 0", "0.1  1 1 0 0"), 5, "not of length 1"},
      {with("0.1  1", "0.1x 1"), 5, "\"0.1x\" is not a coordinate"},
      {with("pull 411", "pull 4.5"), 6, "is not a skin vertex"},
      {with("pull 411", "push 411"), 6, "\"push\" is not a change"},
      {with("12 pull", "twelve pull"), 6, "\"twelve\" is not a tick"},
      {with("15 release", "11 release"), 7, "ticks must not go back"},
      {with("15 release", "15 pin -1 0 0 0"), 7, "can't be negative"},
      {with("15 release", "15 pin 3 0 0"), 7, "the line ends before"},
      {with("15 release", "15 unpin -2"), 7, "below -1"},
      {with("15 release", "15 region -2 0 0 0"), 7, "below -1"},
      {with("15 release", "15 mark 4 0 0 0"), 7, "a mark is 1, 2 or 3 hard"},
      {with("15 release", "15 place 3 -2 -1 -1"), 7, "a centre's number can't be below -1"},
      {with("15 release", "15 place -1 -1 -1 -1"), 7, "the first tool's centre is missing"},
      {with("15 release", "15 place 3 -1"), 7, "ends before the number of a centre"},
      {with("15 release", "15 material 0 jelly"), 7, "\"jelly\" is not a material law"},
      {with("15 release", "15 material 0 ogden mu 7"), 7, "so many terms"},
      {with("15 release", "15 material 0 ogden mu 2 1 1 alpha 1"), 7, "so many terms"},
      {with("15 release", "15 material 0 neo-hookean young 1 2"), 7, "\"2\" stands where \"poisson\" should"},
      {with("15 release", "15 material 0 neo-hookean young"), 7, "ends before a value of young"},
      {with("end 500", "end 14"), 8, "ends before its last change"},
      {with("end 500\n", "end 500\n16 reset\n"), 9, "something stands after the end"},
      {with("end 500\n", ""), 7, "cut off"},
      {with("15 release\nend 500\n", "15 rel"), 7, "\"rel\" is not a change"},
      // A binary file: nothing of it reaches the terminal but what can be printed.
      {"\x1b[2J\x07\xff\x80" + std::string(100, 'x') + "\n", 1,
       "\"?[2J???" + std::string(33, 'x') + "...\" stands where"},
  };
  const TemporaryFile temporary;
  for (const Damage& damage : damages) {
    INFO("expected: line " << damage.line << ", " << damage.says);
    temporary.put(damage.text);
    const std::string what = refusal([&] { readRecording(temporary.file); });
    INFO("got: " << what);
    CHECK(what.find(temporary.file + ":" + std::to_string(damage.line)) == 0);
    CHECK(what.find(damage.says) != std::string::npos);
  }
  CHECK_THROWS_AS(readRecording("/nowhere/at/all"), InputError);
  CHECK_THROWS_WITH(readRecording("/dev/zero"), Catch::Contains("/dev/zero: a folder, a device or a pipe"));
  std::filesystem::resize_file(temporary.file, std::uintmax_t{5} << 30);  // nothing but a hole on the disk
  CHECK_THROWS_WITH(readRecording(temporary.file), Catch::Contains("longer than the 4294967296 bytes"));
}

TEST_CASE("A recording of a scene with any name can be read again", "[recording]") {
  const TemporaryFile temporary;
  Recording recording = everyKind();
  recording.scene = "one\ntwo\r \xff\x1b[2J \xc3\xa4";
  writeWholeFile(temporary.file, toText(recording));
  const Recording read = readRecording(temporary.file);
  CHECK(read.scene == "one?two? ??[2J \xc3\xa4");
  CHECK(read.changes.size() == recording.changes.size());
}

TEST_CASE("No cut of a recording passes for a whole one", "[recording]") {
  const TemporaryFile temporary;
  for (std::size_t length = 0; length < kGood.size(); ++length) {
    temporary.put(kGood.substr(0, length));
    REQUIRE_THROWS_AS(readRecording(temporary.file), InputError);
  }
}

TEST_CASE("What can't be asked of a model is refused in a recording, with its line", "[recording]") {
  const Model model = test::smallModel();
  const int vertices = model.skin.vertexCount();
  const auto refused = [&](const Request& request, const char* why) {
    Recording recording;
    recording.rate_hz = model.scene.dynamics.rate_hz;
    recording.model_hash = modelHash(model);
    recording.changes = {{0, Request::moveTool(Pose())}, {1, request}};
    recording.line = {5, 6};
    CHECK_THROWS_WITH(checkRecordingFits(recording, model, "file"),
                      Catch::StartsWith("file:6: ") && Catch::Contains(why));
  };
  Pose far;
  far.position.x() = 2e6;
  refused(Request::moveTool(far), "a pose with a component beyond 1e+06");
  refused(Request::pin(vertices, Vec3::Zero()), "there is no skin vertex");
  refused(Request::setForce(-1, Vec3(0, 0, 1e30)), "beyond 1e+06");
  refused(Request::moveRegion(9, Vec3::Zero()), "there is no region 9");
  refused(Request::setFriction(-1), "friction must be 0 .. 2");
  refused(Request::setFriction(0.1, 1), "there is no tool 1");
  refused(Request::setGravity(Vec3(0, 0, 1e30)), "gravity with a component beyond 1000");
  refused(Request::moveHand(1, Pose()), "there is no tool 1");
  Material material = model.materials[0];
  refused(Request::setMaterial(7, material), "there is no material 7");
  material.set("young", {{-1.0}});
  refused(Request::setMaterial(0, material), "young must be > 0");
  material = model.materials[0];
  material.density *= 2;
  refused(Request::setMaterial(0, material), "density");
}

TEST_CASE("A recording of another model or rate is refused", "[recording]") {
  const Model model = test::smallModel();
  Recording recording;
  recording.scene = "small";
  recording.rate_hz = 500;
  recording.model_hash = modelHash(model);
  checkRecordingFits(recording, model, "file");  // does not throw

  CHECK_THROWS_WITH(checkRecordingFits(recording, test::smallModel(1000), "file"),
                    Catch::StartsWith("file:4: ") && Catch::Contains("--rate 500"));
  Model moved = model;
  moved.X[2].y() = std::nextafter(moved.X[2].y(), 1.0);
  CHECK_THROWS_WITH(checkRecordingFits(recording, moved, "file"), Catch::StartsWith("file:3: "));

  Model softer = model;
  softer.materials[0] = stiffened(softer.materials[0], 0.5);
  CHECK(modelHash(softer) != modelHash(model));
  Model rougher = model;
  rougher.tools.first().friction = 0.2;
  CHECK(modelHash(rougher) != modelHash(model));
  CHECK(modelHash(test::smallModel()) == modelHash(model));
}
