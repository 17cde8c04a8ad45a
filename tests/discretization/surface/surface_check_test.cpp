#include "discretization/surface/surface_check.h"

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <limits>

#include "base/turn.h"
#include "discretization/surface/refine_surface.h"
#include "discretization/surface/solids.h"
#include "discretization/surface/surface_geometry.h"
#include "discretization/surface/weld_vertices.h"
#include "support/temp_folder.h"

using namespace palpate;
using Catch::Contains;

namespace {

/// The unit cube around (0, 0, 1/2): 8 vertices, 12 faces.
TriangleSurface cube() {
  TriangleSurface s;
  for (int i = 0; i < 8; ++i) s.vertices.emplace_back((i & 1) - 0.5, (i >> 1 & 1) - 0.5, i >> 2);
  s.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return s;
}

void append(TriangleSurface& to, const TriangleSurface& other, const Vec3& by, double scale, bool inward) {
  const int offset = static_cast<int>(to.vertices.size());
  for (const Vec3& x : other.vertices) to.vertices.push_back(by + scale * x);
  for (auto [a, b, c] : other.triangles) {
    if (inward) std::swap(b, c);
    to.triangles.push_back({a + offset, b + offset, c + offset});
  }
}

/// As if an OBJ had the vertices in lines 101.. and the faces in lines 201..
SurfaceSource numbered(const TriangleSurface& s) {
  SurfaceSource source;
  source.file = "cube.obj";
  for (std::size_t v = 0; v < s.vertices.size(); ++v) source.vertex_line.push_back(101 + static_cast<int>(v));
  for (std::size_t t = 0; t < s.triangles.size(); ++t) source.triangle_line.push_back(201 + static_cast<int>(t));
  return source;
}

std::string refused(const TriangleSurface& s) {
  return refusal([&] { checkSurface(s, numbered(s)); });
}

}  // namespace

TEST_CASE("Sound surfaces pass", "[surface][check]") {
  CHECK_NOTHROW(checkSurface(cube()));
  CHECK_NOTHROW(checkSurface(ellipsoidSurface({0.04, 0.03, 0.02}, 0.005)));
  TriangleSurface two = cube();
  append(two, cube(), {3, 0, 0}, 1, false);  // apart
  CHECK_NOTHROW(checkSurface(two));
  TriangleSurface hollow = cube();
  append(hollow, cube(), {0, 0, 0.25}, 0.5, true);  // a cavity
  append(hollow, cube(), {0, 0, 0.4}, 0.2, false);  // a body in the cavity
  CHECK_NOTHROW(checkSurface(hollow));
  TriangleSurface spare = cube();
  spare.vertices.emplace_back(9, 9, 9);  // no face uses it
  CHECK_NOTHROW(checkSurface(spare));
}

TEST_CASE("A hole is refused with the open edge's ends and lines", "[surface][check]") {
  TriangleSurface s = cube();
  s.triangles.erase(s.triangles.begin() + 3);  // leaves edges 5-7, 7-6, 6-5 open
  const std::string message = refused(s);
  CHECK_THAT(message, Contains("cube.obj:203: the surface has a hole: the edge of face 3 of 11"));
  CHECK_THAT(message, Contains("(0.5, -0.5, 1) m [line 106]") && Contains("(-0.5, 0.5, 1) m [line 107]"));
  CHECK_THAT(message, Contains("3 open edges in all") && Contains("fill holes"));
}

TEST_CASE("A third face at an edge is refused", "[surface][check]") {
  TriangleSurface s = cube();
  s.triangles.push_back({0, 1, 7});
  const std::string message = refused(s);
  CHECK_THAT(message, Contains("cube.obj:213:") && Contains("belongs to 3 faces") && Contains("inner walls"));
}

TEST_CASE("A flipped face is named", "[surface][check]") {
  TriangleSurface s = cube();
  std::swap(s.triangles[7][0], s.triangles[7][1]);
  const std::string message = refused(s);
  CHECK_THAT(message, Contains("cube.obj:208: face 8 of 12") && Contains("turned against its neighbours (1 such face"));
  CHECK_THAT(message, Contains("reverse its vertex order"));
}

TEST_CASE("The minority is blamed, also when it has the first face", "[surface][check]") {
  TriangleSurface s = cube();
  std::swap(s.triangles[0][0], s.triangles[0][1]);
  std::swap(s.triangles[4][0], s.triangles[4][1]);
  CHECK_THAT(refused(s), Contains("face 1 of 12") && Contains("2 such faces"));
}

TEST_CASE("A surface inside out is refused", "[surface][check]") {
  TriangleSurface s = cube();
  for (auto& t : s.triangles) std::swap(t[0], t[1]);
  CHECK_THAT(refused(s), Contains("the surface is inside out") && Contains("flip normals"));
}

TEST_CASE("Zero-area faces are refused: repeated corners, coincident corners, corners in line", "[surface][check]") {
  TriangleSurface s = cube();
  s.triangles[5] = {1, 5, 5};
  CHECK_THAT(refused(s), Contains("cube.obj:206: face 6 of 12 has zero area (two corners coincide)"));

  s = cube();
  s.vertices[7] = s.vertices[6];
  CHECK_THAT(refused(s), Contains("has zero area") && Contains("[line 108]"));

  s = cube();
  s.vertices.push_back(0.5 * (s.vertices[0] + s.vertices[1]));
  s.triangles.push_back({0, 1, 8});
  CHECK_THAT(refused(s), Contains("cube.obj:213: face 13 of 13 has zero area"));
}

TEST_CASE("Bad numbers and indices are refused", "[surface][check]") {
  CHECK_THAT(refusal([] {
               checkSurface(TriangleSurface{}, {"a.obj", {}, {}});
             }),
             Contains("a.obj: the surface has no faces"));
  TriangleSurface s = cube();
  s.vertices[2].y() = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(refused(s), Contains("cube.obj:103: vertex 3 is not finite"));
  s = cube();
  s.triangles[1][2] = 8;
  CHECK_THAT(refused(s), Contains("cube.obj:202: face 2 of 12 names vertex 9 of 8"));
  s.triangles[1][2] = -1;
  CHECK_THAT(refused(s), Contains("names vertex 0 of 8"));
}

TEST_CASE("Parts that cut one another, and bodies inside bodies, are refused", "[surface][check]") {
  TriangleSurface s = cube();
  append(s, cube(), {0.3, 0.2, 0.4}, 1, false);
  CHECK_THAT(refused(s), Contains("pierce one another near") && Contains("boolean union"));

  s = cube();
  append(s, cube(), {0, 0, 0.25}, 0.5, false);
  CHECK_THAT(refused(s), Contains("cube.obj:213: the part with face 13 of 24 lies inside another part"));

  s = cube();
  append(s, cube(), {0, 0, 1}, 1, false);  // one stands on the other
  CHECK_NOTHROW(checkSurface(s));

  s = cube();
  append(s, cube(), {3, 0, 0}, 1, true);
  CHECK_THAT(refused(s), Contains("the part with face 13 of 24 is inside out"));
}

TEST_CASE("A vertex far away hides no self-intersection", "[surface][check]") {
  const TriangleSurface fine = refineSurface(boxSurface({1, 1, 1}, 0.2), 0.2);
  const auto highest = [&](const Vec3& where) {
    int best = 0;
    for (int v = 0; v < static_cast<int>(fine.vertices.size()); ++v)
      if ((fine.vertices[v] - where).norm() < (fine.vertices[best] - where).norm()) best = v;
    return best;
  };
  const int top = highest({0.03, 0.02, 1});
  for (const double away : {0.8, 8.0, 800.0, 8000.0}) {
    TriangleSurface spike = fine;
    spike.vertices[top] = Vec3(0.03, 0.02, 1 + away);  // outwards: a spike, but a sound one
    CHECK_NOTHROW(checkSurface(spike));
    spike.vertices[top] = Vec3(0.01 * away, 0.02 * away, 1 - 2 * away);  // through the body and out below
    INFO("away " << away);
    CHECK_THAT(refused(spike), Contains("pierce one another"));
  }
}

TEST_CASE("Faces that only touch do not pierce, however unlike their sizes", "[surface][check]") {
  // A small cube stands with one corner on a big one's face, and with an edge against its side.
  for (const double scale : {1.0, 1e-2, 1e-4}) {
    TriangleSurface s = cube();
    const TriangleSurface upright = cube();
    TriangleSurface standing = upright;
    const Quat on_corner = uprightOn(Vec3(1, 1, 1)).conjugate();
    for (Vec3& x : standing.vertices) x = on_corner * (x - upright.vertices[0]);
    append(s, standing, Vec3(0.1, 0.2, 1), scale, false);
    append(s, upright, Vec3(0.5 + scale / 2, 0.1, 0.3 - 0.5 * scale), scale, false);
    INFO("scale " << scale);
    CHECK_NOTHROW(checkSurface(s));
  }
}

TEST_CASE("A one-sided surface is refused", "[surface][check]") {
  // Six vertices, ten faces: the projective plane, closed (two faces at each edge) but one-sided.
  TriangleSurface s;
  s.vertices = {{0, 0, 1}, {1, 0, 0}, {0.3, 0.9, 0.1}, {-0.8, 0.6, 0.2}, {-0.8, -0.6, -0.1}, {0.3, -0.9, 0.3}};
  s.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1},
                 {1, 2, 4}, {2, 3, 5}, {3, 4, 1}, {4, 5, 2}, {5, 1, 3}};
  CHECK_THAT(refused(s), Contains("one-sided"));
}

TEST_CASE("Welding joins what coincides, drops what is unused, and keeps the lines", "[surface][check]") {
  TriangleSurface soup;
  for (const auto& t : cube().triangles) {
    const int first = static_cast<int>(soup.vertices.size());
    for (int v : t) soup.vertices.push_back(cube().vertices[v] + Vec3(1e-8, 0, 0) * (first % 5));  // jitter << 1e-6
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  soup.vertices.emplace_back(7, 7, 7);
  SurfaceSource source = numbered(soup);
  CHECK(weldVertices(soup, source) == 37 - 8);
  CHECK(soup.vertices.size() == 8);
  CHECK(source.vertex_line.size() == 8);
  CHECK(source.vertex_line[0] == 101);
  CHECK_NOTHROW(checkSurface(soup, source));
  CHECK(weldVertices(soup, source) == 0);
}

TEST_CASE("Welding costs the same wherever the vertices stand: a plane across the order of the search, too",
          "[surface][check]") {
  // All vertices of the plane are alike along the direction in which welding goes through them.
  const Vec3 across = Vec3(0.4171, 0.6853, 0.5970).normalized();
  const Vec3 e1 = across.unitOrthogonal(), e2 = across.cross(e1);
  constexpr int side = 250;
  TriangleSurface soup;
  std::vector<Vec3> corner;
  for (int i = 0; i < side * side; ++i) corner.emplace_back((i % side) * e1 + (i / side) * e2);
  for (int i = 0; i + side + 1 < side * side; ++i) {
    if (i % side == side - 1) continue;
    for (const std::array<int, 3>& t : {std::array<int, 3>{i, i + 1, i + side}, {i + 1, i + side + 1, i + side}}) {
      const int first = static_cast<int>(soup.vertices.size());
      for (const int v : t) soup.vertices.push_back(corner[static_cast<std::size_t>(v)]);
      soup.triangles.push_back({first, first + 1, first + 2});
    }
  }
  const auto weldSeconds = [](TriangleSurface s) {
    SurfaceSource source;
    const auto start = std::chrono::steady_clock::now();
    weldVertices(s, source);
    CHECK(s.vertices.size() == static_cast<std::size_t>(side) * side);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  TriangleSurface turned = soup;  // the same plane along the direction
  for (Vec3& x : turned.vertices) x = Vec3(x.dot(e1) * across + x.dot(e2) * e1);
  const double along = std::min(weldSeconds(turned), weldSeconds(turned));
  CHECK(weldSeconds(soup) < 10 * along);  // a search through all that are alike: 700 times
}
