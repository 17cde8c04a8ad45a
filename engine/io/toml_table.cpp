#include "io/toml_table.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "base/nearest_word.h"
#include "base/number_text.h"
#include "base/printable_text.h"
#include "io/toml_depth.h"

namespace palpate {

namespace {

std::string typeOf(const toml::node& node) {
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

std::vector<std::string> split(std::string_view choices) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= choices.size();) {
    const std::size_t end = std::min(choices.find('|', begin), choices.size());
    parts.emplace_back(choices.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

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

TomlTable::TomlTable(TomlFile& file, const toml::table& table, std::string path, std::vector<std::string> groups)
    : file_(&file), table_(&table), path_(std::move(path)), groups_(std::move(groups)) {
  place_ = placeOf(table.source());
  if (!path_.empty() && place_.line > 0) file.places.emplace(path_, place_);
  for (const auto& [key, node] : table) {
    const bool known = std::any_of(file.keys.begin(), file.keys.end(), [&](const KeySpec& spec) {
      return key.str() == spec.name && std::find(groups_.begin(), groups_.end(), spec.table) != groups_.end();
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

void TomlTable::wrongType(const KeySpec& key, const toml::node& node) const {
  std::string wanted = typeText(key.type);
  if (*key.choices != '\0') wanted += " (" + listed(split(key.choices), "or") + ")";
  if (*key.unit != '\0') wanted += std::string(" in ") + key.unit;
  throw InputError(placeOf(node.source()), "\"" + std::string(key.name) + "\" is " + typeOf(node), "give " + wanted);
}

double TomlTable::numberAt(const KeySpec& key, const toml::node& node, const std::string& what) const {
  double value = 0;
  if (const auto* floating = node.as_floating_point()) {
    value = floating->get();
  } else if (const auto* integer = node.as_integer()) {
    value = static_cast<double>(integer->get());
  } else {
    wrongType(key, node);
  }
  if (!std::isfinite(value)) {
    throw InputError(placeOf(node.source()), what + " is not finite", "give a finite number");
  }
  if (!key.range.contains(value)) {
    const std::string unit = *key.unit != '\0' ? std::string(" ") + key.unit : "";
    throw InputError(placeOf(node.source()), what + " = " + shortest(value) + unit + " is out of range",
                     "allowed is " + key.range.text() + unit);
  }
  return value;
}

std::vector<double> TomlTable::numbersAt(const KeySpec& key, const toml::node& node) const {
  const toml::array* array = node.as_array();
  if (array == nullptr) wrongType(key, node);
  const std::size_t wanted = key.type == KeySpec::Type::Vector  ? 3
                             : key.type == KeySpec::Type::Plane ? 2
                                                                : array->size();
  if (array->size() != wanted) {
    throw InputError(placeOf(node.source()),
                     "\"" + std::string(key.name) + "\" has " + std::to_string(array->size()) + " entries",
                     "give " + typeText(key.type) + ", like " + (wanted == 3 ? "[0.0, 0.0, 0.1]" : "[0.0, 0.1]"));
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < array->size(); ++i) {
    values.push_back(numberAt(key, *array->get(i), std::string(key.name) + "[" + std::to_string(i) + "]"));
  }
  return values;
}

void TomlTable::read(const std::string& key, double& value) const {
  if (const toml::node* node = find(key)) value = numberAt(spec(key), *node, "\"" + key + "\"");
}

std::int64_t TomlTable::integerAt(const KeySpec& key, const toml::node& node) const {
  const auto* integer = node.as_integer();
  if (integer == nullptr) wrongType(key, node);
  numberAt(key, node, "\"" + std::string(key.name) + "\"");  // its range
  const std::vector<std::string> choices = split(key.choices);
  if (*key.choices != '\0' &&
      std::find(choices.begin(), choices.end(), std::to_string(integer->get())) == choices.end()) {
    throw InputError(placeOf(node.source()),
                     "\"" + std::string(key.name) + "\" = " + std::to_string(integer->get()) + " is no choice",
                     "give " + listed(choices, "or"));
  }
  return integer->get();
}

void TomlTable::read(const std::string& key, int& value) const {
  if (const toml::node* node = find(key)) value = static_cast<int>(integerAt(spec(key), *node));
}

void TomlTable::read(const std::string& key, unsigned& value) const {
  if (const toml::node* node = find(key)) value = static_cast<unsigned>(integerAt(spec(key), *node));
}

void TomlTable::read(const std::string& key, bool& value) const {
  if (const toml::node* node = find(key)) {
    const auto* boolean = node->as_boolean();
    if (boolean == nullptr) wrongType(spec(key), *node);
    value = boolean->get();
  }
}

void TomlTable::read(const std::string& key, std::string& value) const {
  if (const toml::node* node = find(key)) {
    const auto* text = node->as_string();
    if (text == nullptr) wrongType(spec(key), *node);
    value = text->get();
  }
}

void TomlTable::readLengths(const std::string& key, double* values) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const std::vector<double> numbers = numbersAt(spec(key), *node);
  // Each number may be finite where the length is not: [1.7e308, 1.7e308, 0] divided by its length is zero.
  if (!std::isfinite(Eigen::Map<const Eigen::VectorXd>(numbers.data(), std::ssize(numbers)).stableNorm())) {
    throw InputError(placeOf(node->source()), "the length of \"" + key + "\" is more than a number can hold",
                     "give smaller numbers");
  }
  std::copy(numbers.begin(), numbers.end(), values);
}

void TomlTable::read(const std::string& key, Vec3& value) const { readLengths(key, value.data()); }

void TomlTable::read(const std::string& key, Eigen::Vector2d& value) const { readLengths(key, value.data()); }

void TomlTable::read(const std::string& key, std::vector<double>& value) const {
  if (const toml::node* node = find(key)) value = numbersAt(spec(key), *node);
}

void TomlTable::readName(const std::string& key, std::string& value) const {
  read(key, value);
  if (!has(key)) return;
  const std::string_view blanks = " \t";
  const bool trimmed =
      value.empty() || (blanks.find(value.front()) == blanks.npos && blanks.find(value.back()) == blanks.npos);
  if (printable(value) == value && trimmed) return;
  throw InputError(place(key), "\"" + key + "\" is " + inQuotes(value),
                   "give a name without line ends, control characters and blanks at its ends");
}

void TomlTable::readDirection(const std::string& key, Vec3& value) const {
  read(key, value);
  const double largest = value.cwiseAbs().maxCoeff();
  if (!(largest > 0)) throw InputError(place(key), "\"" + key + "\" is zero", "give a direction, like [0, 0, 1]");
  // Numbers with few bits left would round the length: [5e-324, 5e-324, 0] has 5e-324.
  if (largest < std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon()) value /= largest;
  value /= value.stableNorm();
}

std::pair<double, double> TomlTable::pairAt(const KeySpec& key, const toml::node& entry, const std::string& row,
                                            const char* advice) const {
  const toml::array* pair = entry.as_array();
  if (pair == nullptr || pair->size() != 2)
    throw InputError(placeOf(entry.source()), "\"" + row + "\" is not a pair of numbers", advice);
  return {numberAt(key, *pair->get(0), row + "[0]"), numberAt(key, *pair->get(1), row + "[1]")};
}

void TomlTable::readPairs(const std::string& key, std::vector<double>& values) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const toml::array* rows = node->as_array();
  if (rows == nullptr) wrongType(spec(key), *node);
  values.clear();
  for (const toml::node& entry : *rows) {
    const std::string row = key + "[" + std::to_string(values.size() / 2) + "]";
    const auto [first, second] = pairAt(spec(key), entry, row, "give a list of pairs, like [[0.3, 0.1], [0.2, 2.0]]");
    values.push_back(first);
    values.push_back(second);
  }
}

void TomlTable::readCurve(const std::string& key, std::vector<double>& times, std::vector<double>& values) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const toml::array* rows = node->as_array();
  if (rows == nullptr) wrongType(spec(key), *node);
  const char* advice = "give rows of time and value, like [[0.0, 0.0], [0.5, 1.0]]";
  if (rows->size() < 2) {
    throw InputError(placeOf(node->source()), "\"" + key + "\" has " + std::to_string(rows->size()) + " rows", advice);
  }
  times.clear();
  values.clear();
  for (const toml::node& entry : *rows) {
    const std::string row = key + "[" + std::to_string(times.size()) + "]";
    const auto [time, value] = pairAt(spec(key), entry, row, advice);
    // A start elsewhere would be a jump, which explicit time stepping can't follow.
    if (times.empty() && (time != 0 || value != 0)) {
      throw InputError(placeOf(entry.source()), "\"" + key + "\" does not start at [0.0, 0.0]", advice);
    }
    if (!times.empty() && !(time > times.back())) {
      throw InputError(placeOf(entry.source()), "the time of \"" + row + "\" is not later than that of the row before",
                       "rows stand in the order of their times");
    }
    times.push_back(time);
    values.push_back(value);
  }
}

void TomlTable::readAxes(const std::string& key, bool (&value)[3]) const {
  const toml::node* node = find(key);
  if (node == nullptr) return;
  const toml::array* array = node->as_array();
  if (array == nullptr) wrongType(spec(key), *node);
  const char* advice = "give a list of \"x\", \"y\" and \"z\", like [\"z\"]";
  if (array->empty()) throw InputError(placeOf(node->source()), "\"" + key + "\" is empty", advice);
  std::fill(std::begin(value), std::end(value), false);
  for (const toml::node& entry : *array) {
    const auto* text = entry.as_string();
    const std::string axis = text != nullptr ? text->get() : "";
    if (axis != "x" && axis != "y" && axis != "z") {
      throw InputError(placeOf(entry.source()), "\"" + key + "\" has an entry that is no axis", advice);
    }
    value[axis[0] - 'x'] = true;
  }
}

int TomlTable::readChoice(const std::string& key, int absent) const {
  const toml::node* node = find(key);
  if (node == nullptr) return absent;
  const auto* text = node->as_string();
  if (text == nullptr) wrongType(spec(key), *node);
  const std::vector<std::string> choices = split(spec(key).choices);
  const auto found = std::find(choices.begin(), choices.end(), text->get());
  if (found == choices.end()) {
    throw InputError(placeOf(node->source()), "\"" + key + "\" is " + inQuotes(text->get()),
                     "give " + listed(choices, "or"));
  }
  return static_cast<int>(found - choices.begin());
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

std::vector<TomlTable> TomlTable::tables(const std::string& key, std::vector<std::string> groups) const {
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

}  // namespace palpate
