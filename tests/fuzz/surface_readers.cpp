#include <algorithm>
#include <cstdint>

#include "discretization/surface/solids.h"
#include "fuzz/reader.h"
#include "io/obj_parser.h"
#include "io/stl_parser.h"
#include "io/surface_file.h"

namespace palpate::fuzz {

namespace {

constexpr const char* cube_obj = R"(# a unit cube of quads
mtllib cube.mtl
o cube
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
vn 0 0 1
vt 0 0
s off
f 4/1/1 3/1/1 2/1/1 1/1/1
f 5//1 6//1 7//1 8//1
f 1 2 6 5
f 2 3 7 6
f 3 4 8 \
 7
f -5 -8 -4 -1
)";

constexpr const char* tetrahedron_stl = R"(solid made by hand
facet normal 0 0 -1
outer loop
vertex 0 0 0
vertex 0 1 0
vertex 1 0 0
endloop
endfacet
facet normal 0 -1 0
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 0 1
endloop
endfacet
facet normal -1 0 0
outer loop
vertex 0 0 0
vertex 0 0 1
vertex 0 1 0
endloop
endfacet
facet normal nan 1 1
outer loop
vertex 1 0 0
vertex 0 1 0
vertex 0 0 1
endloop
endfacet
endsolid made by hand
)";

std::string binaryStl(const TriangleSurface& s) {
  std::string bytes = "solid";  // binary files, too, begin so
  bytes.resize(80, ' ');
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

std::vector<std::string> objSeeds() {
  return {cube_obj,
          "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
          "f 1 3 2\r\nf 1 2 4\r\nf 1 4 3\r\nf 2 3 4\r\n"};
}
std::vector<std::string> stlSeeds() { return {tetrahedron_stl, binaryStl(boxSurface({1, 1, 1}, 1))}; }

void holdSurface(const SurfaceFile& file) {
  const auto& [vertices, triangles] = file.surface;
  const auto& [name, vertex_line, triangle_line] = file.source;
  hold(!triangles.empty(), "no faces");
  hold(std::all_of(vertices.begin(), vertices.end(), [](const Vec3& x) { return x.allFinite(); }),
       "a vertex is not finite");
  for (const auto& triangle : triangles)
    for (const int v : triangle)
      hold(v >= 0 && static_cast<std::size_t>(v) < vertices.size(), "a face has a vertex that is not there");
  hold(vertex_line.empty() || vertex_line.size() == vertices.size(), "lines and vertices differ in number");
  hold(triangle_line.empty() || triangle_line.size() == triangles.size(), "lines and faces differ in number");
}

/// Joining and checking cost more than reading: on small inputs only.
void readSurfaceFrom(const std::string& bytes, SurfaceFile (*parse)(const std::string&, const std::string&),
                     const char* name) {
  holdSurface(parse(bytes, name));
  if (bytes.size() > 20'000) return;
  const SurfaceFile file = surfaceFrom(bytes, name);
  holdSurface(file);
  checkSurface(file.surface, file.source);
}

}  // namespace

const Reader obj_reader = {"obj", objSeeds,
                           [](const std::string& bytes) { readSurfaceFrom(bytes, parseObj, "input.obj"); }};
const Reader stl_reader = {"stl", stlSeeds,
                           [](const std::string& bytes) { readSurfaceFrom(bytes, parseStl, "input.stl"); }};

}  // namespace palpate::fuzz
