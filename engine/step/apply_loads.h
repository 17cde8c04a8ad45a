#pragma once

#include "model/model.h"
#include "model/state.h"

namespace palpate {

struct StepMasses;
class Workspace;

/// Mass of the tissue itself by nodes, sum_q V_q rho_q N_i(X_q), kg (node_count). Set-up.
AlignedVector<float> tissueMass(const Model& model);

/// What bears on the tissue, but for tools: its weight, the scene's surface loads at a time, and what is set live,
///   du += alpha M^-1 (w + sum_v N(X_v) f_v(t, u) + m g + sum_v N(X_v) f_v)
/// Real-time: no allocation, no lock, no throw. Nothing is computed where there is no load. The team shares the scene's
/// in fixed parts.
void addLoads(const Model& model, double time, double alpha, const StepMasses& masses, State& state,
              Workspace& workspace);

/// Pinned vertices are where they are held at the step's end, or as near as the scene's max_speed lets them come:
///   du += M^-1 N(X_v) (x_pin - X_v - N u - N du) / (N M^-1 N)   one after the other, a few times over,
/// so that what neighbours leave is below a thousandth of the way, and met in the next steps.
/// @param force  receives what each pin did to the tissue, N
/// Real-time: no allocation, no lock, no throw.
void holdPins(const Model& model, double alpha, const StepMasses& masses, State& state, VertexValues& force);

/// Moves State::region_shift towards what is asked for, in one step as far as the scene's max_speed goes.
/// Real-time: no allocation, no lock, no throw.
void moveRegions(const Model& model, State& state);

}  // namespace palpate
