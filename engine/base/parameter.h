#pragma once

#include <limits>
#include <string>

namespace palpate {

/// What a number may be.
struct ValueRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_excluded = false, high_excluded = false;

  constexpr bool contains(double value) const {
    return (low_excluded ? value > low : value >= low) && (high_excluded ? value < high : value <= high);
  }
  constexpr bool operator==(const ValueRange&) const = default;
  std::string text() const;  // "> 0", "0 .. 1", "0 .. < 0.5"; empty where anything goes
};

constexpr ValueRange anyNumber() { return {}; }
constexpr ValueRange above(double low) { return {low, std::numeric_limits<double>::infinity(), true, false}; }
constexpr ValueRange atLeast(double low) { return {low, std::numeric_limits<double>::infinity(), false, false}; }
constexpr ValueRange between(double low, double high) { return {low, high, false, false}; }
constexpr ValueRange aboveUpTo(double low, double high) { return {low, high, true, false}; }

/// A number, a vector, or a list of numbers or pairs of them, that describes a thing such as a material law or a tool:
/// stated once, beside the formulas that use it. Scene keys, their reference, hashes, recordings and panels follow from
/// it.
struct Parameter {
  enum class Type { Number, Numbers, Pairs, Vector };  // pairs one after another, or none; a vector has three numbers

  const char* name;   // the scene's key: "young"
  const char* label;  // in a panel: "Young's modulus E"; of a list a symbol that gets the entry's number
  Type type;
  const char* unit;      // "m", "Pa"; "" for none
  const char* fallback;  // the default as text; "" where the scene must say it
  ValueRange range;      // of each number
  const char* text;      // what it means: a sentence or two, Markdown

  constexpr bool isRequired() const { return *fallback == '\0'; }
  double fallbackValue() const;  // of a number with a default
};

}  // namespace palpate
