#include "io/scene_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <span>
#include <string_view>
#include <utility>

#include "base/number_text.h"
#include "base/printable_text.h"
#include "io/scene_boundary.h"
#include "io/scene_keys.h"
#include "io/scene_load.h"
#include "io/scene_lumps.h"
#include "io/scene_materials.h"
#include "io/scene_organs.h"
#include "io/scene_rigid_bodies.h"
#include "io/scene_tools.h"
#include "io/surface_file.h"
#include "io/text_file.h"
#include "io/toml_table.h"
#include "scene/scene_messages.h"
#include "setup/place.h"

namespace palpate {

namespace {

/// Of a cloud that follows the tool, where nothing is said. A slab of 100 x 100 x 50 mm under a 5 mm ball has 0.62 of
/// the points and of the time with it, and the same error to 0.02 % of the force (mtled certify).
constexpr double following_cells_per_point = 1.6;
/// Likewise: the kidney takes 4 steps a tick instead of 5 (4 % of its mass), and the same force to 0.02 % in drags at
/// 30 mm/s (mtled follow kidney).
constexpr double following_mass_scaling = 0.05;

void readQuadrature(const TomlTable& table, bool follows, QuadratureSpec& quadrature) {
  if (!table.has("quadrature_accuracy")) {
    table.forbid({"quadrature_division", "quadrature_depth"}, "without \"quadrature_accuracy\"");
  }
  table.read("points_per_cell", quadrature.points_per_cell);
  table.read("cells_per_point", quadrature.cells_per_point);
  table.read("quadrature_accuracy", quadrature.accuracy);
  if (quadrature.cells_per_point > 1) {
    if (quadrature.points_per_cell > 1) table.forbid({"cells_per_point"}, "with more than one point per cell");
    if (quadrature.accuracy > 0) table.forbid({"cells_per_point"}, "with \"quadrature_accuracy\"");
  }
  if (follows && !table.has("cells_per_point") && quadrature.points_per_cell == 1 && quadrature.accuracy == 0)
    quadrature.cells_per_point = following_cells_per_point;
  table.read("quadrature_division", quadrature.division);
  table.read("quadrature_depth", quadrature.max_depth);
}

void readDiscretization(const TomlTable& table, Scene& scene) {
  scene.discretization.follow = !table.has("spacing");
  table.read("follow", scene.discretization.follow);
  if (scene.discretization.follow) {
    table.read("spacing", scene.discretization.at_tools);
    scene.discretization.spacing = std::numeric_limits<double>::infinity();  // until the tools are known
  } else {
    if (!table.has("spacing"))
      throw InputError(table.place(), "the key \"spacing\" is missing in [discretization]",
                       "add spacing = number in m, or leave follow out");
    table.read("spacing", scene.discretization.spacing);
  }
  table.read("seed", scene.discretization.seed);
  readQuadrature(table, scene.discretization.follow, scene.discretization.quadrature);
  scene.discretization.basis_degree = 1 + table.readChoice("basis", scene.discretization.basis_degree - 1);
  table.read("support_factor", scene.discretization.support_factor);
  table.read("mu", scene.discretization.mmls_weight);
  if (table.readChoice("scheme", 0) == 1) scene.discretization.formulation = Formulation::paper();
  if (table.readChoice("boundary_method", 0) == 1)
    scene.discretization.boundary_method = DiscretizationSpec::BoundaryMethod::Ebciem;
  for (const TomlTable& entry : table.tables("refine", {"discretization.refine"})) {
    RefineSpec& refine = scene.discretization.refine.emplace_back();
    refine.place = entry.place();
    entry.read("centre", refine.centre);
    entry.read("radius", refine.radius);
    entry.read("spacing", refine.spacing);
    entry.read("blend", refine.blend);
    if (refine.spacing >= scene.discretization.spacing) {
      throw InputError(entry.place("spacing"), "the refined spacing is not below the global one",
                       "give less than [discretization] spacing, or leave the refinement out");
    }
  }
}

/// A cloud that follows the tool has its spacing far from it; where it can't, the scene has to give one.
/// @param asked  of the key `follow`; null: the scene gives no spacing either
void checkFollow(const TomlTable& top, const SourceLocation* asked, Scene& scene) {
  const SourceLocation& place = asked ? *asked : top.has("discretization") ? top.place("discretization") : top.place();
  const auto refuse = [&](const std::string& why, const std::string& instead) {
    const std::string missing = "the key \"spacing\" is missing in [discretization], and ";
    throw InputError(place, (asked ? "" : missing) + why,
                     instead + "give [discretization] spacing" + (asked ? " in place of follow" : "") +
                         (top.has("tool") ? ", about " + number(fineSpacing(scene)) + " m for this tool" : ", in m"));
  };
  if (!top.has("tool")) refuse("there is no tool that the cloud could follow", "add [tool], or ");
  scene.discretization.spacing = followSpacing(scene);
}

void readDynamics(const TomlTable& table, Scene& scene) {
  table.read("rate", scene.dynamics.rate_hz);
  table.read("catch_up", scene.dynamics.catch_up);
  table.read("time_step", scene.dynamics.time_step);
  table.read("step_safety", scene.dynamics.step_safety);
  if (scene.discretization.follow && scene.dynamics.time_step <= 0)
    scene.dynamics.mass_scaling = following_mass_scaling;
  table.read("mass_scaling", scene.dynamics.mass_scaling);
  table.read("damping", scene.dynamics.damping);
  table.read("gravity", scene.dynamics.gravity);
  table.read("threads", scene.dynamics.threads);
  const bool is_small = table.readChoice("gradient_precision", scene.discretization.follow ? 1 : 0) == 1;
  scene.dynamics.gradient_precision = is_small ? GradientPrecision::Int16 : GradientPrecision::Float32;
  if (scene.dynamics.time_step <= 0) return;
  const double steps = 1.0 / (scene.dynamics.rate_hz * scene.dynamics.time_step);
  constexpr double rounding = 1e-6;  // of a decimal fraction such as 0.000333333
  if (steps < 1 - rounding || std::abs(steps - std::round(steps)) > rounding * steps) {
    char advice[160];
    const double whole = std::max(1.0, std::ceil(steps - rounding));
    std::snprintf(advice, sizeof advice, "give %.9g s (%g steps a tick), or 0 to have it chosen",
                  1.0 / (scene.dynamics.rate_hz * whole), whole);
    char problem[160];
    std::snprintf(problem, sizeof problem, "a tick of %g s is not a whole number of steps of %g s",
                  1 / scene.dynamics.rate_hz, scene.dynamics.time_step);
    throw InputError(table.place("time_step"), problem, advice);
  }
}

void readSolve(const TomlTable& table, const std::filesystem::path& folder, SolveSpec& solve) {
  solve.place = table.place();
  if (table.readChoice("mode", 0) == 1) {
    solve.mode = SolveSpec::Mode::Transient;
    table.forbid({"tolerance", "load_steps"}, "to a transient solution");
  }
  table.read("tolerance", solve.tolerance);
  table.read("load_steps", solve.load_steps);
  table.read("end_time", solve.end_time);
  table.read("frames", solve.frames);
  if (table.has("probes")) {
    std::string file;
    table.read("probes", file);
    solve.probes_file = existingFile(table, "probes", folder / file, "probes file");
  }
}

/// What a cache goes by: every value that was accepted and that a preparation depends on, a line each.
std::string setUpValues(const TomlFile& file, bool mass_scaling) {
  std::string lines;
  for (const auto& [key, value] : file.set_up) lines += key + " = " + value + "\n";
  if (mass_scaling)
    for (const auto& [key, value] : file.set_up_with_mass_scaling) lines += key + " = " + value + "\n";
  return lines;
}

/// "material[0]" as name and place in the list; -1: no list.
std::pair<std::string, int> listEntry(const std::string& part, const SourceLocation& place) {
  const std::size_t bracket = part.find('[');
  if (bracket == std::string::npos) return {part, -1};
  const std::string digits = part.substr(bracket + 1, part.size() - bracket - 2);
  const bool number = part.back() == ']' && !digits.empty() && digits.size() < 5 &&
                      digits.find_first_not_of("0123456789") == std::string::npos;
  if (!number) throw InputError(place, inQuotes(part) + " names no entry of a list", "write material[0].young");
  return {part.substr(0, bracket), std::stoi(digits)};
}

/// Sets what a change says, in tables that are made where they are missing.
void apply(const SceneChange& change, const std::string& path, toml::table& document) {
  const SourceLocation place{path, 0, 0};
  const toml::table parsed = parseToml("value = " + change.value, path + ", set to another value, " + change.key);
  if (parsed.size() != 1) throw InputError(place, "the value of " + inQuotes(change.key) + " is more than one", "");
  toml::table* table = &document;
  std::string rest = change.key;
  for (std::size_t dot = rest.find('.'); dot != std::string::npos; dot = rest.find('.')) {
    const auto [name, index] = listEntry(rest.substr(0, dot), place);
    rest.erase(0, dot + 1);
    if (index < 0 && !table->contains(name)) table->insert(name, toml::table());
    toml::node* node = table->get(name);
    if (index >= 0 && node != nullptr && node->is_array())
      node = node->as_array()->get(static_cast<std::size_t>(index));
    if (node == nullptr || !node->is_table())
      throw InputError(place, "the scene has no " + inQuotes(change.key), "name a key that its tables have");
    table = node->as_table();
  }
  parsed.get("value")->visit([&](const auto& value) { table->insert_or_assign(rest, value); });
}

}  // namespace

void overrideRate(Scene& scene, double rate_hz) {
  scene.dynamics.rate_hz = rate_hz;
  if (scene.dynamics.mass_scaling > 0) scene.set_up_values += "instead: dynamics.rate = " + shortest(rate_hz) + "\n";
}

namespace {

/// What is often opened in place of a scene: what one would be made of.
void refuseOther(const std::string& path) {
  std::string type = std::filesystem::path(path).extension().string();
  for (char& c : type) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  const bool surface = !type.empty() && (surfaceFormats() + ",").find(type + ",") != std::string::npos;
  const bool scan = type == ".nii" || type == ".gz";
  if (surface || scan)
    throw InputError({path}, std::string("this is a ") + (surface ? "surface" : "scan") + ", no scene",
                     "make one of it: mtled import " + path + (surface ? " --unit mm" : " --mask MASK"));
}

}  // namespace

Scene readScene(const std::string& path) { return readScene(path, {}); }

Scene readScene(const std::string& path, std::span<const SceneChange> changes) {
  refuseOther(path);
  return readScene(
      SceneText{readWholeFile(path, {}, max_toml_bytes), std::filesystem::path(path).parent_path().string(), path},
      changes);
}

SceneChange changeFrom(const std::string& assignment) {
  const auto trimmed = [](const std::string& s) {
    const auto begin = s.find_first_not_of(" \t");
    return begin == std::string::npos ? "" : s.substr(begin, s.find_last_not_of(" \t") - begin + 1);
  };
  const std::size_t equals = assignment.find('=');
  SceneChange change;
  change.key = trimmed(assignment.substr(0, equals));
  if (equals != std::string::npos) change.value = trimmed(assignment.substr(equals + 1));
  if (change.key.empty() || change.value.empty())
    throw InputError({}, inQuotes(assignment) + " sets no key to a value", "write material[0].young = 4000");
  return change;
}

Scene readScene(const SceneText& given, std::span<const SceneChange> changes) {
  const std::string& path = given.name;
  if (given.text.size() > max_toml_bytes) throw InputError({path}, "this text is too long for a scene", "");
  toml::table document = parseToml(given.text, path);
  for (const SceneChange& change : changes) apply(change, path, document);
  TomlFile file{path, sceneKeys(), {}};
  Scene scene;
  scene.place = {path, 0, 0};
  const std::filesystem::path folder = given.folder;

  const TomlTable top(file, document, "", {""});
  scene.name = printable(std::filesystem::path(path).stem().string());
  top.readName("name", scene.name);
  readOrgans(top, folder, scene);
  readDiscretization(top.table("discretization", {"discretization"}), scene);
  for (const TomlTable& entry : top.tables("material", {"material"})) {
    MaterialSpec material;
    readMaterial(entry, folder, scene.materials, material);
    material.organ = organNamed(entry, scene);
    scene.materials.push_back(std::move(material));
  }
  checkMaterials(scene);
  for (const TomlTable& entry : top.tables("fixed", {"boundary", "region"})) {
    scene.boundaries.push_back(readFixed(entry, scene.boundaries));
    scene.boundaries.back().organ = organNamed(entry, scene);
  }
  for (const TomlTable& entry : top.tables("prescribed", {"prescribed", "boundary", "region"})) {
    scene.boundaries.push_back(readPrescribed(entry, folder.string(), scene.boundaries));
    scene.boundaries.back().organ = organNamed(entry, scene);
  }
  scene.rigid = readRigidBodies(top, folder, scene.boundaries);
  if (scene.boundaries.empty() && scene.rigid.empty())
    throw InputError(top.place(), "the key \"fixed\" is missing, and nothing is prescribed: the organ is not held",
                     "add [[fixed]] with the region where it is held, or [[rigid]] that it lies on");
  for (const TomlTable& entry : top.tables("load", {"load"})) scene.loads.push_back(readLoad(entry, scene));
  std::erase_if(file.set_up, [](const auto& entry) { return entry.first.starts_with("load["); });  // regions
  readDynamics(top.table("dynamics", {"dynamics"}), scene);
  readSolve(top.table("solve", {"solve"}), folder, scene.solve);
  if (top.has("tool")) readTools(top, folder, scene);
  if (scene.discretization.follow) {
    const auto asked = file.places.find("discretization.follow");
    checkFollow(top, asked != file.places.end() ? &asked->second : nullptr, scene);
  }
  scene.places = file.places;  // of the organ, for what is wrong with it
  readLumps(top, scene);

  const TomlTable force = top.table("force", {"force"});
  force.read("cutoff", scene.force.cutoff_hz);
  force.read("rate_limit", scene.force.rate_limit);

  readDevice(top.table("device", {"device"}), scene.device);

  const TomlTable camera = top.table("camera", {"camera"});
  camera.read("target", scene.camera.target);
  camera.read("distance", scene.camera.distance);
  camera.read("azimuth", scene.camera.azimuth_deg);
  camera.read("elevation", scene.camera.elevation_deg);
  camera.read("fov", scene.camera.fov_deg);

  scene.files = std::move(file.files);
  scene.places = std::move(file.places);
  scene.set_up_values = setUpValues(file, scene.dynamics.mass_scaling > 0);
  return scene;
}

}  // namespace palpate
