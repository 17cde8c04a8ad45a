#pragma once

#include <cstdio>
#include <string>

#include "simulation/scene.h"

namespace palpate {

// Words of the messages that refuse a scene.

inline std::string number(double a) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", a);
  return text;
}

inline std::string coordinates(const Vec3& x) {
  return "(" + number(x[0]) + ", " + number(x[1]) + ", " + number(x[2]) + ") m";
}

/// Where a key stands, or the scene file where it is left out.
inline SourceLocation placeOf(const Scene& scene, const std::string& key) {
  const auto it = scene.places.find(key);
  return it == scene.places.end() ? scene.place : it->second;
}

}  // namespace palpate
