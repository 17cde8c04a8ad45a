#pragma once

#include <vector>

#include "app/run/soak_motion.h"
#include "model/body.h"

namespace palpate::app {

/// Places for a soak's tool to press, in an order of their own from one seed. There the tool, advancing
/// along its axis, first touches with its middle, and the organ is thick enough: a press is at most 0.8
/// radii and a quarter of the thickness. Throws InputError where the scene has no such place.
std::vector<SoakPlace> soakPlaces(const Body& model, int count, unsigned seed);

}  // namespace palpate::app
