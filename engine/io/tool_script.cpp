#include "io/tool_script.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <utility>

#include "base/printable_text.h"
#include "io/text_file.h"
#include "io/toml_table.h"

namespace palpate {

namespace {

using T = KeySpec::Type;

// clang-format off
constexpr ValueRange keyframe_travel = between(-10, 10);         // m; organs are far smaller
constexpr ValueRange keyframe_travel_radii = between(-1e4, 1e4);

constexpr KeySpec script_keys[] = {
    {"", "name", T::Text, "", "", {}, "", "For reports; the file's name where absent."},
    {"", "from_touch", T::Boolean, "", "true", {}, "",
     "Advance counts from where the tool first touches the resting skin; otherwise from the scene's start "
     "pose."},
    {"", "interpolation", T::Text, "", "\"smooth\"", {}, "linear|smooth",
     "Between keyframes: straight, or 10 t^3 - 15 t^4 + 6 t^5, which starts and stops gently."},
    {"", "keyframe", T::Tables, "", KeySpec::required, {}, "",
     "Where the tool is when. A first one later than 0 is reached from the scene's start pose."},
    {"keyframe", "time", T::Number, "s", KeySpec::required, between(0, 1e6), "", "Later than the keyframe before."},
    {"keyframe", "advance", T::Number, "m", KeySpec::depends, keyframe_travel, "",
     "How far along the way the tip points; negative: back. This or `advance_radii`."},
    {"keyframe", "advance_radii", T::Number, "tool radii", KeySpec::depends, keyframe_travel_radii, "",
     "The same in radii of the scene's tool, so that one script suits many scenes."},
    {"keyframe", "slide", T::Plane, "m", "[0.0, 0.0]", keyframe_travel, "",
     "How far sideways, along the tool's x and y axes."},
    {"keyframe", "opening", T::Number, "m", KeySpec::depends, between(0, 1), "",
     "Jaws: the gap between their fingers. Absent: as in the keyframe before, or as the scene has it."},
    {"keyframe", "slide_radii", T::Plane, "tool radii", "[0.0, 0.0]", keyframe_travel_radii, "",
     "The same in radii of the scene's tool."},
};
// clang-format on

/// The keyframe as travel from the start pose.
ToolScript::Keyframe fromStart(const ToolScript& script, ToolScript::Keyframe key, double first_contact_travel) {
  if (script.from_touch) key.advance += first_contact_travel;
  return key;
}

}  // namespace

std::string toolScriptReference() {
  return "### Top level\n\n" + keyReference(script_keys, "") + "\n### `[[keyframe]]`\n\n" +
         keyReference(script_keys, "keyframe");
}

ToolScript readToolScript(const std::string& path, double tool_radius) {
  const toml::table document = parseToml(readWholeFile(path, {}, max_toml_bytes), path);
  TomlFile file{path, script_keys, {}};
  const TomlTable top(file, document, "", {""});
  ToolScript script;
  script.name = printable(std::filesystem::path(path).stem().string());
  top.readName("name", script.name);
  top.read("from_touch", script.from_touch);
  script.smooth = top.readChoice("interpolation", 1) == 1;
  for (const TomlTable& entry : top.tables("keyframe", {"keyframe"})) {
    ToolScript::Keyframe key;
    entry.read("time", key.time);
    if (entry.has("advance") == entry.has("advance_radii")) {
      throw InputError(
          entry.place("advance"),
          entry.has("advance") ? "both \"advance\" and \"advance_radii\"" : "neither \"advance\" nor \"advance_radii\"",
          "give one of them");
    }
    if (entry.has("slide") && entry.has("slide_radii")) {
      throw InputError(entry.place("slide"), "both \"slide\" and \"slide_radii\"", "give one of them");
    }
    if (!script.keyframes.empty()) key.opening = script.keyframes.back().opening;
    entry.read("opening", key.opening);
    entry.read("advance", key.advance);
    entry.read("slide", key.slide);
    if (entry.has("advance_radii")) {
      entry.read("advance_radii", key.advance);
      key.advance *= tool_radius;
    }
    if (entry.has("slide_radii")) {
      entry.read("slide_radii", key.slide);
      key.slide *= tool_radius;
    }
    if (!script.keyframes.empty() && key.time <= script.keyframes.back().time) {
      throw InputError(entry.place("time"), "this keyframe is not later than the one before it",
                       "keyframes stand in the order of their times");
    }
    script.keyframes.push_back(key);
    script.end_place = entry.place("time");
  }
  return script;
}

namespace {

/// Share of the way from the keyframe before `after` to it that is behind at this time.
double shareOfWay(const ToolScript& script, double from, double to, double time) {
  // A first keyframe at time 0 has no way that leads to it: the tool is there.
  const double t = to > from ? std::clamp((time - from) / (to - from), 0.0, 1.0) : 1.0;
  return script.smooth ? t * t * t * (10 + t * (6 * t - 15)) : t;
}

/// The first keyframe later than a time.
std::vector<ToolScript::Keyframe>::const_iterator keyframeAfter(const ToolScript& script, double time) {
  return std::upper_bound(script.keyframes.begin(), script.keyframes.end(), time,
                          [](double t, const ToolScript::Keyframe& key) { return t < key.time; });
}

}  // namespace

double openingAt(const ToolScript& script, double start, double time) {
  const auto openingOf = [&](const ToolScript::Keyframe& key) { return key.opening < 0 ? start : key.opening; };
  const auto after = keyframeAfter(script, time);
  if (after == script.keyframes.end()) return openingOf(script.keyframes.back());
  const bool first = after == script.keyframes.begin();
  const double from = first ? start : openingOf(*std::prev(after));
  return from + shareOfWay(script, first ? 0 : std::prev(after)->time, after->time, time) * (openingOf(*after) - from);
}

Pose poseAt(const ToolScript& script, const Pose& start, double first_contact_travel, double time) {
  const auto& all = script.keyframes;
  const auto after = keyframeAfter(script, time);
  ToolScript::Keyframe at;
  if (after == all.end()) {
    at = fromStart(script, all.back(), first_contact_travel);
  } else {
    const ToolScript::Keyframe to = fromStart(script, *after, first_contact_travel);
    const ToolScript::Keyframe from =
        after == all.begin() ? ToolScript::Keyframe{} : fromStart(script, *std::prev(after), first_contact_travel);
    const double s = shareOfWay(script, from.time, to.time, time);
    at.advance = from.advance + s * (to.advance - from.advance);
    at.slide = from.slide + s * (to.slide - from.slide);
  }
  Pose pose = start;
  pose.position += start.orientation * Vec3(at.slide.x(), at.slide.y(), -at.advance);
  return pose;
}

}  // namespace palpate
