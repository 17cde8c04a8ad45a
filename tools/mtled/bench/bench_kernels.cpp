#include "mtled/bench/bench_kernels.h"

#include <memory>

#include "mechanics/internal_forces.h"
#include "mtled/bench/plain_kernel.h"

namespace palpate::tools {
namespace {

constexpr double double_limit = 1e-12;  // rounding of some hundred terms, times K/mu
/// Gradients rounded to float move J by about 1e-6, which the bulk modulus multiplies against forces of the order of
/// the
/// shear modulus; the bound of mechanics/internal_forces_test.cpp.
double floatLimit(const Material& material) { return 1e-6 * material.bulk_modulus / material.shear_modulus; }

/// Rounding to 16 bits cancels in the sums that rigid motions and linear fields take; a bending field sees it. The
/// bound of mechanics/kernel_instructions_test.cpp.
double int16Limit(const Material& material) { return 10 * floatLimit(material); }

BenchKernel referenceKernel(const Model& model, const std::vector<Vec3>& u) {
  auto f = std::make_shared<std::vector<Vec3>>();
  BenchKernel k;
  k.name = "ten-line reference";
  k.precision = "double";
  k.set = compiledInstructionSet();
  k.error_limit = double_limit;
  k.evaluate = [&model, &u, f](SpinTeam&) {
    referenceInternalForces(model.point_shape, model.point_volume, model.point_material, model.materials, u, *f);
  };
  k.forces = [f] { return *f; };
  return k;
}

BenchKernel plainKernel(const Model& model, const std::vector<Vec3>& u, int max_threads) {
  auto kernel =
      std::make_shared<PlainKernel>(model.kernel.point, model.point_shape, model.point_volume, model.materials[0]);
  auto f = std::make_shared<std::vector<Vec3>>();
  BenchKernel k;
  k.name = "plain Eigen";
  k.precision = "double";
  k.set = compiledInstructionSet();
  k.error_limit = double_limit;
  k.max_threads = max_threads;
  k.cost.useful_flops = k.cost.executed_flops = usefulFlops(model.point_shape);
  k.cost.streamed_bytes = k.cost.working_set = kernel->streamedBytes() + 2.0 * sizeof(Vec3) * model.nodeCount();
  k.evaluate = [&u, kernel, f](SpinTeam& team) { kernel->forces(u, *f, team); };
  k.forces = [f] { return *f; };
  return k;
}

template <class Real>
using Layout = std::shared_ptr<const KernelLayoutOf<Real>>;

template <class Real>
Layout<Real> layoutOf(const Model& model, bool patches, GradientPrecision precision = GradientPrecision::Float32) {
  return std::make_shared<const KernelLayoutOf<Real>>(makeKernelLayout<Real>(
      model.point_shape, model.point_X, model.point_volume, model.point_material, model.materials, model.nodeCount(),
      patches ? model.patches : NodePatches{}, precision, model.X));
}

template <class Real>
BenchKernel blockKernel(const Model& model, const std::vector<Vec3>& u, const Layout<Real>& layout, InstructionSet set,
                        int max_threads) {
  struct Data {
    Layout<Real> layout;
    KernelMaterialsOf<Real> materials;
    KernelScratchOf<Real> scratch;
    AlignedVector<Real4<Real>> u;
  };
  auto data = std::make_shared<Data>(
      Data{layout, makeKernelMaterials(*layout, model.materials), makeKernelScratch(*layout, set), {}});
  for (const Vec3& a : u) data->u.push_back(toReal4<Real>(a));
  const bool is_double = sizeof(Real) == 8, rounded = !layout->rounded_gradN.empty();
  BenchKernel k;
  k.patches = !layout->patch_node.empty();
  k.name = k.patches ? "blocks, node patches" : "blocks";
  k.precision = is_double ? "double" : rounded ? "int16" : "float32";
  k.set = set;
  k.cost = blockKernelCost(*layout, model.point_shape);
  k.error_limit = is_double ? double_limit : rounded ? int16Limit(model.materials[0]) : floatLimit(model.materials[0]);
  k.max_threads = max_threads;
  k.evaluate = [data](SpinTeam& team) {
    internalForces(*data->layout, data->materials, data->u.data(), data->scratch, team);
  };
  k.forces = [data] {
    AlignedVector<Real4<Real>> sum(data->u.size());
    sumForces(*data->layout, data->scratch, 0, data->layout->node_count, sum.data());
    std::vector<Vec3> f;
    for (const auto& a : sum) f.push_back(toVec3(a));
    return f;
  };
  return k;
}

}  // namespace

std::vector<BenchKernel> benchKernels(const Model& model, const std::vector<Vec3>& u, int max_threads,
                                      bool with_reference) {
  const auto sets = supportedInstructionSets();
  const InstructionSet widest = sets.back();
  std::vector<BenchKernel> kernels;
  kernels.push_back(plainKernel(model, u, max_threads));
  if (with_reference) kernels.push_back(referenceKernel(model, u));
  kernels.push_back(blockKernel<double>(model, u, layoutOf<double>(model, false), widest, max_threads));
  for (const auto precision : {GradientPrecision::Float32, GradientPrecision::Int16}) {
    const auto layout = layoutOf<float>(model, false, precision);
    for (const InstructionSet set : sets)
      kernels.push_back(blockKernel(model, u, layout, set, set == widest ? max_threads : 1));
    kernels.push_back(blockKernel(model, u, layoutOf<float>(model, true, precision), widest, max_threads));
  }
  return kernels;
}

}  // namespace palpate::tools
