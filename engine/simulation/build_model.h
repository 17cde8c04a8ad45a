#pragma once

#include <functional>
#include <string>

#include "discretization/triangle_surface.h"
#include "simulation/model.h"
#include "simulation/state.h"

namespace palpate {

/// Called with what is being done and how much of the whole set-up is behind, 0..1.
using Progress = std::function<void(const std::string& what, double fraction)>;

/// Turns a scene and its organ's surface into a model: cloud, cells, points, shape
/// functions, masses, boundaries, stable step, kernel layout. Throws InputError naming
/// the place in the scene that can't be used. `io/load_model.h` reads the files first.
/// @param organ  closed surface, checked, m
Model buildModel(const Scene& scene, const TriangleSurface& organ, const Progress& progress = {});

/// The model at rest with the tool at its start pose. Equal bits at each call.
State initialState(const Model& model);

}  // namespace palpate
