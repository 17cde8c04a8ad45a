#pragma once

#include <functional>
#include <string>

#include "simulation/model.h"
#include "simulation/state.h"

namespace palpate {

/// Called with what is being done and how much of the whole set-up is behind, 0..1.
using Progress = std::function<void(const std::string& what, double fraction)>;

/// Turns a scene into a model: surface, cloud, cells, points, shape functions,
/// masses, boundaries, stable step, kernel layout. Throws InputError naming the
/// place in the scene or surface that can't be used.
Model buildModel(const Scene& scene, const Progress& progress = {});

/// The model at rest with the tool at its start pose. Equal bits at each call.
State initialState(const Model& model);

}  // namespace palpate
