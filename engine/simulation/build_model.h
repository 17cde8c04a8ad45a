#pragma once

#include "discretization/surface/triangle_surface.h"
#include "simulation/model.h"
#include "simulation/preparation.h"
#include "simulation/state.h"

namespace palpate {

/// Turns a scene and its organ's surface into a model: cloud, cells, points, shape
/// functions, masses, boundaries, stable step, kernel layout. Throws InputError naming
/// the place in the scene that can't be used. `io/load_model.h` reads the files first.
/// @param organ  closed surface, checked, m
Model buildModel(const Scene& scene, const TriangleSurface& organ, const Progress& progress = {});

/// The second half of buildModel: what is quick, and what depends on rate, step and tool. The same bits from a
/// preparation that was kept as from a new one.
/// @param tree  of the organ's closed surface
Model finishModel(const Scene& scene, const SurfaceTree& tree, Preparation preparation, const Progress& progress = {});

/// The model at rest with the tool at its start pose. Equal bits at each call.
State initialState(const Model& model);

}  // namespace palpate
