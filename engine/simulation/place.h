#pragma once

#include <array>
#include <vector>

#include "contact/tool_set.h"
#include "discretization/nodes/nested_cloud.h"
#include "discretization/surface/surface_tree.h"
#include "simulation/build_model.h"
#include "simulation/prepare.h"

namespace palpate {

// A cloud that follows the tool. One fine cloud holds all others (nested_cloud.h); a *place* is a model of it whose
// nodes are live densely in a ball around each tool and thinly elsewhere. Far from the tools all places have the same
// nodes, cells, points, supports, masses and rows; all have one skin, one time step and one rule for masses.
//
//   Places       what they have in common, made once for a scene
//   PlaceIndex   which place: for each tool the centre that its ball is around
//   nextPlace    the index for where the tools are, with hysteresis
//   makePlace    index -> model, a pure function
//   passage.h    the state of one place carried over to another
//
// For a real-time loop, not built here: a place is its index, so a worker makes it (1-2 s) or reads it (a file each, by
// the key of Places and the index; all have one skin, so skin rows are most of it), then makes its passage from the
// present place (Passage::apply allocates nothing). The loop swaps between two ticks where both are ready, and records
// the tick and the index; else it stays where it is and counts the tick as one on a cloud that was not ready.

/// The lengths of a following cloud, m.
struct FollowSizes {
  double fine = 0;    // spacing in the balls
  double coarse = 0;  // far from them
  double stride = 0;  // between neighbouring centres
};

/// fine 0.55 tool radii, coarse 2.2 times that but no wider than a fifth of the body's size (the cube root of its
/// volume), neighbouring centres half a ball apart but no more than 10 mm. Of several tools the smallest counts.
/// Measured over drags on liver and kidney by `mtled follow`.
FollowSizes followSizes(const Scene& scene, double volume);

/// Of the tool's radius: the ball's. Below 3, and below 5 fine spacings, a swap is felt (0.5 to 2 % of the force).
inline constexpr double ball_radii = 3;

/// The centre of each tool's ball by number, -1 beyond the last tool.
using PlaceIndex = std::array<int, max_tools>;

struct Places {
  Scene scene;  // as its places have it, but for their balls: the coarse spacing, one time step
  SurfaceTree organ;
  FollowSizes sizes;
  NestedCloud cloud;          // nodes on the surface where they are on it: volume is fitted place by place
  std::vector<Vec3> centres;  // (centre_count) m, on the skin, about a stride apart
  CommonToPlaces common;
};

/// A model around some balls.
struct Place {
  PlaceIndex index{};
  std::vector<int> node;  // (node_count) which node of Places::cloud each of the model's is, ascending
  Model model;
};

/// Throws InputError as buildModel does, and where a material relaxes: what a point remembers can't be carried over.
/// @param organ  closed surface, checked, m
Places makePlaces(const Scene& scene, const TriangleSurface& organ, const Progress& progress = {});

/// The place whose balls are around those centres. Equal bits at each call, whatever was made before.
/// Throws InputError where a region of the scene can't be used with this cloud.
/// Test: simulation/place_test.cpp
Place makePlace(const Places& places, const PlaceIndex& index);

/// The centres nearest to where the tools are, m (tool_count); no tool's centre changes before another is nearer by a
/// quarter of the stride. @param present  any; its entries may be -1
/// Real-time: no allocation, no lock, no throw; ~ centre_count.
PlaceIndex nextPlace(const Places& places, const PlaceIndex& present, const ToolPostures& tools);

/// The spacing that a place wants.
SpacingField wantedSpacing(const Places& places, const PlaceIndex& index);

}  // namespace palpate
