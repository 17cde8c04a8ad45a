#include "io/scene_organs.h"

#include <algorithm>
#include <numbers>
#include <string>

#include "contact/skin_contact.h"
#include "io/scene_materials.h"

namespace palpate {
namespace {

void readOrgan(const TomlTable& organ, const std::filesystem::path& folder, OrganSpec& spec) {
  spec.place = organ.place();
  organ.readName("name", spec.name);
  organ.read("colour", spec.colour);
  organ.read("position", spec.position);
  organ.read("friction", spec.friction);
  if (organ.has("axis") || organ.has("angle")) {
    organ.require({"axis", "angle"}, "an organ that is turned");
    organ.readDirection("axis", spec.axis);
    double degrees = 0;
    organ.read("angle", degrees);
    spec.angle = degrees * std::numbers::pi / 180;
  }
  if (organ.has("surface") == organ.has("solid")) {
    throw InputError(organ.place("solid"),
                     organ.has("solid") ? "both \"surface\" and \"solid\"" : "neither \"surface\" nor \"solid\"",
                     "give surface = \"file.obj\" with a unit, or solid = \"box\", \"cylinder\" or \"ellipsoid\"");
  }
  if (organ.has("surface")) {
    organ.forbid({"size", "radius", "height", "semi_axes", "upper_half"}, "to a surface file");
    std::string file;
    organ.read("surface", file);
    spec.surface_file = existingFile(organ, "surface", folder / file, "surface file");
    if (organ.has("unit") == organ.has("scale")) {
      throw InputError(organ.place(organ.has("unit") ? "unit" : "surface"),
                       organ.has("unit") ? "both \"unit\" and \"scale\"" : "the surface's unit is missing",
                       "add unit = \"mm\", \"cm\" or \"m\", or scale = the unit's length in m");
    }
    constexpr double units[] = {0.001, 0.01, 1.0};  // in the order of the key's choices
    if (organ.has("unit")) spec.surface_scale = units[organ.readChoice("unit", 2)];
    organ.read("scale", spec.surface_scale);
    organ.read("repair", spec.repair_surface);
    return;
  }
  organ.forbid({"unit", "scale", "repair"}, "to a solid, which is given in m");
  switch (organ.readChoice("solid", 0)) {
    case 0:
      spec.solid = OrganSpec::Solid::Box;
      organ.require({"size"}, "a box");
      organ.forbid({"radius", "height", "semi_axes", "upper_half"}, "to a box");
      break;
    case 1:
      spec.solid = OrganSpec::Solid::Cylinder;
      organ.require({"radius", "height"}, "a cylinder");
      organ.forbid({"size", "semi_axes", "upper_half"}, "to a cylinder");
      break;
    default:
      spec.solid = OrganSpec::Solid::Ellipsoid;
      organ.require({"semi_axes"}, "an ellipsoid");
      organ.forbid({"size", "radius", "height"}, "to an ellipsoid");
  }
  organ.read("size", spec.size);
  organ.read("radius", spec.radius);
  organ.read("height", spec.height);
  organ.read("semi_axes", spec.semi_axes);
  organ.read("upper_half", spec.upper_half);
}

/// No two have the same name, by which materials and regions say whose they are.
void checkNames(const std::vector<OrganSpec>& organs) {
  for (std::size_t k = 0; k < organs.size(); ++k)
    for (std::size_t j = 0; j < k; ++j)
      if (organs[j].name == organs[k].name)
        throw InputError(organs[k].place, "a second organ has the name " + inQuotes(organs[k].name),
                         "give each [[organ]] a name of its own");
}

}  // namespace

void readOrgans(const TomlTable& top, const std::filesystem::path& folder, Scene& scene) {
  std::vector<OrganSpec> organs;
  if (!top.isList("organ")) {
    readOrgan(top.table("organ", {"organ"}), folder, organs.emplace_back());
  } else {
    for (const TomlTable& entry : top.tables("organ", {"organ"})) {
      if (organs.size() == std::size_t{max_organs})
        throw InputError(entry.place(), "more than " + std::to_string(max_organs) + " organs", "leave the others out");
      OrganSpec& organ = organs.emplace_back();
      organ.name = "organ " + std::to_string(organs.size());
      readOrgan(entry, folder, organ);
    }
    checkNames(organs);
  }
  scene.organs = std::move(organs);
}

int organNamed(const TomlTable& table, const Scene& scene) {
  if (!table.has("organ")) return -1;
  std::string name, all;
  table.readName("organ", name);
  const std::vector<OrganSpec>& organs = scene.organs;
  for (std::size_t k = 0; k < organs.size(); ++k) {
    if (organs[k].name == name) return static_cast<int>(k);
    all += (k == 0 ? "" : ", ") + inQuotes(organs[k].name);
  }
  throw InputError(table.place("organ"), "no organ has the name " + inQuotes(name), "there are " + all);
}

void checkMaterials(const Scene& scene) {
  const std::vector<OrganSpec>& organs = scene.organs;
  for (std::size_t k = 0; k < organs.size(); ++k)
    if (std::none_of(scene.materials.begin(), scene.materials.end(), [&](const MaterialSpec& m) {
          return m.everywhere && (m.organ < 0 || m.organ == static_cast<int>(k));
        }))
      throw InputError(organs[k].place, "the organ " + inQuotes(organs[k].name) + " has no material",
                       "add [[material]] with organ = " + inQuotes(organs[k].name) + " and no region");
}

}  // namespace palpate
