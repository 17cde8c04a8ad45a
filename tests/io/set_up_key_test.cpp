// The key of kept preparations against every key of the scene reference.

#include <catch2/catch.hpp>
#include <map>
#include <string>

#include "imaging/nifti.h"
#include "io/material_texts.h"
#include "io/scene_file.h"
#include "io/scene_keys.h"
#include "model/preparation.h"
#include "support/law_values.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;

namespace {

// Scenes with what `full_scene` lacks; each has mass scaling, or not, as the test asks.
const std::string motion =
    "[[prescribed]]\nshape = \"sphere\"\ncentre = [0, 0, 1]\nradius = 1\ntranslation = [0, 0, 1]\n"
    "axis_point = [0, 0, 0]\naxis = [0, 0, 1]\nangle = 10\nduration = 1\n";
const std::string moved = minimal_scene + motion;
const std::string surface =
    replaced(minimal_scene, "solid = \"box\"\nsize = [0.1, 0.1, 0.05]", "surface = \"a.obj\"\nunit = \"mm\"");
const std::string scaled_surface = replaced(surface, "unit = \"mm\"", "scale = 0.001");
const std::string ellipsoid = replaced(minimal_scene, "solid = \"box\"\nsize = [0.1, 0.1, 0.05]",
                                       "solid = \"ellipsoid\"\nsemi_axes = [0.1, 0.1, 0.05]");
const std::string adaptive = replaced(minimal_scene, "spacing = 0.01\n", "spacing = 0.01\nquadrature_accuracy = 0.1\n");
const std::string rod =
    replaced(minimal_scene, "shape = \"half-space\"", "shape = \"cylinder\"\nradius = 0.01\nheight = 0.02");
const std::string solved = minimal_scene + "[solve]\n";
const std::string mixed =
    minimal_scene +
    "[[material]]\nmodel = \"neo-hookean\"\nyoung = 100\npoisson = 0.49\nmembership = \"m.nii\"\nmask = \"k.nii\"\n";
const std::string measured =
    minimal_scene + "[[prescribed]]\npoints = \"e.csv\"\nunit = \"mm\"\nframe = \"ras\"\nduration = 1\n";
const std::string loaded = minimal_scene + "[[load]]\npressure = 100\nduration = 1\n";
const std::string enclosed =
    minimal_scene +
    "[skull]\nfrom = \"organ\"\nopen = [{ shape = \"sphere\", centre = [0, 0, 0.05], radius = 0.02 }]\n";
const std::string enclosed_by_file = minimal_scene + "[skull]\nfrom = \"t.obj\"\nunit = \"mm\"\n";
const std::string on_floor =
    minimal_scene +
    "[[rigid]]\nregion = { shape = \"half-space\", point = [0, 0, -1], normal = [0, 0, 1] }\n"
    "translation = [0, 0, 1]\naxis_point = [0, 0, 0]\naxis = [1, 0, 0]\nangle = 10\nduration = 1\n";
const std::string beside = minimal_scene + "[[rigid]]\nsurface = \"t.obj\"\nunit = \"mm\"\n";
const std::string cone =
    replaced(full_scene, "shape = \"cylinder\"\nradius = 0.005\nlength = 0.03\nedge_radius = 0.0005",
             "shape = \"cone\"\nradius = 0.005\nhalf_angle = 40\ntip_radius = 0.002");

const std::string lumped = minimal_scene +
                           "[[lump]]\ncentre = [0, 0, 0.03]\nradius = 0.008\nyoung = 40000\n"
                           "[lumps]\ncount = 2\nlevel = 1\nseed = 3\n";

const std::string of_organs =
    "[discretization]\nspacing = 0.01\n"
    "[[organ]]\nname = \"a\"\nsolid = \"box\"\nsize = [0.1, 0.1, 0.05]\n"
    "[[organ]]\nname = \"b\"\nsolid = \"box\"\nsize = [0.1, 0.1, 0.05]\nposition = [0, 0, 0.06]\n"
    "[[material]]\nmodel = \"neo-hookean\"\nyoung = 3000\npoisson = 0.45\ndensity = 1000\n"
    "[[material]]\norgan = \"a\"\nmodel = \"neo-hookean\"\nyoung = 3000\npoisson = 0.45\ndensity = 1000\n"
    "[[fixed]]\norgan = \"a\"\nshape = \"half-space\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n";

/// A scene, and what to write in it instead of something else, so that one key changes.
struct Change {
  std::string scene, from, to;
};

/// For every key of the reference: "table.key".
std::map<std::string, Change> changes() {
  const auto added = [](const std::string& scene, const std::string& after, const std::string& line) {
    return Change{scene, after, after + line + "\n"};
  };
  const std::string grid = "[discretization]\n";
  std::map<std::string, Change> all = {
      {".name", {full_scene, "\"Everything\"", "\"Something\""}},
      {"organ.name", added(minimal_scene, "[organ]\n", "name = \"liver\"")},
      {"organ.position", added(minimal_scene, "[organ]\n", "position = [0, 0, 0.001]")},
      {"organ.axis", added(minimal_scene, "[organ]\n", "axis = [0, 0, 1]\nangle = 10")},
      {"organ.angle", added(minimal_scene, "[organ]\n", "axis = [1, 0, 0]\nangle = 20")},
      {"organ.friction", added(minimal_scene, "[organ]\n", "friction = 0.3")},
      {"material.organ", {of_organs, "organ = \"a\"\nmodel", "organ = \"b\"\nmodel"}},
      {"boundary.organ", {of_organs, "organ = \"a\"\nshape", "organ = \"b\"\nshape"}},
      {"organ.surface", {surface, "\"a.obj\"", "\"./b.obj\""}},
      {"organ.unit", {surface, "\"mm\"", "\"cm\""}},
      {"organ.scale", {scaled_surface, "scale = 0.001", "scale = 0.002"}},
      {"organ.repair", {surface, "unit = \"mm\"", "unit = \"mm\"\nrepair = true"}},
      {"organ.solid",
       {minimal_scene, "\"box\"\nsize = [0.1, 0.1, 0.05]", "\"ellipsoid\"\nsemi_axes = [0.1, 0.1, 0.1]"}},
      {"organ.size", {minimal_scene, "[0.1, 0.1, 0.05]", "[0.1, 0.1, 0.06]"}},
      {"organ.radius", {full_scene, "radius = 0.015", "radius = 0.016"}},
      {"organ.height", {full_scene, "height = 0.017", "height = 0.018"}},
      {"organ.semi_axes", {ellipsoid, "[0.1, 0.1, 0.05]", "[0.1, 0.1, 0.06]"}},
      {"organ.upper_half", {ellipsoid, "[0.1, 0.1, 0.05]", "[0.1, 0.1, 0.05]\nupper_half = true"}},
      {"organ.colour", {full_scene, "[0.1, 0.2, 0.3]", "[0.1, 0.2, 0.4]"}},
      {"discretization.follow", {full_scene, "spacing = 0.004", "follow = true"}},
      {"discretization.spacing", {full_scene, "spacing = 0.004", "spacing = 0.0041"}},
      {"discretization.seed", {full_scene, "seed = 9", "seed = 10"}},
      {"discretization.points_per_cell", {full_scene, "points_per_cell = 1", "points_per_cell = 4"}},
      {"discretization.cells_per_point", added(minimal_scene, grid, "cells_per_point = 1.3")},
      {"discretization.quadrature_accuracy", {adaptive, "accuracy = 0.1", "accuracy = 0.2"}},
      {"discretization.quadrature_division", added(adaptive, grid, "quadrature_division = 4")},
      {"discretization.quadrature_depth", added(adaptive, grid, "quadrature_depth = 2")},
      {"discretization.basis", {full_scene, "\"linear\"", "\"quadratic\""}},
      {"discretization.support_factor", {full_scene, "support_factor = 2", "support_factor = 2.1"}},
      {"discretization.mu", {full_scene, "mu = 0.05", "mu = 0.06"}},
      {"discretization.scheme", added(minimal_scene, grid, "scheme = \"paper\"")},
      {"discretization.boundary_method", added(minimal_scene, grid, "boundary_method = \"ebciem\"")},
      {"discretization.refine.centre", {full_scene, "centre = [0, 0, 0.017]", "centre = [0, 0, 0.016]"}},
      {"discretization.refine.radius", {full_scene, "radius = 0.003", "radius = 0.004"}},
      {"discretization.refine.spacing", {full_scene, "spacing = 0.001", "spacing = 0.0011"}},
      {"discretization.refine.blend", {full_scene, "blend = 0.004", "blend = 0.005"}},
      {"material.model",
       {minimal_scene, "\"neo-hookean\"\nyoung = 3000\npoisson = 0.49",
        "\"ogden\"\nmu = [1000]\nalpha = [2]\nD1 = 1e-4"}},
      {"material.name", added(minimal_scene, "[[material]]\n", "name = \"capsule\"")},
      {"material.membership", {mixed, "\"m.nii\"", "\"./m.nii\""}},
      {"material.mask", {mixed, "\"k.nii\"", "\"./k.nii\""}},
      {"region.shape", {rod, "\"cylinder\"\nradius = 0.01\nheight = 0.02", "\"half-space\""}},
      {"region.point", {full_scene, "point = [0, 0, 0]", "point = [0, 0, 1e-5]"}},
      {"region.normal", {full_scene, "normal = [0, 0, 2]", "normal = [0, 1, 2]"}},
      {"region.min", {full_scene, "min = [-0.01,", "min = [-0.011,"}},
      {"region.max", {full_scene, "max = [0.01,", "max = [0.011,"}},
      {"region.centre", {full_scene, "centre = [0, 0, 0.01]", "centre = [0, 0, 0.011]"}},
      {"region.radius", {rod, "radius = 0.01", "radius = 0.011"}},
      {"region.height", {rod, "height = 0.02", "height = 0.021"}},
      {"region.distance", {full_scene, "distance = 1e-5", "distance = 2e-5"}},
      {"boundary.name", added(minimal_scene, "[[fixed]]\n", "name = \"base\"")},
      {"boundary.components", {full_scene, "[\"z\"]", "[\"x\"]"}},
      {"boundary.surface_only", {full_scene, "surface_only = true", "surface_only = false"}},
      {"prescribed.points", {measured, "\"e.csv\"", "\"./e.csv\""}},
      {"prescribed.unit", {measured, "\"mm\"", "\"cm\""}},
      {"prescribed.frame", {measured, "\"ras\"", "\"lps\""}},
      {"prescribed.spread", {measured, "frame = \"ras\"", "frame = \"ras\"\nspread = \"sheet\""}},
      {"prescribed.translation", {full_scene, "[0, 0, -0.002]", "[0, 0, -0.003]"}},
      {"prescribed.axis_point", {moved, "axis_point = [0, 0, 0]", "axis_point = [0, 0, 1]"}},
      {"prescribed.axis", {moved, "axis = [0, 0, 1]", "axis = [0, 1, 1]"}},
      {"prescribed.angle", {moved, "angle = 10", "angle = 11"}},
      {"prescribed.duration", {moved, "duration = 1", "duration = 2"}},
      {"prescribed.curve", {moved, "duration = 1", "duration = 1\ncurve = \"linear\""}},
      {"prescribed.curve_table", {moved, "duration = 1", "duration = 1\ncurve_table = [[0, 0], [1, 1]]"}},
      {"rigid.name", added(on_floor, "[[rigid]]\n", "name = \"floor\"")},
      {"rigid.surface", {beside, "\"t.obj\"", "\"./t.obj\""}},
      {"rigid.unit", {beside, "\"mm\"", "\"cm\""}},
      {"rigid.side", added(beside, "[[rigid]]\n", "side = \"inside\"")},
      {"rigid.clearance", added(beside, "[[rigid]]\n", "clearance = 0.001")},
      {"rigid.friction", added(on_floor, "[[rigid]]\n", "friction = 0.5")},
      {"rigid.translation", {on_floor, "translation = [0, 0, 1]", "translation = [0, 0, 2]"}},
      {"rigid.axis_point", {on_floor, "axis_point = [0, 0, 0]", "axis_point = [0, 0, 1]"}},
      {"rigid.axis", {on_floor, "axis = [1, 0, 0]", "axis = [0, 1, 0]"}},
      {"rigid.angle", {on_floor, "angle = 10", "angle = 20"}},
      {"rigid.duration", {on_floor, "duration = 1", "duration = 2"}},
      {"rigid.curve", {on_floor, "duration = 1", "duration = 1\ncurve = \"linear\""}},
      {"rigid.curve_table", {on_floor, "duration = 1", "duration = 1\ncurve_table = [[0, 0], [1, 1]]"}},
      {"load.name", added(loaded, "[[load]]\n", "name = \"gas\"")},
      {"load.pressure", {loaded, "pressure = 100", "pressure = 101"}},
      {"load.kind", {loaded, "pressure = 100", "pressure = 100\nkind = \"dead\""}},
      {"load.traction", {loaded, "pressure = 100", "traction = [0, 0, 1]"}},
      {"load.duration", {loaded, "duration = 1", "duration = 2"}},
      {"load.curve", {loaded, "duration = 1", "duration = 1\ncurve = \"linear\""}},
      {"load.curve_table", {loaded, "duration = 1", "duration = 1\ncurve_table = [[0, 0], [1, 1]]"}},
      {"skull.from", {enclosed_by_file, "\"t.obj\"", "\"./t.obj\""}},
      {"skull.unit", {enclosed_by_file, "\"mm\"", "\"cm\""}},
      {"skull.clearance", added(enclosed, "[skull]\n", "clearance = 0.001")},
      {"dynamics.rate", {full_scene, "rate = 1000", "rate = 500"}},
      {"dynamics.catch_up", added(full_scene, "[dynamics]\n", "catch_up = 0")},
      {"dynamics.time_step", {full_scene, "time_step = 0.0005", "time_step = 0.00025"}},
      {"dynamics.step_safety", {full_scene, "step_safety = 0.5", "step_safety = 0.6"}},
      {"dynamics.damping", {full_scene, "damping = 10", "damping = 11"}},
      {"dynamics.gravity", added(full_scene, "[dynamics]\n", "gravity = [0, 0, -9.81]")},
      {"dynamics.threads", {full_scene, "threads = 2", "threads = 3"}},
      {"dynamics.gradient_precision", added(full_scene, "[dynamics]\n", "gradient_precision = \"int16\"")},
      {"solve.mode", added(solved, "[solve]\n", "mode = \"transient\"")},
      {"solve.tolerance", added(solved, "[solve]\n", "tolerance = 0.001")},
      {"solve.load_steps", added(solved, "[solve]\n", "load_steps = 2")},
      {"solve.end_time", added(solved, "[solve]\n", "end_time = 2")},
      {"solve.frames", added(solved, "[solve]\n", "frames = 2")},
      {"solve.probes", added(solved, "[solve]\n", "probes = \"p.csv\"")},
      {"tool.shape",
       {full_scene, "\"cylinder\"\nradius = 0.005\nlength = 0.03\nedge_radius = 0.0005",
        "\"capsule\"\nradius = 0.005\nlength = 0.03"}},
      {"tool.radius", {full_scene, "radius = 0.005\nlength", "radius = 0.006\nlength"}},
      {"tool.length", {full_scene, "length = 0.03", "length = 0.04"}},
      {"tool (cylinder).edge_radius", {full_scene, "edge_radius = 0.0005", "edge_radius = 0.0006"}},
      {"tool (cone).half_angle", {cone, "half_angle = 40", "half_angle = 41"}},
      {"tool (cone).tip_radius", {cone, "tip_radius = 0.002", "tip_radius = 0.0021"}},
      {"tool.position", {full_scene, "position = [0, 0, 0.03]", "position = [0, 0, 0.04]"}},
      {"tool.direction", {full_scene, "direction = [0, 3, -4]", "direction = [0, 3, -5]"}},
      {"tool.max_speed", {full_scene, "max_speed = 0.5", "max_speed = 0.6"}},
      {"tool.opening", added(full_scene, "[tool]\n", "opening = 0.02")},
      {"tool.grip_force", added(full_scene, "[tool]\n", "opening = 0.02\ngrip_force = 3")},
      {"tool.input", added(full_scene, "[tool]\n", "input = \"script:e.csv\"")},
      {"tool.max_force", added(full_scene, "[tool]\n", "max_force = 3")},
      {"tool.friction", {full_scene, "friction = 0.2", "friction = 0.3"}},
      {"force.cutoff", {full_scene, "cutoff = 40", "cutoff = 50"}},
      {"force.rate_limit", {full_scene, "rate_limit = 100", "rate_limit = 101"}},
      {"lump.centre", {lumped, "centre = [0, 0, 0.03]", "centre = [0, 0, 0.031]"}},
      {"lump.radius", {lumped, "radius = 0.008", "radius = 0.009"}},
      {"lump.young", {lumped, "young = 40000", "young = 41000"}},
      {"lumps.count", {lumped, "count = 2", "count = 1"}},
      {"lumps.level", {lumped, "level = 1", "level = 2"}},
      {"lumps.seed", {lumped, "seed = 3", "seed = 4"}},
      {"lumps.layout", {lumped, "seed = 3", "seed = 3\nlayout = 2"}},
      {"device.class", {full_scene, "[camera]", "[device]\nclass = \"strong\"\n[camera]"}},
      {"device.stiffness", {full_scene, "[camera]", "[device]\nstiffness = 300\n[camera]"}},
      {"device.damping", {full_scene, "[camera]", "[device]\ndamping = 0.3\n[camera]"}},
      {"device.max_force", {full_scene, "[camera]", "[device]\nmax_force = 3\n[camera]"}},
      {"device.rise_time", {full_scene, "[camera]", "[device]\nrise_time = 0.02\n[camera]"}},
      {"device.scale", {full_scene, "[camera]", "[device]\nscale = 2\n[camera]"}},
      {"device.own_damping", {full_scene, "[camera]", "[device]\nown_damping = 3\n[camera]"}},
      {"device.orientation", {full_scene, "[camera]", "[device]\norientation = \"locked\"\n[camera]"}},
      {"device.lever", {full_scene, "[camera]", "[device]\nlever = 0.03\n[camera]"}},
      {"camera.target", {full_scene, "target = [0, 0, 0.01]", "target = [0, 0, 0.02]"}},
      {"camera.distance", {full_scene, "distance = 0.2", "distance = 0.3"}},
      {"camera.azimuth", {full_scene, "azimuth = 30", "azimuth = 31"}},
      {"camera.elevation", {full_scene, "elevation = 10", "elevation = 11"}},
      {"camera.fov", {full_scene, "fov = 40", "fov = 41"}},
  };
  for (const MaterialLaw& law : materialLaws()) {
    const Material material = test::sampleMaterial(law);
    forEachParameter(material, [&](const Parameter& p, std::span<const double> values) {
      if (!isSceneKey(p)) return;
      std::vector<double> other(values.begin(), values.end());
      other.back() *= 1.001;
      all[std::string("material.") + p.name] = {sceneOf(material), keyLine(p, values), keyLine(p, other)};
    });
  }
  return all;
}

/// The scene with this much mass scaling.
std::string withMassScaling(const std::string& scene, const std::string& amount) {
  const std::string line = "mass_scaling = " + amount + "\n";
  if (scene.find("[dynamics]\n") == std::string::npos) return scene + "[dynamics]\n" + line;
  return replaced(scene, "[dynamics]\n", "[dynamics]\n" + line);
}

}  // namespace

TEST_CASE("Changing a key of the reference changes the cache key where the set-up depends on it, and nowhere else",
          "[io][set_up_key]") {
  TempFolder folder;
  folder.write("a.obj", "v 0 0 0\n");
  folder.write("b.obj", "v 0 0 0\n");
  folder.write("t.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
  folder.write("p.csv", "X,Y,Z\n0,0,0\n");
  folder.write("e.csv", "x,y,z\n0,0,50\n");
  const Image image(ImageGrid({2, 2, 2}, Mat3::Identity(), Vec3::Zero()), 1.0F);
  for (const char* name : {"m.nii", "k.nii"}) folder.write(name, niftiFrom(image, NiftiType::UInt8, false));
  const auto keyOf = [&](const std::string& text) {
    return preparationKey(readScene(folder.write("s.toml", text)), TriangleSurface{});
  };
  const auto all = changes();
  int always = 0, with_scaling = 0, never = 0;
  for (const KeySpec& spec : sceneKeys()) {
    if (spec.type == KeySpec::Type::Table || spec.type == KeySpec::Type::Tables) continue;  // their keys are here
    const std::string name = std::string(spec.table) + "." + spec.name;
    INFO(name);
    const bool scaling = name == "dynamics.mass_scaling";
    REQUIRE((scaling || all.contains(name)));  // a new key needs a line in changes()
    for (const bool scaled : {false, true}) {
      const std::string amount = scaled ? "0.5" : "0";
      const std::string before = withMassScaling(scaling ? full_scene : all.at(name).scene, amount);
      const std::string after = scaling ? replaced(before, "mass_scaling = " + amount, "mass_scaling = 0.25")
                                        : replaced(before, all.at(name).from, all.at(name).to);
      REQUIRE(after != before);
      const bool matters =
          spec.set_up == KeySpec::SetUp::Always || (spec.set_up == KeySpec::SetUp::WithMassScaling && scaled);
      CHECK((keyOf(after) != keyOf(before)) == matters);
    }
    ++(spec.set_up == KeySpec::SetUp::Always ? always : spec.set_up == KeySpec::SetUp::Never ? never : with_scaling);
  }
  CHECK(always > 40);
  CHECK(with_scaling == 4);
  CHECK(never > 20);
}

TEST_CASE("A rate that replaces the file's counts where mass is scaled", "[io][set_up_key]") {
  TempFolder folder;
  for (const bool scaled : {false, true}) {
    Scene scene = readScene(folder.write("s.toml", withMassScaling(full_scene, scaled ? "0.5" : "0")));
    const std::string before = preparationKey(scene, {});
    overrideRate(scene, 500);
    CHECK(scene.dynamics.rate_hz == 500);
    CHECK((preparationKey(scene, {}) != before) == scaled);
  }
}

TEST_CASE("What the files of a scene say is part of the cache key", "[io][set_up_key]") {
  TempFolder folder;
  folder.write("e.csv", "x,y,z\n0,0,50\n");
  Image image(ImageGrid({2, 2, 2}, Mat3::Identity(), Vec3::Zero()), 1.0F);
  const auto keyOf = [&](const std::string& text) {
    for (const char* name : {"m.nii", "k.nii"}) folder.write(name, niftiFrom(image, NiftiType::Float32, false));
    return preparationKey(readScene(folder.write("s.toml", text)), {});
  };
  const std::string before = keyOf(mixed);
  CHECK(keyOf(mixed) == before);
  image.value[3] = 0.9F;
  CHECK(keyOf(mixed) != before);

  Scene scene = readScene(folder.write("t.toml", measured));
  REQUIRE(scene.boundaries[1].points);
  CHECK((scene.boundaries[1].points->after.at(0) - Vec3(0, 0, 0.05)).norm() < 1e-15);
  BoundarySpec& point = scene.boundaries[1];
  point.region.kind = Region::Kind::Point;
  const std::string here = preparationKey(scene, {});
  point.region.point.x() = 1e-3;
  CHECK(preparationKey(scene, {}) != here);
}
