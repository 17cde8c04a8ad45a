#pragma once

#include <cstdint>
#include <string>

#include "discretization/surface/triangle_surface.h"

namespace palpate::test {

/// The bytes of a binary STL file.
inline std::string binaryStl(const TriangleSurface& s, const std::string& title = "binary") {
  std::string bytes = title;
  bytes.resize(80, '\0');
  const auto put = [&](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(static_cast<std::uint32_t>(s.triangles.size()));
  for (const auto& triangle : s.triangles) {
    for (int k = 0; k < 3; ++k) put(0.0F);
    for (const int v : triangle)
      for (const double x : s.vertices[static_cast<std::size_t>(v)]) put(static_cast<float>(x));
    put(std::uint16_t{0});
  }
  return bytes;
}

}  // namespace palpate::test
