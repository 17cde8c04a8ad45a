#pragma once

#include <toml++/toml.h>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/input_error.h"
#include "base/types.h"
#include "io/key_spec.h"

namespace palpate {

/// More than any file of ours needs: a tool script with a keyframe for each of a million ticks.
constexpr std::uintmax_t max_toml_bytes = 64 << 20;

/// How many parts a dotted key or a table's name may have, and how many lists and inline tables may stand in one
/// another. Our keys have two and three; the parser below calls itself for each, and would use up its stack.
constexpr int max_toml_depth = 32;

/// Parses TOML text. Throws InputError with file, line and column where it is no TOML or nested too deep.
toml::table parseToml(const std::string& text, const std::string& file);

/// What all tables of one file share.
struct TomlFile {
  std::string name;
  std::span<const KeySpec> keys;
  std::map<std::string, SourceLocation> places;  // dotted key ("material[0].young") -> where it stands
  /// What was read of the keys that a preparation depends on, always or with mass scaling: dotted key -> its value.
  std::map<std::string, std::string> set_up{}, set_up_with_mass_scaling{};
  std::vector<std::string> files{};  // that its values name
};

/// A table of a TOML file, read by its key specifications. Each read checks type, range and choices and
/// throws InputError with file:line:column, what is wrong and what would be right. An absent key
/// leaves the target as it is, unless it is required.
class TomlTable {
 public:
  /// Refuses keys that none of `groups` knows, suggesting the nearest one that it does.
  /// @param path    "" for the file's top level, otherwise dotted, such as "material[0]"
  /// @param groups  the KeySpec tables whose keys may stand here
  TomlTable(TomlFile& file, const toml::table& table, std::string path, std::vector<std::string> groups);

  bool has(const std::string& key) const { return table_->contains(key); }

  /// Where the key stands; where it is absent, where the table does.
  SourceLocation place(const std::string& key) const;
  SourceLocation place() const { return place_; }

  void read(const std::string& key, double& value) const;
  void read(const std::string& key, int& value) const;
  void read(const std::string& key, unsigned& value) const;
  void read(const std::string& key, bool& value) const;
  void read(const std::string& key, std::string& value) const;
  void read(const std::string& key, Vec3& value) const;  // its length, too, must be finite
  void read(const std::string& key, Eigen::Vector2d& value) const;
  void read(const std::string& key, std::vector<double>& value) const;

  /// A text that goes into reports, recordings and results on one line: without line ends, other control characters
  /// and blanks at its ends.
  void readName(const std::string& key, std::string& value) const;

  /// A direction: made a unit vector; zero is refused.
  void readDirection(const std::string& key, Vec3& value) const;

  /// A list of [time, value]: at least two, times strictly ascending from 0, the first value 0.
  void readCurve(const std::string& key, std::vector<double>& times, std::vector<double>& values) const;

  /// A list of pairs of numbers, one after another.
  void readPairs(const std::string& key, std::vector<double>& values) const;

  /// A list of "x", "y", "z".
  void readAxes(const std::string& key, bool (&value)[3]) const;

  /// The position of the text among the key's choices; `absent` where the key is.
  int readChoice(const std::string& key, int absent) const;

  /// A table below this one; an empty one where it is absent and not required.
  TomlTable table(const std::string& key, std::vector<std::string> groups) const;

  /// Adds a file that a value names.
  void noteFile(std::string file) const { file_->files.push_back(std::move(file)); }

  /// Whether the key is there and is a list.
  bool isList(const std::string& key) const;

  /// The same table, in which the keys of other groups may stand. Refuses those that stand there.
  TomlTable within(std::vector<std::string> groups) const { return {*file_, *table_, path_, std::move(groups)}; }

  /// A list of tables ([[key]]).
  std::vector<TomlTable> tables(const std::string& key, const std::vector<std::string>& groups) const;

  /// Throws if a key is missing: "`because` needs it".
  void require(std::initializer_list<const char*> keys, const std::string& because) const;

  /// Throws if a key is there: "it means nothing `because`".
  void forbid(std::initializer_list<const char*> keys, const std::string& because) const;
  /// The same for the parameters of others that are not one's own.
  void forbidForeign(std::span<const Parameter> others, std::span<const Parameter> own,
                     const std::string& because) const;

 private:
  const KeySpec& spec(const std::string& key) const;
  const toml::node* find(const std::string& key) const;         // null where absent and allowed to be
  void note(const KeySpec& key, const toml::node& node) const;  // in the file's set_up
  double numberAt(const KeySpec& key, const toml::node& node, const std::string& what) const;
  /// An entry of a list of pairs. @param row  its name
  std::pair<double, double> pairAt(const KeySpec& key, const toml::node& entry, const std::string& row,
                                   const char* advice) const;
  std::vector<double> numbersAt(const KeySpec& key, const toml::node& node) const;
  void readLengths(const std::string& key, double* values) const;  // of a vector or plane; untouched where absent
  std::int64_t integerAt(const KeySpec& key, const toml::node& node) const;
  static std::string typeOf(const toml::node& node);  // "a whole number" for messages
  [[noreturn]] void wrongType(const KeySpec& key, const toml::node& node) const;
  [[noreturn]] void unknownKey(const toml::key& key) const;
  SourceLocation placeOf(const toml::source_region& source) const;
  std::string dotted(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  std::string title() const;  // "[dynamics]" for messages

  TomlFile* file_;
  const toml::table* table_;
  std::string path_;
  std::vector<std::string> groups_;
  SourceLocation place_;
};

}  // namespace palpate
