#include "io/key_spec.h"

namespace palpate {

namespace {

std::string choicesText(std::string choices) {
  for (std::size_t at = 0; (at = choices.find('|', at)) != std::string::npos; at += 4) choices.replace(at, 1, " or ");
  return choices;
}

}  // namespace

std::string typeText(KeySpec::Type type) {
  switch (type) {
    case KeySpec::Type::Text:
      return "text";
    case KeySpec::Type::Number:
      return "number";
    case KeySpec::Type::Integer:
      return "whole number";
    case KeySpec::Type::Boolean:
      return "true or false";
    case KeySpec::Type::Vector:
      return "3 numbers";
    case KeySpec::Type::Plane:
      return "2 numbers";
    case KeySpec::Type::Numbers:
      return "list of numbers";
    case KeySpec::Type::Curve:
      return "list of pairs of numbers";
    case KeySpec::Type::Axes:
      return "list of axes";
    case KeySpec::Type::Table:
      return "table";
    case KeySpec::Type::Tables:
      return "list of tables";
  }
  return "";
}

KeySpec keySpec(const char* table, const Parameter& parameter) {
  constexpr KeySpec::Type types[] = {KeySpec::Type::Number, KeySpec::Type::Numbers, KeySpec::Type::Curve,
                                     KeySpec::Type::Vector};
  return {table,
          parameter.name,
          types[static_cast<int>(parameter.type)],
          parameter.unit,
          parameter.isRequired() ? KeySpec::required : parameter.fallback,
          parameter.range,
          "",
          parameter.text};
}

std::string keyReference(std::span<const KeySpec> keys, const std::string& table) {
  std::string text = "| key | value | unit | default | allowed | meaning |\n|---|---|---|---|---|---|\n";
  for (const KeySpec& key : keys) {
    if (key.table != table) continue;
    const std::string fallback = key.fallback;
    const bool is_word = fallback.empty() || fallback == KeySpec::required || fallback == KeySpec::depends;
    text += std::string("| `") + key.name + "` | " + typeText(key.type) + " | " + key.unit + " | " +
            (is_word ? fallback : "`" + fallback + "`") + " | " +
            (*key.choices != '\0' ? choicesText(key.choices) : key.range.text()) + " | " + key.meaning + " |\n";
  }
  return text;
}

}  // namespace palpate
