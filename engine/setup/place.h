#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "discretization/nodes/nested_cloud.h"
#include "discretization/surface/surface_memory.h"
#include "discretization/surface/surface_tree.h"
#include "model/place_index.h"
#include "setup/finish.h"
#include "setup/prepare.h"

namespace palpate {

// A cloud that follows the tool. One fine cloud of each body holds all others (nested_cloud.h); a *place* is a model of
// them whose nodes are live densely in a ball around each tool and thinly elsewhere. Far from the tools all places have
// the same nodes, cells, points, supports, masses and rows, and so has a body that no ball reaches; all have one skin,
// one time step and one rule for masses.
//
//   Places       what they have in common, made once for a scene
//   PlaceIndex   which place: for each tool the centre that its ball is around
//   nextPlace    the index for where the tools are, with hysteresis: the ball stays with the tissue that they press
//   makePlace    index -> model, a pure function
//   passage.h    the state of one place carried over to another
//
// A place is its index: a real-time loop has a worker that makes it, or reads it where it was kept, and swaps to it
// between two ticks (realtime/loop/cloud_follower.h).

/// The lengths of a following cloud, m.
struct FollowSizes {
  double fine = 0;    // spacing in the balls
  double coarse = 0;  // far from them
  double stride = 0;  // between neighbouring centres
};

/// fine half the radius that the tool's end wants (touchRadius), but such that the fine cloud can be made; coarse 1.2
/// tool radii, within a tenth and a fifth of the body's size (the cube root of its volume): a small tool wants no more
/// nodes far from it than a large one; and half as thick as the body is where a tenth of its skin is thinnest, but so
/// that it has some thousand nodes at most: a sheet or a flap does not bend on nodes that are further apart (one of 6
/// mm on nodes of 7.2 mm, 3 mm near the tool, was 45 % too soft; of 3 mm 2 %); neighbouring centres half a ball apart
/// but no more than 10 mm. Of several tools the smallest counts. Where the scene says how far nodes near the tools are
/// apart (at_tools), all are as much wider or closer. Measured over drags on liver and kidney by `mtled follow`.
/// @param volume, area, thickness  of the body, m^3, m^2, m (thicknessOf)
FollowSizes followSizes(const Scene& scene, double volume, double area,
                        double thickness = std::numeric_limits<double>::infinity());

/// The radius of a tool's ball: in radii that the tool's end wants, and at least in fine spacings. With less a swap is
/// felt (0.5 to 2 % of the force).
inline constexpr double ball_radii = 3, ball_spacings = 6;

/// m, of FollowSizes, but for the body's size; the coarse one is what a scene's `spacing` is where its cloud follows.
double fineSpacing(const Scene& scene);
double followSpacing(const Scene& scene);

/// Where the long half of a place (Preparation) may come from, and where it goes, by a key; empty: nowhere.
struct PlaceStore {
  std::function<std::optional<Preparation>(const std::string& key)> find;
  std::function<void(const std::string& key, const Preparation&)> keep;
};

/// What places take a body from.
struct BodyPlaces {
  Scene scene;  // as the body has it at all places, but for their balls: its coarse spacing, one time step
  SurfaceTree surface;
  NestedCloud cloud;  // nodes on the surface where they are on it: volume is fitted place by place
  CommonToBody common;
  double fine = 0;    // m, spacing in the smallest tool's ball
  double widest = 0;  // m, that of any ball at most: what is small beside the tools has nodes for itself
  std::vector<SpacingField::Refinement> thin;  // where a tool's ball would have less than two nodes across
};

struct Places {
  Scene scene;  // as BodyPlaces::scene, of all bodies
  SurfaceTree organ;
  FollowSizes sizes;             // of several bodies the widest coarse spacing
  std::vector<BodyPlaces> body;  // (body_count)
  std::vector<Vec3> centres;     // (centre_count) m, on the skin, about a stride apart
  CommonToPlaces common;
  int most_nodes = 0;            // of a place: what states have room for,
  std::size_t most_batches = 0;  // and of its points (KernelLayout)
  /// Numbers that the points of any place remember, of what those of a state do.
  std::size_t mostRemembered(const State& state) const;
  std::string key;  // all that they depend on, as bytes, for a PlaceStore; empty: nothing is kept

  int nodeCount() const;  // of the fine clouds
};

/// A model around some balls.
struct Place {
  PlaceIndex index{};
  std::vector<int> node;  // (node_count) which node of the fine clouds, one after another, each of the model's is
  Model model;
};

/// What the places that were made leave of each body for the next one. No bit of a place depends on it.
struct PlaceMemory {
  struct OfBody {
    KnownRows rows;         // of the last
    SurfaceMemory surface;  // of the organ
  };
  std::vector<OfBody> body;
};

/// Throws InputError as buildModel does.
/// @param organ  closed surface, checked, m
/// @param store  used where the scene was read from a file (Scene::set_up_values)
Places makePlaces(const Scene& scene, const TriangleSurface& organ, const Progress& progress = {},
                  const PlaceStore& store = {});

/// The place whose balls are around those centres. Equal bits at each call, whatever was made or kept before.
/// Throws InputError where a region of the scene can't be used with this cloud, or states have no room for the place.
/// @param memory  of places of these Places, or null: saves time
/// Test: simulation/place_test.cpp
Place makePlace(const Places& places, const PlaceIndex& index, const PlaceStore& store = {},
                PlaceMemory* memory = nullptr);

/// The place at which the tools start.
PlaceIndex startPlace(const Places& places);

/// That where the first tool is at a point instead, m.
PlaceIndex placeAt(const Places& places, const Vec3& point);

/// Makes room in a state of one place for that of any, so that copies between them allocate nothing.
void reserveForPlaces(const Places& places, State& state);

/// The same for a state that will hold copies of `like`.
void reserveAs(const State& like, State& state);

/// The centres nearest to where the tools are in the body at rest (posturesAtRest), m (tool_count); no tool's centre
/// changes before another is nearer by a quarter of the stride. @param present  any; its entries may be -1
/// Real-time: no allocation, no lock, no throw; ~ centre_count.
PlaceIndex nextPlace(const Places& places, const PlaceIndex& present, const ToolPostures& tools);

/// The place for tools that have pressed so far: those inside the organ at rest count from where they came in, back
/// along their axes. For set-up.
PlaceIndex placeUnder(const Places& places, ToolPostures tools);

/// The spacing that a place wants but for what is thin, of several bodies far from the tools the widest.
SpacingField wantedSpacing(const Places& places, const PlaceIndex& index);

}  // namespace palpate
