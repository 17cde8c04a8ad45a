#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/spin_team.h"
#include "model/model.h"
#include "mtled/bench/kernel_cost.h"
#include "mtled/bench/machine_ceilings.h"

namespace palpate::tools {

/// One way to compute the internal forces of a body, ready to be timed.
struct BenchKernel {
  std::string name;       // "plain Eigen", "blocks", ...
  std::string precision;  // of the gradients: "double", "float32", "int16"
  InstructionSet set = InstructionSet::Plain;
  bool patches = false;    // with node-patch volume
  KernelCost cost;         // zeros where it is not counted
  double error_limit = 0;  // relative force error that its precision allows
  int max_threads = 1;
  std::function<void(SpinTeam&)> evaluate;
  std::function<std::vector<Vec3>()> forces{};  // N, of the last evaluation
};

/// All kernels of one body at one displacement, which both outlive them. First the baseline; then the block kernel
/// in double, float32 and with 16-bit gradients, for every supported instruction set (the narrower ones on one
/// thread), and with node patches. `with_reference` adds the ten-line check.
/// @param u  m (node_count), exact in float
std::vector<BenchKernel> benchKernels(const Model& model, const std::vector<Vec3>& u, int max_threads,
                                      bool with_reference);

}  // namespace palpate::tools
