#pragma once

#include <string>

#include "base/number_text.h"
#include "scene/scene.h"

namespace palpate {

// Words of the messages that refuse a scene.

inline std::string number(double a) { return format("%.3g", a); }

inline std::string coordinates(const Vec3& x) { return format("(%.3g, %.3g, %.3g) m", x[0], x[1], x[2]); }

/// Where a key stands, or the scene file where it is left out.
inline SourceLocation placeOf(const Scene& scene, const std::string& key) {
  const auto it = scene.places.find(key);
  return it == scene.places.end() ? scene.place : it->second;
}

}  // namespace palpate
