#include "io/toml_table.h"

#include <algorithm>
#include <stdexcept>
#include <string_view>

#include "base/nearest_word.h"
#include "base/number_text.h"
#include "base/printable_text.h"
#include "io/toml_depth.h"

namespace palpate {

namespace {

/// What people call a key elsewhere.
std::string usualNameOf(const std::string& word) {
  static const std::map<std::string, std::string> names = {{"E", "young"},
                                                           {"youngs_modulus", "young"},
                                                           {"nu", "poisson"},
                                                           {"poissons_ratio", "poisson"},
                                                           {"rho", "density"},
                                                           {"dt", "time_step"},
                                                           {"color", "colour"},
                                                           {"h", "spacing"},
                                                           {"center", "centre"},
                                                           {"file", "surface"},
                                                           {"mesh", "surface"},
                                                           {"velocity", "max_speed"},
                                                           {"speed", "max_speed"},
                                                           {"d1", "D1"},
                                                           {"D", "D1"},
                                                           {"rate_hz", "rate"},
                                                           {"t", "time"},
                                                           {"depth", "advance"},
                                                           {"frequency", "rate"},
                                                           {"type", "shape"}};
  const auto found = names.find(word);
  return found == names.end() ? "" : found->second;
}

/// A value as text; equal texts, equal values.
std::string valueText(const toml::node& node) {
  if (const auto* number = node.as_floating_point()) return shortest(number->get());
  if (const auto* integer = node.as_integer()) return shortest(static_cast<double>(integer->get()));
  if (const auto* boolean = node.as_boolean()) return boolean->get() ? "true" : "false";
  if (const auto* text = node.as_string()) return inQuotes(text->get());
  std::string list = "[";
  if (const auto* array = node.as_array())
    for (const toml::node& entry : *array) list += valueText(entry) + ",";
  return list + "]";
}

}  // namespace

toml::table parseToml(const std::string& text, const std::string& file) {
  checkTomlDepth(text, file);
  try {
    return toml::parse(std::string_view(text), std::string_view(file));
  } catch (const toml::parse_error& error) {
    const auto at = error.source().begin;
    throw InputError({file, static_cast<int>(at.line), static_cast<int>(at.column)},
                     "not valid TOML: " + std::string(error.description()),
                     "a line reads key = value, a table [name], a list entry [[name]]");
  }
}

std::string TomlTable::typeOf(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::string:
      return "text";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::table:
      return "a table";
    default:
      return "a date or time";
  }
}

TomlTable::TomlTable(TomlFile& file, const toml::table& table, std::string path, std::vector<std::string> groups)
    : file_(&file), table_(&table), path_(std::move(path)), groups_(std::move(groups)) {
  place_ = placeOf(table.source());
  if (!path_.empty() && place_.line > 0) file.places.emplace(path_, place_);
  for (const auto& [key, node] : table) {
    const bool known = std::any_of(file.keys.begin(), file.keys.end(), [&, name = key.str()](const KeySpec& spec) {
      return name == spec.name && std::find(groups_.begin(), groups_.end(), spec.table) != groups_.end();
    });
    if (!known) unknownKey(key);
    file.places.insert_or_assign(dotted(std::string(key.str())), placeOf(key.source()));
  }
}

SourceLocation TomlTable::placeOf(const toml::source_region& source) const {
  return {file_->name, static_cast<int>(source.begin.line), static_cast<int>(source.begin.column)};
}

SourceLocation TomlTable::place(const std::string& key) const {
  const auto found = file_->places.find(dotted(key));
  return found != file_->places.end() ? found->second : place_;
}

std::string TomlTable::title() const {
  if (path_.empty()) return "the file's top level";
  const std::size_t bracket = path_.find('[');
  return bracket == std::string::npos ? "[" + path_ + "]" : "[[" + path_.substr(0, bracket) + "]]";
}

void TomlTable::unknownKey(const toml::key& key) const {
  const std::string word(key.str());
  std::vector<std::string> here;
  std::string elsewhere;
  for (const KeySpec& spec : file_->keys) {
    if (std::find(groups_.begin(), groups_.end(), spec.table) != groups_.end())
      here.emplace_back(spec.name);
    else if (word == spec.name && elsewhere.empty())
      elsewhere = spec.table;
  }
  const std::string usual = usualNameOf(word);
  const std::string nearest =
      std::find(here.begin(), here.end(), usual) != here.end() ? usual : nearestWord(word, here);
  std::string advice;
  if (!nearest.empty()) {
    advice = "did you mean \"" + nearest + "\"?";
  } else if (!elsewhere.empty()) {
    advice = "\"" + word + "\" belongs to " + elsewhere;
  } else {
    advice = "known here: " + listed(here, "and");
  }
  throw InputError(placeOf(key.source()), "unknown key " + inQuotes(word) + " in " + title(), advice);
}

const KeySpec& TomlTable::spec(const std::string& key) const {
  for (const KeySpec& spec : file_->keys) {
    if (key == spec.name && std::find(groups_.begin(), groups_.end(), spec.table) != groups_.end()) return spec;
  }
  throw std::logic_error("no specification of the key " + dotted(key));
}

const toml::node* TomlTable::find(const std::string& key) const {
  const KeySpec& specification = spec(key);
  const toml::node* node = table_->get(key);
  if (node == nullptr && std::string_view(specification.fallback) == KeySpec::required) {
    const bool tables = specification.type == KeySpec::Type::Tables;
    const bool table = specification.type == KeySpec::Type::Table;
    throw InputError(place_, "the key \"" + key + "\" is missing in " + title(),
                     tables  ? "add a [[" + key + "]]"
                     : table ? "add an [" + key + "]"
                             : "add " + key + " = " + typeText(specification.type) +
                                   (*specification.unit != '\0' ? std::string(" in ") + specification.unit : ""));
  }
  if (node != nullptr) note(specification, *node);
  return node;
}

void TomlTable::note(const KeySpec& key, const toml::node& node) const {
  const bool holds_keys = key.type == KeySpec::Type::Table || key.type == KeySpec::Type::Tables;  // noted themselves
  if (holds_keys || key.set_up == KeySpec::SetUp::Never) return;
  auto& values = key.set_up == KeySpec::SetUp::Always ? file_->set_up : file_->set_up_with_mass_scaling;
  values[dotted(key.name)] = valueText(node);
}

TomlTable TomlTable::table(const std::string& key, std::vector<std::string> groups) const {
  static const toml::table empty;
  const toml::node* node = find(key);
  if (node == nullptr) return {*file_, empty, dotted(key), std::move(groups)};
  const toml::table* below = node->as_table();
  if (below == nullptr) {
    throw InputError(placeOf(node->source()), "\"" + key + "\" is " + typeOf(*node),
                     "write it as a table: [" + dotted(key) + "]");
  }
  return {*file_, *below, dotted(key), std::move(groups)};
}

bool TomlTable::isList(const std::string& key) const {
  const toml::node* node = table_->get(key);
  return node != nullptr && node->is_array();
}

std::vector<TomlTable> TomlTable::tables(const std::string& key, const std::vector<std::string>& groups) const {
  std::vector<TomlTable> result;
  const toml::node* node = find(key);
  if (node == nullptr) return result;
  const std::string advice = "write each entry as [[" + dotted(key) + "]]";
  const toml::array* array = node->as_array();
  if (array == nullptr) throw InputError(placeOf(node->source()), "\"" + key + "\" is " + typeOf(*node), advice);
  if (array->empty() && std::string_view(spec(key).fallback) == KeySpec::required) {
    throw InputError(placeOf(node->source()), "\"" + key + "\" is empty", advice);
  }
  for (std::size_t i = 0; i < array->size(); ++i) {
    const toml::table* entry = array->get(i)->as_table();
    if (entry == nullptr) {
      throw InputError(placeOf(array->get(i)->source()),
                       "\"" + key + "\" has an entry that is " + typeOf(*array->get(i)), advice);
    }
    result.emplace_back(*file_, *entry, dotted(key) + "[" + std::to_string(i) + "]", groups);
  }
  return result;
}

void TomlTable::require(std::initializer_list<const char*> keys, const std::string& because) const {
  for (const char* key : keys) {
    if (!has(key)) throw InputError(place_, "the key \"" + std::string(key) + "\" is missing", because + " needs it");
  }
}

void TomlTable::forbid(std::initializer_list<const char*> keys, const std::string& because) const {
  for (const char* key : keys) {
    if (has(key)) throw InputError(place(key), "\"" + std::string(key) + "\" means nothing " + because, "remove it");
  }
}

void TomlTable::forbidForeign(std::span<const Parameter> others, std::span<const Parameter> own,
                              const std::string& because) const {
  for (const Parameter& p : others)
    if (std::none_of(own.begin(), own.end(),
                     [&](const Parameter& mine) { return std::string_view(mine.name) == p.name; }))
      forbid({p.name}, because);
}

}  // namespace palpate
