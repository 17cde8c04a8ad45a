#pragma once

#include <string>
#include <vector>

#include "model/model.h"

namespace palpate::tools {

/// A body of about so many nodes, with supports of 29 nodes on the mean.
struct BenchSize {
  std::string name;           // "5k"
  double spacing = 0;         // m
  double support_factor = 0;  // finer clouds have a smaller share of cut-off supports, hence a smaller factor
};

/// About 1k and 5k, and without `quick` 33k nodes.
std::vector<BenchSize> benchSizes(bool quick);

/// A box of 100 x 100 x 60 mm on a fixed base under a ball, one point per cell, neo-Hookean at nu = 0.49, with node
/// patches. Gradients are not made consistent: that changes their values, not their number, and takes long.
Scene benchScene(const BenchSize& size);

/// A smooth displacement at the nodes that turns and bends the box by half a radian and nearly keeps its volume, in
/// numbers that float represents exactly, so that all precisions start alike. m (node_count)
std::vector<Vec3> benchDisplacement(const std::vector<Vec3>& X);

}  // namespace palpate::tools
