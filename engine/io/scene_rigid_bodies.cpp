#include "io/scene_rigid_bodies.h"

#include <algorithm>

#include "contact/rigid_bodies.h"
#include "io/scene_boundary.h"
#include "io/surface_file.h"
#include "scene/scene_rigid.h"
#include "setup/imposed_nodes.h"

namespace palpate {
namespace {

constexpr auto motion_keys = {"translation", "axis_point", "axis", "angle", "duration", "curve", "curve_table"};

/// A closed surface from the file that `key` names.
void readSurface(const TomlTable& table, const char* key, const std::filesystem::path& folder, RigidSpec& body) {
  table.require({"unit"}, "a surface from a file");
  std::string name;
  table.read(key, name);
  constexpr double units[] = {0.001, 0.01, 1.0};  // in the order of the key's choices
  const std::string file = existingFile(table, key, folder / name, "surface file");
  body.surface = std::make_shared<const TriangleSurface>(
      readClosedSurface(file, units[table.readChoice("unit", 2)], table.place(key)));
}

void readOpenings(const TomlTable& table, RigidSpec& body) {
  table.read("clearance", body.clearance);
  for (const TomlTable& region : table.tables("open", {"region"})) body.open.push_back(readRegion(region));
}

RigidSpec readSkull(const TomlTable& table, const std::filesystem::path& folder) {
  RigidSpec body;
  body.name = skull_name;
  body.place = table.place();
  body.encloses = true;
  table.require({"from"}, "a skull");
  std::string from;
  table.read("from", from);
  readOpenings(table, body);
  body.of_organ = from == "organ";
  if (body.of_organ)
    table.forbid({"unit"}, "to the organ's own surface");
  else
    readSurface(table, "from", folder, body);
  return body;
}

void readSolid(const TomlTable& table, RigidSpec& body) {
  for (const char* key : {"unit", "side", "clearance", "open"}) table.forbid({key}, "to a region");
  const TomlTable region = table.table("region", {"region"});
  body.region = readRegion(region);
  using Kind = Region::Kind;
  const bool solid = body.region.kind == Kind::HalfSpace || body.region.kind == Kind::Box ||
                     body.region.kind == Kind::Sphere || body.region.kind == Kind::Cylinder;
  if (!solid)
    throw InputError(region.place("shape"), "a rigid body can't be a near-plane region or a shell",
                     "give a half-space, box, sphere or cylinder, or a surface");
  if (body.region.kind == Kind::Box && !((body.region.max - body.region.min).array() > 0).all())
    throw InputError(region.place("min"), "the rigid box has no thickness", "give \"max\" above \"min\" in x, y and z");
}

void checkName(const TomlTable& table, const RigidSpec& body, const std::vector<RigidSpec>& bodies,
               const std::vector<BoundarySpec>& boundaries) {
  const auto refuse = [&](const std::string& problem, const char* advice) {
    throw InputError(table.has("name") ? table.place("name") : body.place, problem, advice);
  };
  if (body.name.empty() || body.name.find_first_of(",\"") != std::string::npos || body.name.starts_with("tool"))
    refuse("a rigid body is called " + inQuotes(body.name),
           "give a name without commas and quotes that does not begin with \"tool\"");
  const auto taken = [&](const auto& other) { return other.name == body.name; };
  if (std::any_of(bodies.begin(), bodies.end(), taken) || std::any_of(boundaries.begin(), boundaries.end(), taken))
    refuse("the name " + inQuotes(body.name) + " is taken",
           "give each [[rigid]], [[fixed]] and [[prescribed]] a name of its own");
}

RigidSpec readRigid(const TomlTable& table, const std::filesystem::path& folder, std::size_t number) {
  RigidSpec body;
  body.place = table.place();
  body.name = "rigid " + std::to_string(number);
  table.readName("name", body.name);
  if (table.has("region") == table.has("surface"))
    throw InputError(body.place, table.has("region") ? "both \"region\" and \"surface\"" : "neither region nor surface",
                     "give region = { shape = \"half-space\", ... }, or surface = \"file.obj\" with a unit");
  if (table.has("region")) {
    readSolid(table, body);
  } else {
    body.encloses = table.readChoice("side", 0) == 1;
    readSurface(table, "surface", folder, body);
    readOpenings(table, body);
  }
  table.read("friction", body.friction);
  if (std::any_of(motion_keys.begin(), motion_keys.end(), [&](const char* key) { return table.has(key); }))
    body.motion = motionOf(readMotion(table));
  return body;
}

}  // namespace

std::vector<RigidSpec> readRigidBodies(const TomlTable& top, const std::filesystem::path& folder,
                                       const std::vector<BoundarySpec>& boundaries) {
  std::vector<RigidSpec> bodies;
  const auto add = [&](const TomlTable& table, RigidSpec body) {
    checkName(table, body, bodies, boundaries);
    if (bodies.size() == max_rigid_bodies)
      throw InputError(body.place, "more than " + std::to_string(max_rigid_bodies) + " rigid bodies",
                       "leave some out, or join them in one surface");
    bodies.push_back(std::move(body));
  };
  if (top.has("skull")) add(top, readSkull(top.table("skull", {"skull"}), folder));
  std::size_t number = 0;
  for (const TomlTable& table : top.tables("rigid", {"rigid"})) add(table, readRigid(table, folder, ++number));
  return bodies;
}

}  // namespace palpate
