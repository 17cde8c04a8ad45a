#include <algorithm>
#include <cmath>

#include "base/printable_text.h"
#include "fuzz/memory_file.h"
#include "fuzz/reader.h"
#include "io/scene_file.h"
#include "io/scene_texts.h"
#include "io/tool_script.h"

namespace palpate::fuzz {

namespace {

constexpr const char* solved_scene = R"([organ]
solid = "ellipsoid"
semi_axes = [0.03, 0.03, 0.02]
upper_half = true
[discretization]
spacing = 0.004
points_per_cell = 5
quadrature_accuracy = 0.01
quadrature_division = 2
quadrature_depth = 6
boundary_method = "ebciem"
[[material]]
model = "neo-hookean"
young = 1_000.0
poisson = 0.45
[[material]]
model = 'neo-hookean'
young = 5e3
poisson = 0.45
region = { shape = "shell", distance = 0.002 }
[[fixed]]
name = "base"
shape = "near-plane"
point = [0, 0, 0]
normal = [0, 0, 1]
distance = 1e-5
[[prescribed]]
shape = "cylinder"
point = [0, 0, 0.016]
normal = [0, 0, 2]
radius = 0.005
height = 0.002
translation = [0, 0, -0.002]
axis_point = [0.001, 0, 0]
axis = [0, 0, -4]
angle = 90
duration = 0.5
curve = "linear"
[[prescribed]]
name = """ear"""  # turned
shape = "sphere"
centre = [0, 0, 0.01]
radius = 0.001
axis_point = [0, 0, 0]
axis = [1, 0, 0]
angle = -30
components = ["y", "z"]
curve_table = [[0, 0], [0.1, 1.0],
               [0.4, -0.5]]
[solve]
mode = "transient"
end_time = 0.75
frames = 25
)";

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

std::vector<std::string> sceneSeeds() { return {full_scene, minimal_scene, solved_scene}; }
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
