#pragma once

#include <functional>
#include <optional>
#include <string>

#include "discretization/surface/surface_tree.h"
#include "model/model.h"
#include "model/state.h"
#include "setup/discretize.h"

namespace palpate {

/// Called with what is being done and how much of the whole set-up is behind, 0..1. May throw to end it.
/// loadModel calls it again and again within a stage, too.
using Progress = std::function<void(const std::string& what, double fraction)>;

/// Where buildModel's long first half may come from, and who looks on.
struct BuildOptions {
  Progress progress;
  std::function<std::optional<Preparation>()> find;  // one that was kept for this scene and organ, or nothing
  std::function<void(const Preparation&)> keep;      // gets one that was made
  std::function<void(Discretization&, const SurfaceTree&)> disturb;  // changes nodes and cells before they are used
};

/// The one way from a scene to a model:
///
///   organ -> nodes and cells (discretize) -> Preparation (prepare) -> Model
///
/// The first two take long and can be kept; the last takes a moment and depends on rate, step and tool, too. A model
/// has
/// the same bits from a preparation that was kept as from a new one. `io/load_model.h` reads the files and keeps
/// preparations. Throws InputError naming the place in the scene that can't be used.
/// @param organ  closed surface, checked, m
Model buildModel(const Scene& scene, const TriangleSurface& organ, const BuildOptions& options = {});

/// The model at rest with the tool at its start pose. Equal bits at each call.
State initialState(const Model& model);

}  // namespace palpate
