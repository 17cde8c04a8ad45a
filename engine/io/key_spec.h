#pragma once

#include <span>
#include <string>

#include "base/parameter.h"

namespace palpate {

/// One key of a TOML file of ours: the parser checks by it and the reference is printed from it,
/// so that the two can't differ.
struct KeySpec {
  /// Whether a preparation (model/preparation.h) depends on the key, so that one that was kept no longer serves
  /// where the key is changed. What is not marked does: a key that nobody thought of costs a set-up, never a wrong
  /// model.
  enum class SetUp { Always, WithMassScaling, Never };
  enum class Type { Text, Number, Integer, Boolean, Vector, Plane, Numbers, Curve, Axes, Table, Tables };

  const char* table;  // the table or group it belongs to, "" for the file's top level
  const char* name;
  Type type;
  const char* unit;      // "m", "Pa"; "" for none
  const char* fallback;  // the default in TOML; "" where there is none; `required` or `depends` otherwise
  ValueRange range;      // of numbers, of a vector's components
  const char* choices;   // "a|b|c": the only values; "" for any
  const char* meaning;   // one sentence, Markdown
  SetUp set_up = SetUp::Always;

  static constexpr const char* required = "required";
  /// Required or without meaning, depending on other keys; `meaning` says on which.
  static constexpr const char* depends = "depends";
};

/// The key of a parameter.
KeySpec keySpec(const char* table, const Parameter& parameter);

/// A Markdown table of the keys of one table or group.
std::string keyReference(std::span<const KeySpec> keys, const std::string& table);

/// "number", "3 numbers", ...
std::string typeText(KeySpec::Type type);

}  // namespace palpate
