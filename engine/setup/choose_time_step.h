#pragma once

#include <functional>

#include "mechanics/critical_time_step.h"
#include "model/model.h"

namespace palpate {

/// More steps than this are not taken in a tick: a scene that needs them has a number wrong. Stiff bodies that are
/// meant need some hundreds.
inline constexpr int max_steps_per_tick = 10'000;

/// The longest critical step for which it pays to add mass to a body with the critical step `dt_critical`: what the
/// fewest steps per tick that are granted need (or the scene's time_step). 0: none.
/// @param grants  whether the body may get the mass with which its critical step is this long; the last time that it
/// says so is for the result
double longestCriticalStep(const Scene& scene, double dt_critical, const std::function<bool(double)>& grants);

/// Throws InputError where the scene alone, whatever its body, asks for more than max_steps_per_tick.
void checkStepsAsked(const Scene& scene);

/// Sets the model's step and its number per tick: the scene's, or the largest within its safety and the tool's reach.
/// Throws InputError where the scene's step is unstable, too long for the contact or no whole part of a tick, and where
/// a tick would have more than max_steps_per_tick, at the key that asks for them.
/// @param X  nodes, m, for the message
void chooseTimeStep(const Scene& scene, const CriticalTimeStep& limit, const std::vector<Vec3>& X, Model& model);

}  // namespace palpate
