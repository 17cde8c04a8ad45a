#pragma once

#include <limits>
#include <span>
#include <string>

namespace palpate {

/// What a number may be.
struct ValueRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_excluded = false, high_excluded = false;

  bool contains(double value) const {
    return (low_excluded ? value > low : value >= low) && (high_excluded ? value < high : value <= high);
  }
  std::string text() const;  // "> 0", "0 .. 1", "0 .. < 0.5"; empty where anything goes
};

constexpr ValueRange anyNumber() { return {}; }
constexpr ValueRange above(double low) { return {low, std::numeric_limits<double>::infinity(), true, false}; }
constexpr ValueRange atLeast(double low) { return {low, std::numeric_limits<double>::infinity(), false, false}; }
constexpr ValueRange between(double low, double high) { return {low, high, false, false}; }
constexpr ValueRange aboveUpTo(double low, double high) { return {low, high, true, false}; }

/// One key of a TOML file of ours: the parser checks by it and the reference is printed from it,
/// so that the two can't differ.
struct KeySpec {
  enum class Type { Text, Number, Integer, Boolean, Vector, Plane, Numbers, Curve, Axes, Table, Tables };

  const char* table;  // the table or group it belongs to, "" for the file's top level
  const char* name;
  Type type;
  const char* unit;      // "m", "Pa"; "" for none
  const char* fallback;  // the default in TOML; "" where there is none; `required` or `depends` otherwise
  ValueRange range;      // of numbers, of a vector's components
  const char* choices;   // "a|b|c": the only values; "" for any
  const char* meaning;   // one sentence, Markdown

  static constexpr const char* required = "required";
  /// Required or without meaning, depending on other keys; `meaning` says on which.
  static constexpr const char* depends = "depends";
};

/// A Markdown table of the keys of one table or group.
std::string keyReference(std::span<const KeySpec> keys, const std::string& table);

/// "number", "3 numbers", ...
std::string typeText(KeySpec::Type type);

}  // namespace palpate
