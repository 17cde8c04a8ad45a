#include <algorithm>
#include <cmath>

#include "base/printable_text.h"
#include "fuzz/memory_file.h"
#include "fuzz/reader.h"
#include "io/scene_file.h"
#include "io/scene_texts.h"
#include "io/tool_script.h"
#include "support/text.h"

namespace palpate::fuzz {

namespace {

constexpr const char* pressed = R"(name = "press"
from_touch = false
interpolation = "linear"
[[keyframe]]
time = 0
advance = -0.002
[[keyframe]]
time = 2.5
advance = 4e-3
slide = [0.01, 0.02]
[[keyframe]]
time = 4
advance_radii = 0.5
slide_radii = [0, -1]
)";

/// With what TOML allows in other forms, and without a file beside it.
std::vector<std::string> sceneSeeds() {
  std::string solved = solved_scene;
  for (const auto& [what, with] : {std::pair<const char*, const char*>{"probes = \"points/probes.csv\"\n", ""},
                                   {"solid = \"cylinder\"\nradius = 0.015\nheight = 0.017",
                                    "solid = \"ellipsoid\"\nsemi_axes = [0.03, 0.03, 0.02]\nupper_half = true"},
                                   {"young = 1000", "young = 1_000.0"},
                                   {"young = 5000", "young = 5e3"},
                                   {"\"neo-hookean\"", "'neo-hookean'"},
                                   {"\"ear\"", "\"\"\"ear\"\"\"  # turned"}})
    solved = replaced(solved, what, with);
  return {full_scene, minimal_scene, solved};
}
std::vector<std::string> scriptSeeds() { return {pressed, "keyframe = [{ time = 1, advance = 0.01 }]\n"}; }

bool isUnit(const Vec3& v) { return std::abs(v.norm() - 1) < 1e-12; }

void holdRegion(const Region& region) {
  hold(isUnit(region.normal), "a region's normal is no unit vector");
  hold(std::isfinite(region.point.stableNorm()), "a region's place is not finite");
  hold((region.min.array() <= region.max.array()).all(), "a box is turned inside out");
}

void readSceneFrom(const std::string& bytes) {
  static const MemoryFile file;
  const Scene scene = readScene(file.write(bytes));
  hold(scene.name == printable(scene.name), "the scene's name can't be printed");
  hold(scene.discretization.spacing > 0 && std::isfinite(scene.discretization.spacing), "the spacing is not positive");
  hold(!scene.materials.empty(), "no material");
  for (const MaterialSpec& material : scene.materials) holdRegion(material.region);
  hold(isUnit(scene.tools[0].direction), "the tool's direction is no unit vector");
  for (std::size_t b = 0; b < scene.boundaries.size(); ++b) {
    const BoundarySpec& boundary = scene.boundaries[b];
    holdRegion(boundary.region);
    hold(isUnit(boundary.axis), "a boundary's axis is no unit vector");
    hold(std::isfinite(boundary.translation.stableNorm()), "a boundary's way is not finite");
    hold(std::isfinite(boundary.angle), "a boundary's angle is not finite");
    hold(boundary.curve.time.size() == boundary.curve.fraction.size(),
         "a curve's times and fractions differ in number");
    hold(std::isfinite(boundary.curve.at(0.3, boundary.duration)), "a curve is not finite");
    hold(boundary.name == printable(boundary.name) && !boundary.name.empty() && boundary.name.front() != ' ',
         "a boundary's name can't be a column's");
    hold(std::none_of(scene.boundaries.begin(), scene.boundaries.begin() + static_cast<std::ptrdiff_t>(b),
                      [&](const BoundarySpec& other) { return other.name == boundary.name; }),
         "two boundaries have one name");
  }
}

void readScriptFrom(const std::string& bytes) {
  static const MemoryFile file;
  const ToolScript script = readToolScript(file.write(bytes), 0.005);
  hold(script.name == printable(script.name), "the script's name can't be printed");
  hold(!script.keyframes.empty(), "no keyframe");
  double before = -1;
  for (const ToolScript::Keyframe& key : script.keyframes) {
    hold(key.time > before && std::isfinite(key.time), "times do not ascend");
    hold(std::isfinite(key.advance) && key.slide.allFinite(), "a keyframe is not finite");
    before = key.time;
  }
  poseAt(script, {}, 0.01, 0.5 * script.duration());
}

}  // namespace

const Reader scene_reader = {"scene", sceneSeeds, readSceneFrom};
const Reader tool_script_reader = {"tool_script", scriptSeeds, readScriptFrom};

}  // namespace palpate::fuzz
