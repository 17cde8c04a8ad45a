#include <algorithm>
#include <cstdint>
#include <utility>

#include "base/input_error.h"
#include "discretization/surface/solids.h"
#include "fuzz/reader.h"
#include "imaging/repair_surface.h"
#include "io/obj_parser.h"
#include "io/off_parser.h"
#include "io/ply_parser.h"
#include "io/stl_parser.h"
#include "io/surface_file.h"
#include "io/vtk_surface_parser.h"
#include "support/binary_stl.h"

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

constexpr const char* tetrahedron_ply = R"(ply
format ascii 1.0
comment with what a scanner adds
element vertex 4
property float x
property float y
property float z
property uchar red
element face 4
property list uchar int vertex_indices
end_header
0 0 0 255
1 0 0 255
0 1 0 255
0 0 1 255
3 0 2 1
3 0 1 3
3 0 3 2
3 1 2 3
)";

std::string binaryPly(const TriangleSurface& s, bool big_endian) {
  std::string bytes = std::string("ply\nformat binary_") + (big_endian ? "big" : "little") +
                      "_endian 1.0\nelement vertex " + std::to_string(s.vertices.size()) +
                      "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                      std::to_string(s.triangles.size()) + "\nproperty list uchar int vertex_index\nend_header\n";
  const auto put = [&](const auto& value) {
    std::string raw(reinterpret_cast<const char*>(&value), sizeof value);
    if (big_endian) std::reverse(raw.begin(), raw.end());
    bytes += raw;
  };
  for (const Vec3& x : s.vertices)
    for (const double c : x) put(c);
  for (const auto& triangle : s.triangles) {
    put(std::uint8_t{3});
    for (const int v : triangle) put(v);
  }
  return bytes;
}

std::vector<std::string> plySeeds() {
  const TriangleSurface box = boxSurface({1, 1, 1}, 1);
  return {tetrahedron_ply, binaryPly(box, false), binaryPly(box, true)};
}

std::vector<std::string> offSeeds() {
  return {
      "OFF\n# a tetrahedron\n4 4 6\n0 0 0\n1 0 0\n0 1 0 # here\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2 255 0 0\n3 1 2 3\n",
      "COFF 8 6 12\n0 0 0 1 1 1\n1 0 0 1 1 1\n1 1 0 1 1 1\n0 1 0 1 1 1\n0 0 1 1 1 1\n1 0 1 1 1 1\n1 1 1 1 1 1\n"
      "0 1 1 1 1 1\n4 3 2 1 0\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n"};
}

std::vector<std::string> vtkSeeds() {
  const std::string head = "# vtk DataFile Version 3.0\na tetrahedron\n", points = "POINTS 4 float\n";
  std::string binary = head + "BINARY\nDATASET POLYDATA\n" + points;
  const auto put = [&](const auto& value) {
    std::string raw(reinterpret_cast<const char*>(&value), sizeof value);
    binary.append(raw.rbegin(), raw.rend());
  };
  for (const float c : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F}) put(c);
  binary += "\nPOLYGONS 4 16\n";
  for (const int v : {3, 0, 2, 1, 3, 0, 1, 3, 3, 0, 3, 2, 3, 1, 2, 3}) put(v);
  const std::string ascii = head + "ASCII\nDATASET POLYDATA\n" + points + "0 0 0 1 0 0 0 1 0\n0 0 1\n";
  return {ascii + "POLYGONS 4 16\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\nPOINT_DATA 4\n",
          ascii +
              "METADATA\n\nPOLYGONS 5 12\nOFFSETS vtktypeint64\n0 3 6 9 12\nCONNECTIVITY vtktypeint64\n"
              "0 2 1 0 1 3 0 3 2 1 2 3\n",
          binary + "\n"};
}

std::vector<std::string> objSeeds() {
  return {cube_obj,
          "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
          "f 1 3 2\r\nf 1 2 4\r\nf 1 4 3\r\nf 2 3 4\r\n"};
}
std::vector<std::string> stlSeeds() {
  // Binary files, too, begin so.
  return {tetrahedron_stl, test::binaryStl(boxSurface({1, 1, 1}, 1), "solid" + std::string(75, ' '))};
}

void holdSurface(const SurfaceFile& file) {
  const auto& vertices = file.surface.vertices;
  const auto& triangles = file.surface.triangles;
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
void readSurfaceFrom(const std::string& bytes,
                     SurfaceFile (*parse)(const std::string&, const std::string&, SurfaceReading), const char* name) {
  holdSurface(parse(bytes, name, SurfaceReading::Strict));
  if (bytes.size() > 20'000) return;
  const SurfaceFile file = surfaceFrom(bytes, name);
  holdSurface(file);
  checkSurface(file.surface, file.source);
}

/// Damaged surfaces are repaired to ones that bound a solid, or refused.
void repairFrom(const std::string& bytes) {
  if (bytes.size() > 20'000) return;
  SurfaceFile file = surfaceFrom(bytes, "input.obj", 1, SurfaceReading::Tolerant);
  holdSurface(file);
  RepairOptions coarse;
  coarse.body_nodes = 20;
  const RepairedSurface repaired = repairSurface(std::move(file.surface), std::move(file.source), coarse);
  try {
    checkSurface(repaired.surface);
  } catch (const InputError&) {
    throw Fault("a repaired surface is refused");
  }
}

}  // namespace

const Reader ply_reader = {"ply", plySeeds,
                           [](const std::string& bytes) { readSurfaceFrom(bytes, parsePly, "input.ply"); }};
const Reader off_reader = {"off", offSeeds,
                           [](const std::string& bytes) { readSurfaceFrom(bytes, parseOff, "input.off"); }};
const Reader vtk_reader = {"vtk", vtkSeeds,
                           [](const std::string& bytes) { readSurfaceFrom(bytes, parseVtk, "input.vtk"); }};
const Reader repair_reader = {"repair", objSeeds, repairFrom};
const Reader obj_reader = {"obj", objSeeds,
                           [](const std::string& bytes) { readSurfaceFrom(bytes, parseObj, "input.obj"); }};
const Reader stl_reader = {"stl", stlSeeds,
                           [](const std::string& bytes) { readSurfaceFrom(bytes, parseStl, "input.stl"); }};

}  // namespace palpate::fuzz
