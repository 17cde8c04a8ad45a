#pragma once

#include <array>

#include "contact/tool_set.h"
#include "mechanics/kernel_layout.h"
#include "model/live_loads.h"

namespace palpate {

struct Model;
struct State;

/// What may be set while a run goes on: part of State, so that simulations which share a Model do not share it.
struct LiveParameters {
  std::array<double, max_tools> friction{};  // Coulomb coefficients between each tool and the tissue
  LiveLoads loads;
  KernelMaterials kernel;  // the materials in force, and the node patches' moduli that follow from them
};

/// What the model was loaded with.
LiveParameters loadedParameters(const Model& model);

/// Replaces a material from the next step on. Its density has no effect: it is in the lumped masses.
/// What has relaxed goes with the shear modulus, as if the tissue had been so before; another share of it follows in
/// its own time. Terms beyond those that the model was loaded with have no effect.
/// @param index  into Model::materials
/// Real-time: no allocation, no lock, no throw. Test: simulation/relaxation_test.cpp
void setMaterial(const Model& model, int index, const Material& material, State& state);

/// How much stiffer a material is at rest than another: the larger ratio of bulk and of shear moduli. Each counts for
/// itself: at one wave modulus one can be traded for the other, but node patches relax only the bulk. Fibres count by
/// what they add to Young's modulus.
double stiffening(const Material& loaded, const Material& present);

/// The largest stiffening of the materials in force, s: the body's stiffness at rest is at most s times the loaded one,
/// and its critical step at least dt_critical / sqrt(s).
/// Real-time. Test: simulation/live_parameters_test.cpp
double stiffening(const Model& model, const LiveParameters& live);

/// The largest bulk modulus over shear modulus, after a long time, of the materials in force.
double bulkOverShear(const LiveParameters& live);
double bulkOverShear(const std::vector<Material>& materials);

/// Whether Poisson's ratio of all materials in force is at least 0.45.
bool nearlyIncompressible(const LiveParameters& live);
bool nearlyIncompressible(const std::vector<Material>& materials);

}  // namespace palpate
