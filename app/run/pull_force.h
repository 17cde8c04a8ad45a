#pragma once

#include "model/model.h"

namespace palpate::app {

/// Force of the spring that pulls a skin vertex by `gap`, m, in N (node_passes.h).
double pullForce(const Model& model, int vertex, const Vec3& gap);

}  // namespace palpate::app
