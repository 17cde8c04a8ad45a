#include "io/scene_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <span>
#include <string_view>
#include <utility>

#include "base/number_text.h"
#include "base/printable_text.h"
#include "contact/tool_set.h"
#include "imaging/membership.h"
#include "io/image_file.h"
#include "io/scene_boundary.h"
#include "io/scene_keys.h"
#include "io/scene_lumps.h"
#include "io/surface_file.h"
#include "io/text_file.h"
#include "io/toml_table.h"
#include "mechanics/materials/material_law.h"

namespace palpate {

namespace {

/// @param path  the scene's folder joined with what the key says, which replaces it where it is absolute
std::string existingFile(const TomlTable& table, const std::string& key, const std::filesystem::path& path,
                         const std::string& what) {
  const std::filesystem::path file = path.lexically_normal();
  if (std::error_code error; !std::filesystem::is_regular_file(file, error)) {
    throw InputError(table.place(key), "there is no " + what + " " + file.string(),
                     "the path starts from the scene file's folder");
  }
  return file.string();
}

void readOrgan(const TomlTable& organ, const std::filesystem::path& folder, Scene& scene) {
  organ.read("colour", scene.tissue_colour);
  if (organ.has("surface") == organ.has("solid")) {
    throw InputError(organ.place("solid"),
                     organ.has("solid") ? "both \"surface\" and \"solid\"" : "neither \"surface\" nor \"solid\"",
                     "give surface = \"file.obj\" with a unit, or solid = \"box\", \"cylinder\" or \"ellipsoid\"");
  }
  if (organ.has("surface")) {
    organ.forbid({"size", "radius", "height", "semi_axes", "upper_half"}, "to a surface file");
    std::string file;
    organ.read("surface", file);
    scene.surface_file = existingFile(organ, "surface", folder / file, "surface file");
    if (organ.has("unit") == organ.has("scale")) {
      throw InputError(organ.place(organ.has("unit") ? "unit" : "surface"),
                       organ.has("unit") ? "both \"unit\" and \"scale\"" : "the surface's unit is missing",
                       "add unit = \"mm\", \"cm\" or \"m\", or scale = the unit's length in m");
    }
    constexpr double units[] = {0.001, 0.01, 1.0};  // in the order of the key's choices
    if (organ.has("unit")) scene.surface_scale = units[organ.readChoice("unit", 2)];
    organ.read("scale", scene.surface_scale);
    organ.read("repair", scene.repair_surface);
    return;
  }
  organ.forbid({"unit", "scale", "repair"}, "to a solid, which is given in m");
  switch (organ.readChoice("solid", 0)) {
    case 0:
      scene.solid = Scene::Solid::Box;
      organ.require({"size"}, "a box");
      organ.forbid({"radius", "height", "semi_axes", "upper_half"}, "to a box");
      break;
    case 1:
      scene.solid = Scene::Solid::Cylinder;
      organ.require({"radius", "height"}, "a cylinder");
      organ.forbid({"size", "semi_axes", "upper_half"}, "to a cylinder");
      break;
    default:
      scene.solid = Scene::Solid::Ellipsoid;
      organ.require({"semi_axes"}, "an ellipsoid");
      organ.forbid({"size", "radius", "height"}, "to an ellipsoid");
  }
  organ.read("size", scene.size);
  organ.read("radius", scene.radius);
  organ.read("height", scene.height);
  organ.read("semi_axes", scene.semi_axes);
  organ.read("upper_half", scene.upper_half);
}

void readQuadrature(const TomlTable& table, QuadratureSpec& quadrature) {
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
  table.read("quadrature_division", quadrature.division);
  table.read("quadrature_depth", quadrature.max_depth);
}

void readDiscretization(const TomlTable& table, Scene& scene) {
  table.read("spacing", scene.spacing);
  table.read("seed", scene.seed);
  readQuadrature(table, scene.quadrature);
  scene.basis_degree = 1 + table.readChoice("basis", scene.basis_degree - 1);
  table.read("support_factor", scene.support_factor);
  table.read("mu", scene.mmls_weight);
  table.read("consistent_gradients", scene.consistent_gradients);
  table.read("node_patch_volume", scene.node_patch_volume);
  table.read("cell_volume", scene.cell_volume);
  if (scene.cell_volume && !scene.node_patch_volume)
    throw InputError(table.place("cell_volume"), "cell_volume takes over from node patches, and there are none",
                     "set node_patch_volume = true, or leave cell_volume out");
  if (table.readChoice("boundary_method", 0) == 1) scene.boundary_method = Scene::BoundaryMethod::Ebciem;
  for (const TomlTable& entry : table.tables("refine", {"discretization.refine"})) {
    RefineSpec& refine = scene.refine.emplace_back();
    refine.place = entry.place();
    entry.read("centre", refine.centre);
    entry.read("radius", refine.radius);
    entry.read("spacing", refine.spacing);
    entry.read("blend", refine.blend);
    if (refine.spacing >= scene.spacing) {
      throw InputError(entry.place("spacing"), "the refined spacing is not below the global one",
                       "give less than [discretization] spacing, or leave the refinement out");
    }
  }
}

/// "an Ogden material"
std::string withArticle(const MaterialLaw& law) {
  const bool vowel = std::string_view("AEIOUaeiou").find(*law.title) != std::string_view::npos;
  return std::string(vowel ? "an " : "a ") + law.title + " material";
}

/// A law's lists have one entry for each term, and the kernel room for some.
void checkTermCounts(const TomlTable& table, const std::map<std::string, std::vector<double>>& lists,
                     std::span<const Parameter> parameters) {
  std::string found;
  const Parameter* first = nullptr;
  bool wrong = false;
  for (const Parameter& p : parameters) {
    if (p.type != Parameter::Type::Numbers) continue;
    if (first == nullptr) first = &p;
    const std::size_t terms = lists.at(p.name).size();
    wrong |= terms < 1 || terms > std::size_t{Material::max_terms} || terms != lists.at(first->name).size();
    if (&p != first) found += " and ";
    found += inQuotes(p.name);
    found += &p == first ? " has " : " ";
    found += std::to_string(terms);
    if (&p == first) found += " terms";
  }
  if (!wrong) return;
  const std::string limit = std::to_string(Material::max_terms);
  throw InputError(table.place(first->name), found,
                   std::string(lists.size() > 1 ? "give both the same number of terms, 1 to " : "give 1 to ") + limit);
}

/// Prony terms, where there are any.
void readRelaxation(const TomlTable& table, Material& material) {
  const char* key = relaxationParameter().name;
  if (!table.has(key)) return;
  std::vector<double> pairs;
  table.readPairs(key, pairs);
  const std::size_t terms = pairs.size() / 2;
  if (terms < 1 || terms > std::size_t{Material::max_relaxation_terms})
    throw InputError(table.place(key), inQuotes(key) + " has " + std::to_string(terms) + " terms",
                     "give 1 to " + std::to_string(Material::max_relaxation_terms) +
                         " pairs [g, tau], or leave it out: the tissue is elastic then");
  material.set(key, pairs);
  if (const auto problem = relaxationProblem(material))
    throw InputError(table.place(key), problem->problem, problem->advice);
}

/// The law that the table chooses, with its parameters and those of all laws.
Material readLaw(const TomlTable& table) {
  const auto laws = materialLaws();
  const MaterialLaw& law = laws[static_cast<std::size_t>(table.readChoice("model", 0))];
  const std::string one = withArticle(law);
  for (const Parameter& p : law.parameters)
    if (p.isRequired()) table.require({p.name}, one);
  for (const MaterialLaw& other : laws)
    for (const Parameter& p : other.parameters) {
      const bool own = std::any_of(law.parameters.begin(), law.parameters.end(),
                                   [&](const Parameter& mine) { return std::string_view(mine.name) == p.name; });
      if (!own) table.forbid({p.name}, "to " + one);
    }
  Material material = Material::of(law.name);
  std::map<std::string, std::vector<double>> lists;
  const auto readNumber = [&](const Parameter& p) {
    double value = 0;
    table.read(p.name, value);
    if (table.has(p.name)) material.set(p.name, value);
  };
  for (const Parameter& p : law.parameters) {
    if (p.type == Parameter::Type::Numbers)
      table.read(p.name, lists[p.name]);
    else
      readNumber(p);
  }
  for (const auto& [parameter, member] : commonMaterialParameters()) readNumber(parameter);
  checkTermCounts(table, lists, law.parameters);
  for (const auto& [name, values] : lists) material.set(name, values);
  readRelaxation(table, material);
  if (const auto problem = law.check(material))
    throw InputError(table.place(problem->parameter), problem->problem, problem->advice);
  return material;
}

/// What the law of tissue that mixes must be.
void checkMixes(const MaterialSpec& spec) {
  if (spec.material.law != Material::of("neo-hookean").law || spec.material.relaxation_count > 0)
    throw InputError(spec.place, "only neo-Hookean tissue without relaxation mixes by a membership",
                     "use model = \"neo-hookean\" for it and for the first material");
}

/// Membership and mask of a material, on the same voxels.
std::shared_ptr<const Membership> readMembership(const TomlTable& table, const std::filesystem::path& folder,
                                                 const std::vector<MaterialSpec>& before) {
  const auto file = [&](const char* key) {
    std::string name;
    table.read(key, name);
    return existingFile(table, key, folder / name, "image");
  };
  checkMixes(before.front());
  for (const MaterialSpec& other : before)
    if (other.membership)
      throw InputError(table.place("membership"), "a second material with a membership", "one of a scene may have it");
  auto membership = std::make_shared<Membership>();
  membership->share = readImage(file("membership"), {}, table.place("membership"));
  if (!table.has("mask")) return membership;
  membership->mask = maskOf(readImage(file("mask"), {}, table.place("mask")));
  if (!sameGrid(membership->mask->grid, membership->share.grid))
    throw InputError(table.place("mask"), "the mask's voxels are not those of the membership",
                     "resample it to the membership's");
  return membership;
}

/// @param before  the materials that the scene has so far
void readMaterial(const TomlTable& table, const std::filesystem::path& folder, const std::vector<MaterialSpec>& before,
                  MaterialSpec& material) {
  const bool first = before.empty();
  material.place = table.place();
  table.readName("name", material.name);
  material.material = readLaw(table);
  if (table.has("mask") && !table.has("membership")) table.forbid({"mask"}, "without \"membership\"");
  if (table.has("membership")) {
    table.forbid({"region"}, "beside \"membership\"");
    if (first)
      throw InputError(table.place("membership"), "the first material has a membership",
                       "the first is what remains; give the membership to a later one");
    checkMixes(material);
    material.membership = readMembership(table, folder, before);
    material.everywhere = false;
    return;
  }
  if (first && table.has("region")) {
    throw InputError(table.place("region"), "the first material has a region",
                     "the first applies everywhere; give regions to later ones");
  }
  if (!first && !table.has("region")) {
    throw InputError(table.place(), "this material has no region and would replace all before it",
                     "add region = { shape = ..., ... }");
  }
  material.everywhere = first;
  if (!first) material.region = readRegion(table.table("region", {"region"}));
}

void readSkull(const TomlTable& table, const std::filesystem::path& folder, SkullSpec& skull) {
  skull.given = true;
  skull.place = table.place();
  table.require({"from"}, "a skull");
  std::string from;
  table.read("from", from);
  table.read("clearance", skull.clearance);
  for (const TomlTable& region : table.tables("open", {"region"})) skull.open.push_back(readRegion(region));
  if (from == "organ") return table.forbid({"unit"}, "to the organ's own surface");
  table.require({"unit"}, "a skull from a file");
  constexpr double units[] = {0.001, 0.01, 1.0};  // in the order of the key's choices
  const std::string file = existingFile(table, "from", folder / from, "surface file");
  skull.surface = std::make_shared<const TriangleSurface>(
      readClosedSurface(file, units[table.readChoice("unit", 2)], table.place("from")));
}

void readDynamics(const TomlTable& table, Scene& scene) {
  table.read("rate", scene.rate_hz);
  table.read("catch_up", scene.catch_up);
  table.read("time_step", scene.time_step);
  table.read("step_safety", scene.step_safety);
  table.read("mass_scaling", scene.mass_scaling);
  table.read("damping", scene.damping);
  table.read("gravity", scene.gravity);
  table.read("threads", scene.threads);
  if (table.readChoice("gradient_precision", 0) == 1) scene.gradient_precision = GradientPrecision::Int16;
  if (scene.time_step <= 0) return;
  const double steps = 1.0 / (scene.rate_hz * scene.time_step);
  constexpr double rounding = 1e-6;  // of a decimal fraction such as 0.000333333
  if (steps < 1 - rounding || std::abs(steps - std::round(steps)) > rounding * steps) {
    char advice[160];
    const double whole = std::max(1.0, std::ceil(steps - rounding));
    std::snprintf(advice, sizeof advice, "give %.9g s (%g steps a tick), or 0 to have it chosen",
                  1.0 / (scene.rate_hz * whole), whole);
    char problem[160];
    std::snprintf(problem, sizeof problem, "a tick of %g s is not a whole number of steps of %g s", 1 / scene.rate_hz,
                  scene.time_step);
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

/// The groups of keys that tools may have.
std::vector<std::string> toolGroups() {
  std::vector<std::string> groups{"tool"};
  for (const ToolType* type : toolTypes()) groups.push_back(toolKeyGroup(*type));
  return groups;
}

/// The script that a tool follows; "": a hand leads it.
std::string readInput(const TomlTable& table, const std::filesystem::path& folder) {
  const std::string script = "script:";
  std::string input = "hand";
  table.read("input", input);
  if (input == "hand") return "";
  if (!input.starts_with(script))
    throw InputError(table.place("input"), inQuotes(input) + " is no input",
                     "give \"hand\", or \"script:FILE\" with a tool script");
  return existingFile(table, "input", folder / input.substr(script.size()), "tool script");
}

/// @param any  in which the keys of all tools may stand
ToolSpec readTool(const TomlTable& any, const std::filesystem::path& folder) {
  ToolSpec spec;
  spec.place = any.place();
  ToolShape& tool = spec.shape;
  tool.kind = static_cast<ToolKind>(any.readChoice("shape", 0));
  const ToolType& type = toolType(tool.kind);
  for (const ToolType* other : toolTypes()) {
    for (const Parameter& foreign : other->parameters) {
      const bool known = std::any_of(type.parameters.begin(), type.parameters.end(),
                                     [&](const Parameter& own) { return std::string_view(own.name) == foreign.name; });
      if (!known) any.forbid({foreign.name}, std::string("to a ") + type.title);
    }
  }

  const TomlTable table = any.within({"tool", toolKeyGroup(type)});
  table.read("radius", tool.radius);
  table.read("length", tool.length);
  tool = ToolShape::of(tool.kind, tool.radius, tool.length);
  for (std::size_t k = 0; k < type.parameters.size(); ++k) table.read(type.parameters[k].name, tool.parameter[k]);
  table.read("position", spec.position);
  table.readDirection("direction", spec.direction);
  table.read("max_speed", spec.max_speed);
  table.read("max_force", spec.max_force);
  table.read("friction", spec.friction);
  table.read("opening", spec.opening);
  spec.script = readInput(table, folder);
  if (const std::optional<ToolFault> fault = type.fault(tool))
    throw InputError(table.place(fault->key), fault->problem, fault->advice);
  return spec;
}

/// [tool], or up to max_tools of [[tool]].
void readTools(const TomlTable& top, const std::filesystem::path& folder, Scene& scene) {
  std::vector<ToolSpec> specs;
  if (top.isList("tool")) {
    for (const TomlTable& entry : top.tables("tool", toolGroups())) {
      if (specs.size() == std::size_t{max_tools})
        throw InputError(entry.place(), "more than " + std::to_string(max_tools) + " tools", "leave the others out");
      specs.push_back(readTool(entry, folder));
    }
  } else {
    specs.push_back(readTool(top.table("tool", toolGroups()), folder));
  }
  if (specs.empty()) return;
  const ToolSpec& first = specs[0];
  scene.tool = first.shape;
  scene.tool_position = first.position;
  scene.tool_direction = first.direction;
  scene.tool_max_speed = first.max_speed;
  scene.tool_max_force = first.max_force;
  scene.friction = first.friction;
  scene.tool_opening = first.opening;
  scene.tool_script = first.script;
  scene.further_tools.assign(specs.begin() + 1, specs.end());
}

void readDevice(const TomlTable& table, DeviceSettings& device) {
  device = DeviceSettings::of(table.readChoice("class", 0));
  table.read("stiffness", device.stiffness);
  table.read("damping", device.damping);
  table.read("max_force", device.max_force);
  table.read("rise_time", device.rise_time);
  table.read("scale", device.scale);
  table.read("own_damping", device.own_damping);
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
  scene.rate_hz = rate_hz;
  if (scene.mass_scaling > 0) scene.set_up_values += "instead: dynamics.rate = " + shortest(rate_hz) + "\n";
}

Scene readScene(const std::string& path) { return readScene(path, {}); }

Scene readScene(const std::string& path, std::span<const SceneChange> changes) {
  toml::table document = parseToml(readWholeFile(path, {}, max_toml_bytes), path);
  for (const SceneChange& change : changes) apply(change, path, document);
  TomlFile file{path, sceneKeys(), {}};
  Scene scene;
  scene.place = {path, 0, 0};
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();

  const TomlTable top(file, document, "", {""});
  scene.name = printable(std::filesystem::path(path).stem().string());
  top.readName("name", scene.name);
  readOrgan(top.table("organ", {"organ"}), folder, scene);
  readDiscretization(top.table("discretization", {"discretization"}), scene);
  for (const TomlTable& entry : top.tables("material", {"material"})) {
    MaterialSpec material;
    readMaterial(entry, folder, scene.materials, material);
    scene.materials.push_back(std::move(material));
  }
  for (const TomlTable& entry : top.tables("fixed", {"boundary", "region"})) {
    scene.boundaries.push_back(readFixed(entry, scene.boundaries));
  }
  for (const TomlTable& entry : top.tables("prescribed", {"prescribed", "boundary", "region"})) {
    scene.boundaries.push_back(readPrescribed(entry, folder.string(), scene.boundaries));
  }
  if (top.has("skull")) readSkull(top.table("skull", {"skull"}), folder, scene.skull);
  readDynamics(top.table("dynamics", {"dynamics"}), scene);
  readSolve(top.table("solve", {"solve"}), folder, scene.solve);
  if (top.has("tool")) readTools(top, folder, scene);
  scene.places = file.places;  // of the organ, for what is wrong with it
  readLumps(top, scene);

  const TomlTable force = top.table("force", {"force"});
  force.read("cutoff", scene.filter_cutoff_hz);
  force.read("rate_limit", scene.force_rate_limit);

  readDevice(top.table("device", {"device"}), scene.device);

  const TomlTable camera = top.table("camera", {"camera"});
  camera.read("target", scene.camera_target);
  camera.read("distance", scene.camera_distance);
  camera.read("azimuth", scene.camera_azimuth_deg);
  camera.read("elevation", scene.camera_elevation_deg);
  camera.read("fov", scene.camera_fov_deg);

  scene.places = std::move(file.places);
  scene.set_up_values = setUpValues(file, scene.mass_scaling > 0);
  return scene;
}

}  // namespace palpate
