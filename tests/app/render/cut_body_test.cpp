#include "app/render/cut_body.h"

#include <catch2/catch.hpp>
#include <map>

#include "app/render/field.h"
#include "app/render/skin_mesh.h"
#include "discretization/surface/solids.h"
#include "support/small_scene.h"

using namespace palpate;
using namespace palpate::app;

namespace {

/// Of a closed surface, by Gauss' theorem, m^3.
double volumeOf(const TriangleSurface& s) {
  double volume = 0;
  for (const auto& t : s.triangles) volume += s.vertices[t[0]].dot(s.vertices[t[1]].cross(s.vertices[t[2]])) / 6;
  return volume;
}

/// Edges that are not passed once in each direction; vertices at equal places count as one.
int openEdges(const TriangleSurface& s) {
  std::map<std::array<double, 3>, int> first_at;
  std::vector<int> place;
  for (const Vec3& X : s.vertices)
    place.push_back(first_at.try_emplace({X.x(), X.y(), X.z()}, static_cast<int>(place.size())).first->second);
  std::map<std::array<int, 2>, int> passes;
  for (const auto& t : s.triangles)
    for (int c = 0; c < 3; ++c) {
      const int a = place[t[c]], b = place[t[(c + 1) % 3]];
      passes[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  int open = 0;
  for (const auto& [edge, sum] : passes) open += sum != 0;
  return open;
}

}  // namespace

TEST_CASE("A cut body is closed, and has the volume that is left", "[cut]") {
  const Model block = test::blockModel();
  const double whole = volumeOf(block.skin.surface);
  REQUIRE(openEdges(block.skin.surface) == 0);
  Eigen::AlignedBox3d box;
  for (const Vec3& X : block.skin.surface.vertices) box.extend(X);
  // Through the middle every plane halves a block, also one that passes vertices.
  for (const Vec3& normal : {Vec3(0, -1, 0), Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(1, 2, 0.3), Vec3(-0.5, 0.866, 0)}) {
    const Body cut = cutBody(block, {box.center(), normal});
    INFO("normal " << normal.transpose());
    CHECK(openEdges(cut.skin.surface) == 0);
    CHECK(volumeOf(cut.skin.surface) ==
          Approx(0.5 * whole).epsilon(1e-4));  // flat faces; vertices near the plane are taken to lie in it
    CHECK(cut.skin.begin.size() == cut.skin.surface.vertices.size() + 1);
    for (const Vec3& X : cut.skin.surface.vertices)
      CHECK(normal.normalized().dot(X - box.center()) < 1e-6);  // what counts as in the plane
  }
}

TEST_CASE("A section's vertices follow a linear field, as all points of a body do", "[cut]") {
  const Model block = test::blockModel();
  const Body cut = cutBody(block, {Vec3(0, 0, 0.015), Vec3(1, 2, 0.3)});
  Mat3 gradient;
  gradient << 0.1, -0.2, 0.3, 0.05, 0.15, 0, -0.1, 0.2, -0.3;
  Displacements u;
  for (const Vec3& X : cut.X) u.push_back(toFloat4(gradient * X + Vec3(0.01, 0, 0)));
  const auto x = deformed(cut.skin.surface.vertices, cut.skin, u);
  double worst = 0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    const Vec3 X = cut.skin.surface.vertices[v];
    worst = std::max(worst, (x[v].cast<double>() - (X + gradient * X + Vec3(0.01, 0, 0))).norm());
  }
  CHECK(worst < 1e-7);  // u and x are floats: 6e-8 of some centimetres, summed over a support
}

TEST_CASE("A plane beside a body cuts nothing or leaves nothing", "[cut]") {
  const Model block = test::blockModel();
  const Body all = cutBody(block, {Vec3(1, 0, 0), Vec3(1, 0, 0)});
  CHECK(volumeOf(all.skin.surface) == Approx(volumeOf(block.skin.surface)));
  CHECK(all.skin.surface.triangles.size() == block.skin.surface.triangles.size());
  CHECK_THROWS_AS(cutBody(block, {Vec3(1, 0, 0), Vec3(-1, 0, 0)}), std::invalid_argument);
}

TEST_CASE("A round body's cut is closed too", "[cut]") {
  Scene scene = test::blockScene(0.01);
  scene.organs[0].solid = OrganSpec::Solid::Cylinder;
  const Model cylinder = buildModel(scene, cylinderSurface(0.03, 0.03, 0.004));
  for (const double angle : {0.0, 0.3, 1.1, 2.0}) {
    const Body cut = cutBody(cylinder, {Vec3(0.0011, 0.0003, 0), Vec3(std::cos(angle), std::sin(angle), 0)});
    INFO("angle " << angle);
    CHECK(openEdges(cut.skin.surface) == 0);
    CHECK(volumeOf(cut.skin.surface) ==
          Approx(0.5 * volumeOf(cylinder.skin.surface)).epsilon(0.05));  // 1 mm beside the axis
  }
}

// A snapshot's contacts are vertices of the whole skin: where a cut's skin has fewer, they were written beside it.
TEST_CASE("A cut body shows the contact where the whole one has it, and none that was cut away", "[cut][whole]") {
  Scene scene = test::blockScene(0.01);
  const Model block = buildModel(scene, boxSurface(Vec3(0.03, 0.03, 0.03), 0.004));
  const CutBody cut = cutBody(block, {Vec3(0.001, 0, 0), Vec3(1, 0, 0)});
  const std::size_t whole_count = block.skin.surface.vertices.size();
  REQUIRE(cut.whole_vertex.size() == cut.skin.surface.vertices.size());
  Snapshot snapshot;
  snapshot.u.assign(block.X.size(), Float4{});
  snapshot.materials = block.materials;
  snapshot.contact_vertex.assign(1, 0);
  snapshot.contact_force.assign(1, toFloat4(Vec3(0, 0, -1)));
  snapshot.contact_count = 1;
  SkinMesh mesh(cut, cut.whole_vertex);
  int left = 0;
  for (std::size_t v = 0; v < whole_count; ++v) {
    const Vec3 X = block.skin.surface.vertices[v];
    const int at = mesh.leftOf(static_cast<int>(v));
    if (X.x() > 0.0011) CHECK(at < 0);
    if (X.x() < 0.0009) REQUIRE(at >= 0);
    if (at >= 0) CHECK(cut.skin.surface.vertices[at] == X);
    left += at >= 0;
    snapshot.contact_vertex[0] = static_cast<int>(v);
    mesh.update(snapshot, View{});
    float strongest = 0;
    for (const SkinVertex& s : mesh.vertices()) strongest = std::max(strongest, s.contact);
    CHECK((strongest > 0) == (at >= 0));
  }
  CHECK(left > 0);
  CHECK(left < static_cast<int>(whole_count));
  CHECK(mesh.leftOf(-1) < 0);
  CHECK(mesh.leftOf(static_cast<int>(whole_count) + 7) < 0);
}
