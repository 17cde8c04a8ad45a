#include <catch2/catch.hpp>
#include <sstream>

#include "base/number_text.h"
#include "contact/tools/tool_list.h"
#include "io/scene_file.h"
#include "io/scene_keys.h"
#include "io/scene_texts.h"
#include "mechanics/materials/material_law.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;

namespace {

/// Every member of a scene that a key with a default sets.
std::string described(const Scene& s) {
  std::ostringstream text;
  text.precision(17);
  const auto add = [&](const auto&... values) { ((text << values << ' '), ...); };
  const auto vector = [&](const Vec3& v) { add(v.x() + 0.0, v.y() + 0.0, v.z() + 0.0); };  // no -0
  add(s.organs[0].upper_half, s.organs[0].repair_surface, s.organs[0].friction), vector(s.organs[0].colour),
      vector(s.organs[0].position);
  add(s.discretization.follow, s.discretization.spacing, s.discretization.at_tools, s.discretization.seed,
      s.discretization.basis_degree, s.discretization.support_factor, s.discretization.mmls_weight,
      s.discretization.formulation == Formulation{});
  add(static_cast<int>(s.discretization.boundary_method), s.discretization.quadrature.points_per_cell,
      s.discretization.quadrature.cells_per_point);
  add(s.discretization.quadrature.accuracy, s.discretization.quadrature.division,
      s.discretization.quadrature.max_depth);
  for (const RefineSpec& r : s.discretization.refine) add(r.spacing, r.blend);
  for (const MaterialSpec& m : s.materials) vector(m.region.point), add(m.region.radius);
  for (const MaterialSpec& m : s.materials)
    for (const auto& common : commonMaterialParameters()) add(m.material.*common.member);
  for (const BoundarySpec& b : s.boundaries)
    add(b.component[0], b.component[1], b.component[2], b.surface_only, static_cast<int>(b.curve.kind));
  for (const LoadSpec& l : s.loads) add(static_cast<int>(l.kind), static_cast<int>(l.curve.kind));
  vector(s.dynamics.gravity);
  for (const RigidSpec& b : s.rigid) add(b.clearance, b.friction, b.encloses, static_cast<int>(b.motion.curve.kind));
  for (const BoundarySpec& b : s.boundaries)
    if (b.points) add(b.points->sheet);
  add(s.dynamics.rate_hz, s.dynamics.catch_up, s.dynamics.time_step, s.dynamics.step_safety, s.dynamics.mass_scaling,
      s.dynamics.damping, s.dynamics.threads);
  add(static_cast<int>(s.dynamics.gradient_precision), static_cast<int>(s.solve.mode), s.solve.tolerance,
      s.solve.load_steps);
  add(s.solve.end_time, s.solve.frames);
  add(static_cast<int>(s.tools[0].shape.kind), s.tools[0].shape.radius, s.tools[0].shape.length);
  for (const double parameter : s.tools[0].shape.parameter) add(parameter);
  vector(s.tools[0].position), vector(s.tools[0].direction);
  add(s.tools[0].max_speed, s.tools[0].max_force, s.tools[0].grip_force, s.tools[0].friction, s.force.cutoff_hz,
      s.force.rate_limit);
  add(s.device.stiffness, s.device.damping, s.device.max_force, s.device.rise_time, s.device.scale);
  add(s.device.own_damping, s.device.lever, s.device.locked);
  vector(s.camera.target);
  add(s.camera.distance, s.camera.azimuth_deg, s.camera.elevation_deg, s.camera.fov_deg);
  return text.str();
}

/// A scene with `given` in the table that the key stands in.
std::string sceneWith(const KeySpec& key, const std::string& given) {
  const std::string group = key.table, name = key.name;
  // How a cell is divided means nothing where none is.
  const std::string line = (name.starts_with("quadrature_d") ? "quadrature_accuracy = 0.1\n"
                            : name == "grip_force"           ? "opening = 0.02\n"
                                                             : "") +
                           given;
  if (group == "organ" && name == "repair") {
    return replaced(minimal_scene, "solid = \"box\"\nsize = [0.1, 0.1, 0.05]\n",
                    "surface = \"a.obj\"\nunit = \"mm\"\n" + line);
  }
  if (group == "organ") {
    return replaced(minimal_scene, "solid = \"box\"\nsize = [0.1, 0.1, 0.05]\n",
                    "solid = \"ellipsoid\"\nsemi_axes = [0.1, 0.1, 0.05]\n" + line);
  }
  const auto after = [&](const std::string& table) {
    return replaced(minimal_scene, table + "\n", table + "\n" + line);
  };
  if (name == "follow") {  // in place of a spacing, and with a tool
    const std::string spacing = given == "follow = true\n" ? "" : "spacing = 0.01\n";
    return replaced(minimal_scene, "spacing = 0.01\n", spacing + given) +
           "[tool]\nshape = \"sphere\"\nradius = 0.01\nposition = [0, 0, 0.1]\n";
  }
  if (group == "discretization" || group == "material")
    return after(group == "material" ? "[[material]]" : "[discretization]");
  if (group == "boundary") return after("[[fixed]]");
  if (group == "discretization.refine") {
    return minimal_scene + "[[discretization.refine]]\ncentre = [0, 0, 0]\nradius = 0.01\nspacing = 0.005\n" + line;
  }
  if (group == "skull") return minimal_scene + "[skull]\nfrom = \"organ\"\n" + line;
  if (group == "rigid") {
    const std::string body = "[[rigid]]\nsurface = \"t.obj\"\nunit = \"mm\"\n";
    return minimal_scene + body + (name == "curve" ? "translation = [0, 0, 1]\nduration = 1\n" : "") + line;
  }
  if (name == "spread") {
    return minimal_scene + "[[prescribed]]\npoints = \"e.csv\"\nunit = \"mm\"\nframe = \"ras\"\nduration = 1\n" + line;
  }
  if (group == "prescribed") {
    return minimal_scene +
           "[[prescribed]]\nshape = \"sphere\"\ncentre = [0, 0, 1]\nradius = 1\ntranslation = [0, 0, 1]\nduration = "
           "1\n" +
           line;
  }
  if (group == "load") return minimal_scene + "[[load]]\npressure = 100\nduration = 1\n" + line;
  if (group == "lumps") return minimal_scene + "[lumps]\ncount = 1\n" + line;
  if (group == "tool" || group.starts_with("tool (")) {
    const std::string shape = group == "tool" ? "sphere" : group.substr(6, group.size() - 7);
    return minimal_scene + "[tool]\nshape = \"" + shape + "\"\nradius = 0.01\nposition = [0, 0, 0.1]\n" + line;
  }
  if (group == "dynamics" || group == "solve" || group == "force" || group == "device" || group == "camera")
    return minimal_scene + "[" + group + "]\n" + line;
  FAIL("sceneWith() has no place for the keys of " << group);
  return "";
}

/// Another value that the key may have.
std::string otherValue(const KeySpec& key) {
  const std::string fallback = key.fallback;
  using T = KeySpec::Type;
  if (key.type == T::Boolean) return fallback == "true" ? "false" : "true";
  if (key.type == T::Axes) return "[\"x\"]";
  if (key.type == T::Vector) return "[0.25, 0.5, 0.75]";
  if (*key.choices != '\0') {
    const std::string choices = key.choices, quote = key.type == T::Text ? "\"" : "";
    const std::string first = quote + choices.substr(0, choices.find('|')) + quote;
    const std::string last = quote + choices.substr(choices.rfind('|') + 1) + quote;
    return first == fallback ? last : first;
  }
  const double value = std::stod(fallback), step = key.type == T::Integer ? 1 : 0.001;
  return shortest(key.range.contains(value + step) ? value + step : value - step);
}

}  // namespace

TEST_CASE("Each default of the reference is what a scene without the key has", "[io][scene]") {
  TempFolder folder;
  folder.write("a.obj", "v 0 0 0\n");
  folder.write("e.csv", "x,y,z\n0,0,50\n");
  folder.write("t.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  const auto read = [&](const std::string& text) { return described(readScene(folder.write("box.toml", text))); };
  int defaults = 0;
  for (const KeySpec& key : sceneKeys()) {
    const std::string fallback = key.fallback;
    if (fallback.empty() || fallback == KeySpec::required || fallback == KeySpec::depends) continue;  // none
    ++defaults;
    INFO(key.table << "." << key.name << " = " << fallback << ", otherwise " << otherValue(key));
    const std::string line = std::string(key.name) + " = ", without = read(sceneWith(key, ""));
    CHECK(read(sceneWith(key, line + fallback + "\n")) == without);
    CHECK(read(sceneWith(key, line + otherValue(key) + "\n")) != without);  // so described() has this key
  }
  CHECK(defaults > 40);
}

TEST_CASE("A scene without a tool has the tool that the reference names", "[io][scene]") {
  TempFolder folder;
  const Scene s = readScene(folder.write("box.toml", minimal_scene));
  CHECK(s.name == "box");
  CHECK(s.places.count("dynamics.rate") == 0);
  CHECK(s.solve.probes_file.empty());
  CHECK(sceneReference().find("a ball of radius 10 mm starts at (0, 0, 0.1) m and points down") != std::string::npos);
  CHECK(s.tools[0].shape.kind == ToolKind::Sphere);
  CHECK(s.tools[0].shape.radius == 0.01);
  CHECK(s.tools[0].position == Vec3(0, 0, 0.1));
  CHECK(s.tools[0].direction == Vec3(0, 0, -1));
}
