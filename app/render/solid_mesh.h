#pragma once

#include <cstdint>
#include <vector>

#include "base/types.h"
#include "contact/tool.h"

namespace palpate::app {

/// What a part of a solid is made of, as solid.frag shades it.
enum class Finish { Steel, Grip, Collar, Lump, Matte };

struct SolidVertex {
  Vec3f position;  // m
  Vec3f normal;    // unit
  float finish = 0;
};

/// A smooth, rigid thing to draw.
struct SolidMesh {
  std::vector<SolidVertex> vertices;
  std::vector<std::uint32_t> indices;  // triangles, counter-clockwise from outside
};

/// A point of a profile to be turned about z: distance from the axis and height, m.
using ProfilePoint = Eigen::Vector2f;

/// Adds the surface that a profile sweeps when turned about z. The profile is one smooth
/// curve, run through so that outside is on its right (upward on an outer wall);
/// edges between smooth curves stay sharp.
void addTurned(SolidMesh& mesh, const std::vector<ProfilePoint>& profile, Finish finish);

/// The tool in its own frame (contact/tool.h): its outline turned, which comes first in the mesh, and a handle beyond
/// the part that can touch.
/// @param has_handle  a tool that only stands there has none
SolidMesh toolMesh(const ToolShape& shape, bool has_handle = true);

/// Where the tool's handle ends, m along its axis from the tip.
float toolHandleEnd(const ToolShape& shape);

/// A unit sphere about the origin.
SolidMesh sphereMesh();

/// An arrow along +z with shaft radius 1: shaft vertices at z 0 and 1, head vertices at
/// z 2 (base) and 3 (tip); arrow.vert stretches the two parts differently.
SolidMesh arrowMesh();

}  // namespace palpate::app
