#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <type_traits>
#include <vector>

#include "base/types.h"

namespace palpate::tools {

inline nlohmann::json vectorsToJson(const std::vector<Vec3>& vectors) {
  nlohmann::json json = nlohmann::json::array();
  for (const Vec3& v : vectors) json.push_back({v.x(), v.y(), v.z()});
  return json;
}

/// Throws nlohmann::json::exception where it is none.
inline std::vector<Vec3> vectorsFromJson(const nlohmann::json& json) {
  std::vector<Vec3> vectors;
  for (const auto& v : json) vectors.emplace_back(v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>());
  return vectors;
}

/// A value as it was written; a number that was none (NaN) stands there as null.
/// Throws nlohmann::json::exception where it is of another type.
template <class Json, class T>
void readJson(const Json& json, T& value) {
  if constexpr (std::is_same_v<T, double>)
    value = json.is_null() ? NAN : json.template get<double>();
  else
    json.get_to(value);
}

}  // namespace palpate::tools
