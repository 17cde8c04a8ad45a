#include "app/render/solid_mesh.h"

#include <catch2/catch.hpp>

using namespace palpate;
using namespace palpate::app;

TEST_CASE("The picture's tool is the contact's: its vertices lie on the surface, its normals are the surface's",
          "[solid_mesh]") {
  for (std::size_t k = 0; k < toolTypes().size(); ++k) {
    CAPTURE(toolTypes()[k]->name);
    const ToolShape tool = ToolShape::of(static_cast<ToolKind>(k), 0.01);
    const ToolProfile profile = toolProfile(tool);
    const SolidMesh mesh = toolMesh(tool);
    const std::size_t rings = outline(profile).size();
    constexpr std::size_t around = 57;  // vertices of a ring: 56 segments, the first place twice
    REQUIRE(mesh.vertices.size() > rings * around);
    for (std::size_t v = 0; v < rings * around; ++v) {
      const ToolDistance d = toolDistance(profile, mesh.vertices[v].position.cast<double>());
      REQUIRE(std::abs(d.distance) < 1e-8);  // float32 at 6 cm
      // The curve's normals are those of its chords: half a piece off, at most.
      REQUIRE(d.normal.dot(mesh.vertices[v].normal.cast<double>()) > 0.95);
    }
  }
}
