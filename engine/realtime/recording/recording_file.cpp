#include "realtime/recording/recording_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <span>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "base/input_error.h"
#include "base/number_text.h"
#include "base/printable_text.h"
#include "contact/tool_set.h"
#include "mechanics/materials/material_law.h"
#include "realtime/recording/line_reader.h"

namespace palpate {
namespace {

constexpr const char* kMagic = "palpate-recording";
constexpr int kVersion = 3;                                    // what the loop makes of the same input is part of it
constexpr std::uintmax_t kMaxBytes = std::uintmax_t{4} << 30;  // ten hours of a tool that moves each millisecond

constexpr int no_most = std::numeric_limits<int>::max();

/// Changes that are no more than an index and a vector, or neither: "word index x y z".
struct PlainChange {
  Request::Kind kind;
  const char* word;
  const char* index = nullptr;  // what it counts; null: there is none
  int least = 0, most = no_most;
  const char* misfit = nullptr;  // where the index is out of these
  const char* point = nullptr;   // what a component is; null: there is none
};

constexpr PlainChange plain_changes[] = {
    {Request::Kind::ReleasePull, "release"},
    {Request::Kind::Reset, "reset"},
    {Request::Kind::Restart, "restart"},
    {Request::Kind::Undo, "undo"},
    {Request::Kind::Unmark, "unmark"},
    {Request::Kind::Submit, "submit"},
    {Request::Kind::SetGravity, "gravity", nullptr, 0, 0, nullptr, "an acceleration, m/s^2"},
    {Request::Kind::Pull, "pull", "a skin vertex", 0, no_most, "a skin vertex can't be negative", "a coordinate, m"},
    {Request::Kind::SetForce, "force", "a skin vertex", -1, no_most, "a skin vertex can't be negative", "a force, N"},
    {Request::Kind::Pin, "pin", "a skin vertex", 0, no_most, "a skin vertex can't be negative", "a coordinate, m"},
    {Request::Kind::Unpin, "unpin", "a skin vertex", -1, no_most, "a number can't be below -1, which is all"},
    {Request::Kind::MoveRegion, "region", "a region", -1, no_most, "a number can't be below -1, which is all",
     "a shift, m"},
    {Request::Kind::Mark, "mark", "how hard, 1 .. 3", 1, 3, "a mark is 1, 2 or 3 hard", "a coordinate, m"},
};

/// That `is` it, or null.
template <class Is>
const PlainChange* plainChange(Is is) {
  const auto found = std::find_if(std::begin(plain_changes), std::end(plain_changes), is);
  return found == std::end(plain_changes) ? nullptr : found;
}

void append(std::string& line, std::initializer_list<double> values) {
  for (const double value : values) line.append(" ").append(shortest(value));
}

void append(std::string& line, const Vec3& v) { append(line, {v.x(), v.y(), v.z()}); }

void append(std::string& line, const Pose& pose) {
  append(line, pose.position);
  append(line, {pose.orientation.w(), pose.orientation.x(), pose.orientation.y(), pose.orientation.z()});
}

std::string lineOf(const TimedRequest& change) {
  const Request& r = change.request;
  std::string line = std::to_string(change.tick);
  if (const PlainChange* plain = plainChange([&](const PlainChange& p) { return p.kind == r.kind; })) {
    line.append(" ").append(plain->word);
    if (plain->index != nullptr) line.append(" ").append(std::to_string(r.index));
    if (plain->point != nullptr) append(line, r.point);
    return line;
  }
  switch (r.kind) {
    case Request::Kind::MoveTool:
      line += " tool";
      append(line, r.pose);
      break;
    case Request::Kind::MoveHand:
      line += " hand " + std::to_string(r.index);
      append(line, r.pose);
      break;
    case Request::Kind::SetOpening:
      line += " opening " + std::to_string(r.index);
      append(line, {r.value});
      break;
    case Request::Kind::SetFriction:
      line += " friction";
      append(line, {r.value});
      if (r.index > 0) line.append(" ").append(std::to_string(r.index));
      break;
    case Request::Kind::SetMaterial: {
      line.append(" material ").append(std::to_string(r.index)).append(" ").append(r.material.lawDescription().name);
      forEachParameter(r.material, [&line](const Parameter& parameter, std::span<const double> values) {
        if (parameter.type == Parameter::Type::Pairs && values.empty()) return;
        line.append(" ").append(parameter.name);
        if (parameter.type == Parameter::Type::Numbers || parameter.type == Parameter::Type::Pairs)
          line.append(" ").append(std::to_string(values.size()));
        for (const double value : values) append(line, {value});
      });
      break;
    }
    case Request::Kind::GoToPlace:
      line += " place";
      for (const int centre : r.place) line += ' ' + std::to_string(centre);
      break;
    default:
      throw std::invalid_argument("a recording holds what moves the physics and what is said, nothing else");
  }
  return line;
}

Material readMaterial(LineReader& line) {
  const std::string_view name = line.word("a material law");
  const auto laws = materialLaws();
  if (std::none_of(laws.begin(), laws.end(), [name](const MaterialLaw& law) { return name == law.name; }))
    line.fail(inQuotes(name) + " is not a material law");
  Material material = Material::of(name);
  int terms = 0;  // of the lists read so far
  forEachParameter(std::as_const(material), [&](const Parameter& parameter, std::span<const double>) {
    const bool pairs = parameter.type == Parameter::Type::Pairs;
    if (pairs && line.atEnd()) return;
    line.expect(parameter.name);
    std::vector<double> values(parameter.type == Parameter::Type::Vector ? 3 : 1);
    if (pairs) {
      const int count = line.integer<int>("a number of numbers");
      if (count < 2 || count > 2 * Material::max_relaxation_terms || count % 2 == 1) line.fail("so many can't be");
      values.resize(static_cast<std::size_t>(count));
    }
    if (parameter.type == Parameter::Type::Numbers) {
      const int count = line.integer<int>("a number of terms");
      if (count < 1 || count > Material::max_terms || (terms > 0 && count != terms))
        line.fail("so many terms can't be");
      values.resize(static_cast<std::size_t>(terms = count));
    }
    for (double& value : values) value = line.number((std::string("a value of ") + parameter.name).c_str());
    material.set(parameter.name, values);
  });
  if (const auto problem = relaxationProblem(material)) line.fail(problem->problem);
  return material;
}

Pose readPose(LineReader& line) {
  Pose pose;
  pose.position = line.vector("a coordinate, m");
  const double w = line.number("a quaternion's number");
  const Vec3 v = line.vector("a quaternion's number");
  pose.orientation = Quat(w, v.x(), v.y(), v.z());
  if (std::abs(pose.orientation.norm() - 1) > 1e-6) line.fail("the tool's quaternion is not of length 1");
  return pose;
}

/// Which of a scene's tools. @param first  the lowest that it may be
int readTool(LineReader& line, int first) {
  const int tool = line.integer<int>("a tool's number");
  if (tool < first || tool >= max_tools) line.fail("there is no such tool");
  return tool;
}

Request readChange(LineReader& line) {
  const std::string_view what = line.word("what changed");
  if (const PlainChange* plain = plainChange([&](const PlainChange& p) { return what == p.word; })) {
    Request request = Request::simple(plain->kind);
    if (plain->index != nullptr) {
      request.index = line.integer<int>(plain->index);
      if (request.index < plain->least || request.index > plain->most) line.fail(plain->misfit);
    }
    if (plain->point != nullptr) request.point = line.vector(plain->point);
    return request;
  }
  if (what == "tool") return Request::moveTool(readPose(line));
  if (what == "hand") {
    const int tool = readTool(line, 1);
    return Request::moveHand(tool, readPose(line));
  }
  if (what == "opening") {
    const int tool = readTool(line, 0);
    return Request::setOpening(tool, line.number("an opening, m"));
  }
  if (what == "friction") {
    const double coefficient = line.number("a friction coefficient");
    return Request::setFriction(coefficient, line.atEnd() ? 0 : line.integer<int>("a tool's number"));
  }
  if (what == "material") {
    const int index = line.integer<int>("a material's index");
    return Request::setMaterial(index, readMaterial(line));
  }
  if (what == "place") {
    PlaceIndex place = no_place;
    for (int& centre : place) {
      centre = line.integer<int>("the number of a centre");
      if (centre < -1) line.fail("a centre's number can't be below -1");
    }
    if (place[0] < 0) line.fail("the first tool's centre is missing");
    return Request::goToPlace(place);
  }
  line.fail(inQuotes(what) + " is not a change that a recording can hold");
}

}  // namespace

std::string toText(const Recording& recording) {
  std::string text;
  text += std::string(kMagic) + " " + std::to_string(kVersion) + "\n";
  text += "scene " + printable(recording.scene) + "\n";
  text += "model " + hex16(recording.model_hash) + "\n";
  text += "rate_hz " + shortest(recording.rate_hz) + "\n";
  for (const TimedRequest& change : recording.changes) text += lineOf(change) + "\n";
  return text + "end " + std::to_string(recording.ticks) + "\n";
}

Recording readRecording(const std::string& file) {
  std::error_code error;
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error)) {
    throw InputError({file}, "a folder, a device or a pipe is no recording", "name a file that --record left");
  }
  if (std::filesystem::file_size(file, error) > kMaxBytes && !error) {
    throw InputError({file}, "longer than the " + std::to_string(kMaxBytes) + " bytes that are read",
                     "check that it is a recording");
  }
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError({file}, "the recording can't be opened", "check the path");

  Recording recording;
  std::string text;
  int number = 0;
  const auto header = [&](const char* key) {
    ++number;
    if (!std::getline(in, text))
      throw InputError({file, number}, inQuotes(key) + " is missing", "record the run again");
    LineReader line(file, number, text);
    line.expect(key);
    return line;
  };
  {
    LineReader line = header(kMagic);
    const int version = line.integer<int>("a version");
    if (version != kVersion) {
      line.fail("version " + std::to_string(version) + " is not known",
                "this program reads version " + std::to_string(kVersion));
    }
    line.done();
  }
  {
    LineReader line = header("scene");
    if (!line.atEnd()) recording.scene = line.rest("the scene's name");
  }
  {
    LineReader line = header("model");
    recording.model_hash = line.integer<std::uint64_t>("a hash of 16 hex digits", 16);
    if (line.wordLength() != 16) line.fail("the model's hash has not 16 hex digits");
    line.done();
  }
  {
    LineReader line = header("rate_hz");
    recording.rate_hz = line.number("a rate, Hz");
    if (recording.rate_hz <= 0) line.fail("the rate must be positive");
    line.done();
  }

  std::int64_t last = 0;
  while (std::getline(in, text)) {
    ++number;
    LineReader line(file, number, text);
    if (line.atEnd()) continue;
    if (text.starts_with("end")) {
      line.expect("end");
      recording.ticks = line.integer<std::int64_t>("a number of ticks");
      if (in.eof()) line.fail("the recording is cut off within this line: no line end follows");
      if (recording.ticks < last) line.fail("the run ends before its last change");
      line.done();
      while (std::getline(in, text)) {
        LineReader after(file, ++number, text);
        if (!after.atEnd()) after.fail("something stands after the end");
      }
      return recording;
    }
    TimedRequest change;
    change.tick = line.integer<std::int64_t>("a tick");
    if (change.tick < last) line.fail("ticks must not go back");
    last = change.tick;
    change.request = readChange(line);
    line.done();
    recording.changes.push_back(change);
    recording.line.push_back(number);
  }
  throw InputError({file, number}, "the recording is cut off after this line: 'end' is missing",
                   "record the run again");
}

}  // namespace palpate
