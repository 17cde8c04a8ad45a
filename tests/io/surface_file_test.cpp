#include "io/surface_file.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <limits>

#include "discretization/surface/solids.h"
#include "discretization/surface/surface_geometry.h"
#include "support/bad_texts.h"
#include "support/binary_stl.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using Catch::Contains;
using test::binaryStl;

namespace {

const std::string cube_obj =
    "# a unit cube of quads\n"
    "mtllib cube.mtl\n"
    "o cube\n"
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
    "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "vn 0 0 1\nvt 0 0\n"
    "usemtl red\ns off\n"
    "f 4/1/1 3/1/1 2/1/1 1/1/1\n"
    "f 5//1 6//1 7//1 8//1\n"
    "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

std::string asciiStl(const TriangleSurface& s) {
  std::string text = "solid made by a test\n";
  char line[128];
  for (const auto& t : s.triangles) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (int v : t) {
      const Vec3& x = s.vertices[v];
      std::snprintf(line, sizeof line, "      vertex %.9g %.9g %.9g\n", x.x(), x.y(), x.z());
      text += line;
    }
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid made by a test\n";
}

std::string crlf(const std::string& text) {
  std::string result;
  for (char c : text) result += c == '\n' ? std::string("\r\n") : std::string(1, c);
  return result;
}

}  // namespace

TEST_CASE("An OBJ of quads with normals, textures and groups is read", "[io][surface]") {
  TempFolder folder;
  for (const std::string& text : {cube_obj, crlf(cube_obj), "\xEF\xBB\xBF" + cube_obj,
                                  replaced(cube_obj, "f 1 2 6 5\n", "f 1 2 \\\n 6 5 # side\n"),
                                  replaced(cube_obj, "f 1 2 6 5\n", "f -8 -7 -3 -4\n"),
                                  replaced(cube_obj, "v 1 1 1\n", "v +1.0 1e0 1 0.5 0.5 0.5\n")}) {
    const TriangleSurface cube = readClosedSurface(folder.write("cube.obj", text), 0.1);
    CHECK(cube.vertices.size() == 8);
    CHECK(cube.triangles.size() == 12);
    CHECK(signedVolume(cube) == Approx(1e-3).epsilon(1e-12));
  }
}

TEST_CASE("What writeObj writes reads back to the same bits", "[io][surface]") {
  TempFolder folder;
  const TriangleSurface s = halfEllipsoidSurface({0.04, 0.03, 0.03}, 0.005);
  writeObj(s, folder.path("half.obj"));
  const SurfaceFile back = readSurface(folder.path("half.obj"));
  CHECK(back.surface.vertices == s.vertices);
  CHECK(back.surface.triangles == s.triangles);
  CHECK(back.source.vertex_line.front() == 1);
  CHECK(back.source.triangle_line.front() == static_cast<int>(s.vertices.size()) + 1);
  CHECK_THROWS_AS(writeObj(s, folder.path("missing/half.obj")), std::runtime_error);
}

TEST_CASE("STL is read as ASCII or binary by content, and its corners are joined", "[io][surface]") {
  TempFolder folder;
  const TriangleSurface s = ellipsoidSurface({40, 30, 30}, 5);  // mm
  for (const std::string& bytes : {asciiStl(s), crlf(asciiStl(s)), binaryStl(s), binaryStl(s, "solid but binary")}) {
    const TriangleSurface back = readClosedSurface(folder.write("s.STL", bytes), 0.001);
    CHECK(back.vertices.size() == s.vertices.size());
    CHECK(back.triangles.size() == s.triangles.size());
    CHECK(signedVolume(back) == Approx(1e-9 * signedVolume(s)).epsilon(1e-6));  // float32 coordinates
  }
}

TEST_CASE("An OBJ split along seams is joined", "[io][surface]") {
  TempFolder folder;
  // Every face with its own vertices, as some exporters write them.
  std::string text;
  const TriangleSurface s = boxSurface({1, 1, 1}, 0.5);
  for (const auto& t : s.triangles) {
    for (int v : t) {
      for (int k = 0; k < 3; ++k) text += (k == 0 ? "v " : " ") + std::to_string(s.vertices[v][k]);
      text += "\n";
    }
    text += "f -3 -2 -1\n";
  }
  CHECK(readClosedSurface(folder.write("split.obj", text)).vertices.size() == s.vertices.size());
}

namespace {

const std::string ply_head =
    "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face 4\n"
    "property list uchar int vertex_indices\nend_header\n";
const std::string text_ply = "ply\nformat ascii 1.0\ncomment a scanner's\n" + ply_head +
                             "0 0 0 9\n2 0 0 9\n0 1 0 9\n0 0 1 9\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const std::string off =
    "OFF # by hand\n4 4 6\n0 0 0\n2 0 0 0 0 1\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3 255 0 0\n3 0 3 2\n3 1 2 3\n";
const std::string vtk_head = "# vtk DataFile Version 4.2\nliver\n";
const std::string vtk_set = "DATASET POLYDATA\nPOINTS 4 float\n";
const std::string text_vtk = vtk_head + "ASCII\n" + vtk_set + "0 0 0 2 0 0 0 1 0\n0 0 1\n";

/// Numbers as they lie in a file of the other byte order, or of this one.
template <class T>
std::string raw(const std::vector<T>& values, bool big_endian) {
  std::string bytes;
  for (const T value : values) {
    char one[sizeof value];
    std::memcpy(one, &value, sizeof value);
    if (big_endian) std::reverse(one, one + sizeof value);
    bytes.append(one, sizeof value);
  }
  return bytes;
}

std::string binaryPly(bool big_endian) {
  std::string bytes = std::string("ply\nformat binary_") + (big_endian ? "big" : "little") + "_endian 1.0\n" + ply_head;
  for (const std::vector<float>& x : {std::vector<float>{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 1}})
    bytes += raw(x, big_endian) + 'r';
  for (const std::vector<int>& t : {std::vector<int>{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
    bytes += '\3' + raw(t, big_endian);
  return bytes;
}

}  // namespace

TEST_CASE("PLY, OFF and VTK are read, text or binary, to the same tetrahedron", "[io][surface]") {
  TempFolder folder;
  const std::string binary_vtk =
      vtk_head + "BINARY\n" + vtk_set + raw(std::vector<float>{0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 1}, true) +
      "\nPOLYGONS 4 16\n" + raw(std::vector<int>{3, 0, 2, 1, 3, 0, 1, 3, 3, 0, 3, 2, 3, 1, 2, 3}, true) + "\n";
  const std::vector<std::pair<std::string, std::string>> files = {
      {"text.ply", text_ply},
      {"little.ply", binaryPly(false)},
      {"big.PLY", binaryPly(true)},
      {"a.off", off},
      {"old.vtk", text_vtk + "POLYGONS 4 16\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\nPOINT_DATA 4\n"},
      {"new.vtk", text_vtk + "METADATA\n\nPOLYGONS 5 12\nOFFSETS vtktypeint64\n0 3 6 9 12\n"
                             "CONNECTIVITY vtktypeint64\n0 2 1 0 1 3 0 3 2 1 2 3\n"},
      {"binary.vtk", binary_vtk}};
  for (const auto& [name, bytes] : files) {
    INFO(name);
    const TriangleSurface s = readClosedSurface(folder.write(name, bytes), 0.5);
    CHECK(s.triangles.size() == 4);
    CHECK(signedVolume(s) == Approx(2.0 / 6 / 8));
    // Cut short anywhere it is refused; a tolerant reader takes the faces that are there.
    const std::string cut = bytes.substr(0, bytes.size() - (name == "binary.vtk" || name == "new.vtk" ? 40 : 30));
    CHECK_THROWS_AS(surfaceFrom(cut, name), InputError);
  }
  CHECK(surfaceFrom(off.substr(0, off.size() - 5), "a.off", 1, SurfaceReading::Tolerant).surface.triangles.size() == 3);
  CHECK(surfaceFrom(text_ply + "", "a.ply").source.triangle_line[1] == 17);
}

TEST_CASE("What a reader would leave out of the shape in silence is refused", "[io][surface][refusal]") {
  const std::string strips =
      replaced(text_ply, "end_header", "element tristrips 1\nproperty list int int vertex_indices\nend_header");
  for (const SurfaceReading reading : {SurfaceReading::Strict, SurfaceReading::Tolerant})
    CHECK_THAT(refusal([&] { surfaceFrom(strips + "4 0 1 2 3\n", "strips.ply", 1, reading); }),
               Contains("strips.ply:") && Contains("triangle strips") && Contains("export plain faces"));
  // All of it beyond any place: the first coordinate is named, whoever reads.
  CHECK_THAT(refusal([&] { surfaceFrom(cube_obj, "cube.obj", 1e12, SurfaceReading::Tolerant); }),
             Contains("cube.obj:") && Contains(" = 1e+12 m, more than a billion metres away"));
}

TEST_CASE("Counts that a file is too short for are refused before memory is taken", "[io][surface][refusal]") {
  const auto message = [](const std::string& bytes, const std::string& name) {
    return refusal([&] { surfaceFrom(bytes, name); });
  };
  CHECK_THAT(message(replaced(text_ply, "vertex 4", "vertex 2000000000"), "a.ply"), Contains("more of \"vertex\""));
  CHECK_THAT(message(replaced(text_ply, "vertex 4", "vertex 4e9"), "a.ply"), Contains("can't be"));
  CHECK_THAT(message(replaced(off, "4 4 6", "400000000 4 6"), "a.off"), Contains("than the file has bytes for"));
  CHECK_THAT(message(replaced(text_vtk, "POINTS 4", "POINTS 600000000"), "a.vtk"), Contains("than the file has bytes"));
  CHECK_THAT(message(replaced(text_ply, "3 1 2 3", "3 1 2 7"), "a.ply"), Contains("face 4 names a vertex"));
  CHECK_THAT(message(replaced(text_vtk, "POLYDATA", "STRUCTURED_POINTS"), "a.vtk"), Contains("no POLYDATA set"));
}

TEST_CASE("A tolerant reader takes what can be read, and counts the rest", "[io][surface]") {
  const std::string damaged =
      replaced(replaced(cube_obj, "v 1 1 1\n", "v 1 1 nan\n"), "usemtl red\n", "f 1 2 99\nwhat\n");
  const SurfaceFile file = surfaceFrom(damaged, "cube.obj", 1, SurfaceReading::Tolerant);
  CHECK(file.surface.triangles.size() + static_cast<std::size_t>(file.unreadable_faces) == 12 + 3);
  CHECK(file.surface.vertices.size() == 7);
  CHECK_THAT(file.unreadable, Contains("cube.obj:") && Contains("\"nan\""));
  CHECK_THAT(
      surfaceFrom(replaced(cube_obj, "usemtl red\n", "f 1 2 99\n"), "cube.obj", 1, SurfaceReading::Tolerant).unreadable,
      Contains("cube.obj:") && Contains("a face without proper vertices"));
  const std::string binary = binaryStl(boxSurface({1, 1, 1}, 1));
  const SurfaceFile cut = surfaceFrom(binary.substr(0, binary.size() - 70), "a.stl", 1, SurfaceReading::Tolerant);
  CHECK(cut.unreadable_faces == 2);
  // Where nothing can be read it says what is wrong first.
  const std::string commas = "v 0,5 0 0\nv 1 0,5 0\nv 0 0 0,5\nf 1 2 3\n";
  CHECK_THAT(refusal([&] { surfaceFrom(commas, "cube.obj", 1, SurfaceReading::Tolerant); }),
             Contains("cube.obj:1:3") && Contains("a point and not a comma"));
}

TEST_CASE("Bad OBJ files are refused at their place, with advice", "[io][surface][refusal]") {
  TempFolder folder;
  const std::vector<BadText> bad = {
      {"v 1 1 1\n", "v 1 1 nan\n", ":10:7", "not finite", "export the file again"},
      {"v 1 1 1\n", "v 1 1 inf\n", ":10:7", "not finite", "export the file again"},
      {"v 1 1 1\n", "v 1 1e999 1\n", ":10:5", "beyond what a number can hold", "units"},
      {"v 1 1 1\n", "v 1 -1e12 1\n", ":10", "vertex 7 has y = -1e+12 m", "scale"},
      {"v 1 1 1\n", "v 1 1\n", ":10", "coordinate 3 of this vertex is missing", "cut short"},
      {"v 1 1 1\n", "v 1 one 1\n", ":10:5", "\"one\" is not a number", "like 0.125"},
      {"v 1 1 1\n", "v 1 1,5 1\n", ":10:5", "\"1,5\" is not a number", "like 0.125"},
      {"v 1 1 1\n", "", ":16:18", "vertex index 8 but the file has 7 vertices", "export it again"},
      {"f 1 2 6 5", "f 1 2 99999999999999999999", ":18:7", "out of range", "export"},
      {"f 1 2 6 5", "f 1 2 4000000000", ":18:7", "out of range", "export"},
      {"f 1 2 6 5", "f 1 2 2000000000 5", ":18:7", "vertex index 2000000000 but the file has 8", "export"},
      {"f 1 2 6 5", "f 0 1 2", ":18:3", "vertex index 0", "from 1"},
      {"f 1 2 6 5", "f -9 -8 -7", ":18:3", "reaches back beyond the 8 vertices", "count back"},
      {"f 1 2 6 5", "f 1 2", ":18:1", "a face with 2 corners", "at least 3"},
      {"f 1 2 6 5", "f", ":18:1", "a face with 0 corners", "at least 3"},
      {"f 1 2 6 5", "f 1 x 3", ":18:5", "\"x\" is not a vertex index", "f 1 2 3"},
      {"f 1 2 6 5", "curv 0 1 1 2", ":18:1", "\"curv\" is not a statement", "\"v\" and \"f\""},
      {"f 1 2 6 5", "", ":", "the surface has a hole", "close the hole"},
      {"f 1 2 6 5", "f 5 6 2 1", ":18", "turned against its neighbours (2 such faces", "reverse"},
      {"f 1 2 6 5", "f 1 2 6 6", ":18", "zero area", "mesh repair"},
      {"v 1 1 1\n", "v 0 0 1\n", ":", "has zero area", "mesh repair"},
  };
  checkRefused(folder, "cube.obj", cube_obj, bad, [](const std::string& path) { readClosedSurface(path); });
}

TEST_CASE("Bad STL files are refused at their place, with advice", "[io][surface][refusal]") {
  TempFolder folder;
  const TriangleSurface cube = boxSurface({1, 1, 1}, 1);
  const auto message = [&](const std::string& bytes) {
    const std::string path = folder.write("cube.stl", bytes);
    return refusal([&] { readClosedSurface(path); });
  };
  const std::string count = std::to_string(cube.triangles.size());

  // ASCII
  const std::string ascii = asciiStl(cube);
  CHECK_THAT(message(replaced(ascii, "vertex", "vertx")),
             Contains("cube.stl:4:7: \"vertx\" where \"vertex\" should stand"));
  CHECK_THAT(message(replaced(ascii, "vertex -0.5", "vertex NaN")), Contains("cube.stl:") && Contains("not finite"));
  CHECK_THAT(message(replaced(ascii, "endsolid made by a test", "")),
             Contains("the file ends where \"facet\" should stand"));
  CHECK_THAT(message("solid nothing\nendsolid nothing\n"), Contains("no faces in this file"));
  CHECK_THAT(message(ascii.substr(0, ascii.size() / 2)), Contains("cube.stl:") && Contains("cut short"));

  // binary
  const std::string binary = binaryStl(cube);
  CHECK_THAT(message(binary.substr(0, 500)),
             Contains("announces " + count + " faces") && Contains("has 500; it was cut short"));
  CHECK_THAT(message(binary + "abc"), Contains("trailing bytes"));
  CHECK_THAT(message(binary.substr(0, 50)), Contains("neither an ASCII STL") && Contains("50 bytes"));
  std::string lying = binary;
  lying[83] = '\x7f';  // two billion faces
  CHECK_THAT(message(lying), Contains("announces 2130706") && Contains("cut short"));
  std::string none = binary.substr(0, 84);
  std::memset(none.data() + 80, 0, 4);
  CHECK_THAT(message(none), Contains("no faces in this file"));
  std::string with_nan = binary;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(with_nan.data() + 84 + 50 * 2 + 12 + 12, &nan, 4);
  CHECK_THAT(message(with_nan), Contains("corner 2 of face 3 of " + count + " is not finite"));
  // A hole: the last face missing, the count right.
  TriangleSurface open = cube;
  open.triangles.pop_back();
  CHECK_THAT(message(binaryStl(open)), Contains("the surface has a hole") && Contains("3 open edges"));
}

TEST_CASE("What is wrong in a surface's file names the place that asked for it, too", "[io][surface][refusal]") {
  const TempFolder folder;
  const SourceLocation asked{"scene.toml", 3, 9};
  const std::string cut = folder.write("cut.obj", "v 0 0 0\nv 1 0\n"),
                    open = folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  CHECK_THAT(refusal([&] { readSurface(cut, 1, asked); }), Contains("cut.obj:2") && Contains("scene.toml:3:9"));
  CHECK_THAT(refusal([&] { readClosedSurface(open, 1, asked); }), Contains("open.obj") && Contains("scene.toml:3:9"));
}

TEST_CASE("Missing, empty and foreign files are refused", "[io][surface][refusal]") {
  TempFolder folder;
  CHECK_THAT(refusal([&] { readSurface(folder.path("none.obj")); }), Contains("none.obj: the file does not exist"));
  CHECK_THAT(refusal([&] {
               readSurface(folder.path("none.obj"), 1, {"a.toml", 3, 11});
             }),
             Contains("a.toml:3:11: the file "));
  CHECK_THAT(refusal([&] { readSurface(folder.path("")); }), Contains("folder"));
  CHECK_THAT(refusal([&] { readSurface(folder.write("a.obj", "")); }), Contains("the file is empty"));
  CHECK_THAT(refusal([&] { readSurface(folder.write("a.stl", " \r\n")); }), Contains("the file is empty"));
  CHECK_THAT(refusal([&] { readSurface(folder.write("a.obj", "# nothing\n")); }), Contains("no faces"));
  CHECK_THAT(refusal([&] { readSurface(folder.write("a.gltf", "{}\n")); }),
             Contains("use one of .obj, .stl, .ply, .off, .vtk"));
  const std::string far = "v 0 0 0\nv 1 0 0\nv 0 -2e9 0\nf 1 2 3\n";
  CHECK_THAT(refusal([&] { readSurface(folder.write("a.obj", far)); }),
             Contains("a.obj:3: vertex 3 has y = -2e+09 m, more than a billion metres away") && Contains("unit"));
  CHECK_NOTHROW(readSurface(folder.write("a.obj", far), 0.1));
  CHECK_THAT(refusal([&] { readSurface(folder.write("a.obj", far), 1e308); }),
             Contains("a.obj:2: vertex 2 has x = 1e+308 m"));
  CHECK_THAT(refusal([&] { readSurface(folder.write("a.obj", cube_obj), -1); }), Contains("scale must be positive"));
  const std::string l_shape = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 3 4 5 6 1 2\n";
  const SurfaceFile l = readSurface(folder.write("l.obj", l_shape));
  CHECK(l.concave_polygons == 1);
  CHECK(surfaceArea(l.surface) == Approx(3));  // a fan from its first corner would cover more
}
