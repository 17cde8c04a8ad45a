#include "io/scene_materials.h"

#include <algorithm>
#include <map>
#include <memory>
#include <span>
#include <string_view>

#include "base/number_text.h"
#include "base/printable_text.h"
#include "imaging/membership.h"
#include "io/image_file.h"
#include "io/scene_boundary.h"
#include "mechanics/materials/material_law.h"

namespace palpate {

std::string existingFile(const TomlTable& table, const std::string& key, const std::filesystem::path& path,
                         const std::string& what) {
  const std::filesystem::path file = path.lexically_normal();
  if (std::error_code error; !std::filesystem::is_regular_file(file, error)) {
    throw InputError(table.place(key), "there is no " + what + " " + file.string(),
                     "the path starts from the scene file's folder");
  }
  table.noteFile(file.string());
  return file.string();
}

namespace {

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
  for (const MaterialLaw& other : laws) table.forbidForeign(other.parameters, law.parameters, "to " + one);
  Material material = Material::of(law.name);
  std::map<std::string, std::vector<double>> lists;
  const auto readNumber = [&](const Parameter& p) {
    double value = 0;
    table.read(p.name, value);
    if (table.has(p.name)) material.set(p.name, value);
  };
  for (const Parameter& p : law.parameters) {
    if (p.type == Parameter::Type::Numbers) {
      table.read(p.name, lists[p.name]);
    } else if (p.type == Parameter::Type::Vector) {
      Vec3 vector;
      table.read(p.name, vector);
      material.set(p.name, {vector.data(), 3});
    } else {
      readNumber(p);
    }
  }
  for (const CommonMaterialParameter& common : commonMaterialParameters())
    if (common.is_key) readNumber(common.parameter);
  checkTermCounts(table, lists, law.parameters);
  for (const auto& [name, values] : lists) material.set(name, values);
  readRelaxation(table, material);
  if (const auto problem = law.check(material))
    throw InputError(table.place(problem->parameter), problem->problem, problem->advice);
  if (!isOfMatter(material))
    throw InputError(table.place(law.parameters.front().name),
                     format("a shear modulus of %.3g Pa is that of no matter", material.shear_modulus),
                     "give moduli in Pa: a liver has a young of some 3000");
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
  constexpr float overshoot = 0.2F;  // of resampling by splines: taken as 0 and 1
  const auto [least, most] = std::minmax_element(membership->share.value.begin(), membership->share.value.end());
  if (*least < -overshoot || *most > 1 + overshoot)
    throw InputError(table.place("membership"), format("values from %.3g to %.3g", *least, *most),
                     "a membership is a share, 0 to 1: divide one in percent, or of 0 to 255");
  if (!table.has("mask")) return membership;
  membership->mask = maskOf(readImage(file("mask"), {}, table.place("mask")));
  if (!sameGrid(membership->mask->grid, membership->share.grid))
    throw InputError(table.place("mask"), "the mask's voxels are not those of the membership",
                     "resample it to the membership's");
  return membership;
}

}  // namespace

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
  if (!first && !table.has("region") && !table.has("organ")) {
    throw InputError(table.place(), "this material has no region and would replace all before it",
                     "add region = { shape = ..., ... }, or the organ that it is of");
  }
  material.everywhere = !table.has("region");
  if (!material.everywhere) material.region = readRegion(table.table("region", {"region"}));
}

}  // namespace palpate
