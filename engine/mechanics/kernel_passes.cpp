// Compiled once for each instruction set, with PALPATE_KERNEL naming it: see base/kernel_namespace.h, CMakeLists.txt.

#include "mechanics/kernel_passes.h"

#include "base/float4.h"
#include "mechanics/materials/laws.h"
#include "mechanics/relaxation_lanes.h"

namespace palpate {
namespace {

/// Tensors of the 16 points of a batch, in memory between the passes over their blocks.
template <class Real>
struct alignas(64) BatchTensors {
  Real a[9][16];
};

template <class Real>
constexpr int part_count = 16 / Simd<Real>::width;  // registers for one number of a batch's 16 points

template <class Real>
SimdTensor<Real> loadTensors(const BatchTensors<Real>& tensors, int part) {
  SimdTensor<Real> t;
  // They were stored block by block.
  for (int c = 0; c < 9; ++c)
    t[c] = Simd<Real>::gather([&](int g) { return tensors.a[c] + part * Simd<Real>::width + 4 * g; });
  return t;
}

/// Adds u_j (x) gradN_j over groups of four union nodes, as many of the four as a register holds. Lanes of a tile:
/// (node of the group, point of the block).
template <class Real, class Index, class Entry>
void addGradients(const Index* node, const Entry* tile, int group_count, const Real4<Real>* u, Simd<Real>* sum) {
  using Lanes = Simd<Real>;
  for (int g = 0; g < group_count; ++g, tile += 48, node += 4) {
    const Lanes xyz = Lanes::gather([&](int k) { return &u[node[k]].x; });
    const Lanes ux = spread<0>(xyz), uy = spread<1>(xyz), uz = spread<2>(xyz);
    for (int b = 0; b < 3; ++b) {
      const Lanes grad = Lanes::load(tile + 16 * b);
      sum[b] += ux * grad;
      sum[3 + b] += uy * grad;
      sum[6 + b] += uz * grad;
    }
  }
}

/// Adds -sum over a block's points of p gradN to its nodes' forces.
template <class Real, class Index, class Entry>
void addForces(const Index* node, const Entry* tile, int group_count, const Simd<Real>* p, Real4<Real>* f) {
  using Lanes = Simd<Real>;
  const auto add = [f](int n, const typename Lanes::Group& g) { store(f[n], load(f[n]) - g); };
  for (int g = 0; g < group_count; ++g, tile += 48, node += 4)
    for (int part = 0; part < part_count<Real>; ++part) {
      const Entry* at = tile + part * Lanes::width;
      const Lanes g0 = Lanes::load(at), g1 = Lanes::load(at + 16), g2 = Lanes::load(at + 32);
      const Lanes sum = groupSums(p[0] * g0 + p[1] * g1 + p[2] * g2, p[3] * g0 + p[4] * g1 + p[5] * g2,
                                  p[6] * g0 + p[7] * g1 + p[8] * g2);
      const Index* n = node + part * Lanes::group_count;
      add(n[0], sum.template group<0>());
      if constexpr (Lanes::group_count > 1) add(n[1], sum.template group<1>());
      if constexpr (Lanes::group_count > 2) {
        add(n[2], sum.template group<2>());
        add(n[3], sum.template group<3>());
      }
    }
}

/// Tiles come from afar, one block after another.
template <class Entry>
void prefetch(const Entry* tiles, int group_count) {
  constexpr std::ptrdiff_t ahead = 2048;  // bytes, about a block; half, twice, eight times or none: no difference
  for (std::ptrdiff_t line = 0; line < group_count * static_cast<std::ptrdiff_t>(48 * sizeof(Entry)); line += 64)
    __builtin_prefetch(reinterpret_cast<const char*>(tiles) + ahead + line);
}

/// A kernel for one width of node numbers, with gradients as Real or rounded to 16 bits.
template <class Real, class Index, bool rounded>
struct Kernel {
  const KernelView<Real>& k;
  const Index* all_nodes;

  /// Calls `add(node, tile, group_count)` for the groups of a block's union nodes.
  template <class Add>
  void forTiles(int block_number, Add add) const {
    const PointBlock& block = k.blocks[block_number];
    const Index* node = all_nodes + static_cast<std::ptrdiff_t>(block.tile_begin) * 4;
    if constexpr (rounded) {
      if (block.group_count == 0) return;  // padding
      add(node, k.gradN + static_cast<std::ptrdiff_t>(block_number) * 48, 1);
      add(node + 4, k.rounded_gradN + static_cast<std::ptrdiff_t>(block.rounded_begin) * 48, block.group_count - 1);
    } else {
      add(node, k.gradN + static_cast<std::ptrdiff_t>(block.tile_begin) * 48, block.group_count);
    }
  }

  /// Displacement gradients of a batch's 16 points, in units of the gradients' scale.
  void displacementGradients(int batch, const Real4<Real>* u, BatchTensors<Real>& H) const {
    using Lanes = Simd<Real>;
    for (int q = 0; q < 4; ++q) {
      forTiles(batch * 4 + q, [](const Index*, const auto* tile, int group_count) { prefetch(tile, group_count); });
      // Part by part, so that the sums stay in registers; added up in the same order for every register's width.
      typename Lanes::Group part_sum[part_count<Real>][9];
      for (int part = 0; part < part_count<Real>; ++part) {
        Lanes sum[9];
        for (auto& s : sum) s = Real(0);
        forTiles(batch * 4 + q, [&](const Index* node, const auto* tile, int group_count) {
          addGradients(node + part * Lanes::group_count, tile + part * Lanes::width, group_count, u, sum);
        });
        for (int c = 0; c < 9; ++c) part_sum[part][c] = sum[c].sumOfGroups();
      }
      for (int c = 0; c < 9; ++c) {
        auto total = part_sum[0][c];
        if constexpr (part_count<Real> == 2) total += part_sum[1][c];
        if constexpr (part_count<Real> == 4) total = (total + part_sum[1][c]) + (part_sum[2][c] + part_sum[3][c]);
        storeGroup(H.a[c] + 4 * q, total);
      }
    }
  }

  /// Adds -V P gradN of a batch's points to the forces of their nodes; PV holds V P, in units of the scale.
  void scatterForces(int batch, const BatchTensors<Real>& PV, Real4<Real>* f) const {
    for (int q = 0; q < 4; ++q) {
      Simd<Real> p[9];
      for (int c = 0; c < 9; ++c) p[c] = Simd<Real>::repeat(PV.a[c] + 4 * q);
      forTiles(batch * 4 + q,
               [&](const Index* node, const auto* tile, int group_count) { addForces(node, tile, group_count, p, f); });
    }
  }

  /// Multiplies tensors by the unit of the gradients, 1/m: component (c, b) of a point by its scale of b.
  void applyScale(int first_point, SimdTensor<Real>& t) const {
    if constexpr (rounded)
      for (int b = 0; b < 3; ++b) {
        const auto scale =
            Simd<Real>::load(&k.scale[static_cast<std::ptrdiff_t>(first_point / 16) * 48 + 16 * b + first_point % 16]);
        for (int c = 0; c < 9; c += 3) t[c + b] *= scale;
      }
  }

  /// First pass of the node-patch volume.
  void dilatation(int chunk, const Real4<Real>* u) const {
    BatchTensors<Real> tensors;
    for (int batch = k.chunk_begin[chunk]; batch < k.chunk_begin[chunk + 1]; ++batch) {
      displacementGradients(batch, u, tensors);
      for (int i = 0; i < 16; i += Simd<Real>::width) {
        SimdTensor<Real> H = loadTensors(tensors, i / Simd<Real>::width);
        applyScale(batch * 16 + i, H);
        for (int c = 0; c < 9; ++c)
          H[c].store(&k.displacement_gradient[static_cast<std::ptrdiff_t>(batch) * 144 + 16 * c + i]);
        volumeChange<Real>(H).store(&k.dilatation[static_cast<std::ptrdiff_t>(batch) * 16 + i]);
      }
    }
  }

  /// Pressure of points from their nodes' patches, sum_a l_a K_a theta_a, and what they keep for themselves.
  Simd<Real> patchPressure(int first_point, double bulk_modulus) const {
    using Lanes = Simd<Real>;
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(first_point / 16) * 64 + first_point % 16;
    Lanes p = Real(0);
    for (int a = 0; a < 4; ++a)
      p += Lanes::load(&k.patch_weight[first + 16 * a]) * Lanes::at(k.patch_pressure, &k.patch_node[first + 16 * a]);
    if (k.own_bulk != nullptr)
      p += static_cast<Real>(bulk_modulus) * Lanes::load(&k.own_bulk[first_point]) *
           Lanes::load(&k.dilatation[first_point]);
    return p;
  }

  /// Of a chunk's points, lane by lane.
  struct Sums {
    LeastOf<Real> min_J[part_count<Real>];
    Simd<Real> energy = Real(0), volume_change = Real(0), max_cof2 = Real(3);
    Simd<Real> max_squeeze = Real(0), max_modulus = Real(0);
    Simd<Real> relaxed_energy = Real(0), relaxation_power = Real(0);
    Simd<Real> max_pressure = Real(0);  // over the shear modulus
  };

  /// Takes from the law's stress what has relaxed. Inline, so that what has nothing to relax stays in registers.
  [[gnu::always_inline]] void relaxStress(const RelaxationStep& step, int first_point, const SimdTensor<Real>& H,
                                          const Simd<Real>& volume, SimdTensor<Real>& P, Sums& sums) const {
    RelaxingPoints<Real> points;
    for (int c = 0; c < 9; ++c) {
      H[c].store(points.H[c]);
      P[c].store(points.P[c]);
    }
    const std::ptrdiff_t at =
        static_cast<std::ptrdiff_t>(first_point / 16) * k.relaxation_terms * 96 + first_point % 16;
    relax(step, k.relaxation != nullptr ? k.relaxation + at : nullptr, points);
    for (int c = 0; c < 9; ++c) P[c] = Simd<Real>::load(points.P[c]);
    sums.relaxed_energy += volume * Simd<Real>::load(points.energy);
    sums.relaxation_power += volume * Simd<Real>::load(points.power);
  }

  template <class MaterialLanes>
  void batchesForces(const Material& material, int begin, int end, const Real4<Real>* u, Real4<Real>* f,
                     Sums& sums) const {
    using Lanes = Simd<Real>;
    const MaterialLanes lanes(material);
    const Lanes by_shear = static_cast<Real>(-1 / (material.shear_modulus * material.longTermShare()));
    const Lanes by_wave =
        static_cast<Real>(1 / (material.bulk_modulus + 4.0 / 3 * material.shear_modulus + material.fibre_modulus));
    const bool patches = k.patch_begin != nullptr;
    const RelaxationStep relaxation = relaxationStep(material, k.relaxation_step, k.relaxation_terms);
    BatchTensors<Real> tensors;
    for (int batch = begin; batch < end; ++batch) {
      if (!patches) displacementGradients(batch, u, tensors);
      for (int part = 0; part < part_count<Real>; ++part) {
        const int first = part * Lanes::width, first_point = batch * 16 + first;
        SimdTensor<Real> H, P;
        PointStateOf<Real> state;
        if (patches) {
          for (int c = 0; c < 9; ++c)
            H[c] = Lanes::load(&k.displacement_gradient[static_cast<std::ptrdiff_t>(batch) * 144 + 16 * c + first]);
          const Lanes pressure = patchPressure(first_point, material.bulk_modulus);
          state = lanes.firstPiola(H, P, &pressure);
          sums.max_pressure = max(sums.max_pressure, pressure * by_shear);
        } else {
          H = loadTensors(tensors, part);
          applyScale(first_point, H);
          state = lanes.firstPiola(H, P);
        }
        const Lanes volume = Lanes::load(&k.volume[first_point]),
                    stress_volume = Lanes::load(&k.stress_volume[first_point]);
        sums.min_J[part].note(state.J, first_point);
        sums.energy += stress_volume * state.energy;
        sums.volume_change += volume * state.J_minus_1;
        sums.max_cof2 = max(sums.max_cof2, state.cof2);
        sums.max_squeeze = max(sums.max_squeeze, state.squeeze * by_wave);
        sums.max_modulus = max(sums.max_modulus, (state.squeeze + state.other) * by_wave);
        state.cof2.store(&k.cof2[first_point]);
        state.J.store(&k.J[first_point]);
        state.squeeze.store(&k.squeeze[first_point]);
        state.other.store(&k.other[first_point]);
        if (relaxation.term_count > 0) relaxStress(relaxation, first_point, H, volume, P, sums);
        for (int c = 0; c < 9; ++c) P[c] *= stress_volume;
        applyScale(first_point, P);
        for (int c = 0; c < 9; ++c) P[c].store(tensors.a[c] + first);
      }
      scatterForces(batch, tensors, f);
    }
  }

  /// The same for the material's law among `Laws`.
  template <class... Laws>
  void batchesForcesOf(LawList<Laws...>, const Material& material, int begin, int end, const Real4<Real>* u,
                       Real4<Real>* f, Sums& sums) const {
    int place = 0;  // No lambda here: GCC 12 then fuses other products in the material's formulas.
    ((material.law == place++ ? batchesForces<typename Laws::template Lanes<Real>>(material, begin, end, u, f, sums)
                              : void()),
     ...);
  }

  void forces(int chunk, const Real4<Real>* u) const {
    Real4<Real>* f = k.force + static_cast<std::ptrdiff_t>(chunk) * k.node_count;
    for (int i = k.chunk_node_begin[chunk]; i < k.chunk_node_end[chunk]; ++i) store(f[i], GroupOf<Real>{});
    Sums sums;
    const int last = k.chunk_begin[chunk + 1];
    for (int batch = k.chunk_begin[chunk]; batch < last;) {
      const int material_index = k.batch_material[batch];
      const Material& material = k.materials[material_index];
      int end = batch;
      while (end < last && k.batch_material[end] == material_index) ++end;
      batchesForcesOf(RegisteredLaws{}, material, batch, end, u, f, sums);
      batch = end;
    }
    auto& report = k.report[chunk];
    report = {1, -1, 0, 0, 0, 3, 0, 0, 0, 0, 0};
    for (const auto& least : sums.min_J) least.find(report.min_J, report.worst_point, report.inverted);
    for (int i = 0; i < Simd<Real>::width; ++i) {
      report.energy += sums.energy.v[i];
      report.volume_change += sums.volume_change.v[i];
      report.relaxed_energy += sums.relaxed_energy.v[i];
      report.relaxation_power += sums.relaxation_power.v[i];
      const auto raise = [i](Real& largest, const Simd<Real>& lanes) {
        largest = lanes.v[i] > largest ? lanes.v[i] : largest;
      };
      raise(report.max_cof2, sums.max_cof2);
      raise(report.max_squeeze, sums.max_squeeze);
      raise(report.max_modulus, sums.max_modulus);
      raise(report.max_pressure, sums.max_pressure);
    }
  }
};

/// Calls `call` with the kernel that the layout's arrays ask for.
template <class Real, class Call>
void withKernel(const KernelView<Real>& k, Call call) {
  if constexpr (sizeof(Real) == 4) {
    if (k.short_node) {
      if (k.rounded_gradN)
        call(Kernel<Real, std::uint16_t, true>{k, k.short_node});
      else
        call(Kernel<Real, std::uint16_t, false>{k, k.short_node});
      return;
    }
    if (k.rounded_gradN) {
      call(Kernel<Real, std::int32_t, true>{k, k.node});
      return;
    }
  }
  call(Kernel<Real, std::int32_t, false>{k, k.node});
}

template <class Real>
void dilatation(const KernelView<Real>& k, int chunk, const Real4<Real>* u) {
  withKernel(k, [&](const auto& kernel) { kernel.dilatation(chunk, u); });
}

template <class Real>
void sumPatches(const KernelView<Real>& k, int begin, int end) {
  for (int i = begin; i < end; ++i) {
    // Four partial sums, so that the additions overlap; their order is fixed.
    Real sum[4] = {};
    int e = k.patch_begin[i];
    const int last = k.patch_begin[i + 1];
    for (; e + 4 <= last; e += 4)
      for (int j = 0; j < 4; ++j) sum[j] += k.patch_share[e + j] * k.dilatation[k.patch_point[e + j]];
    for (; e < last; ++e) sum[0] += k.patch_share[e] * k.dilatation[k.patch_point[e]];
    k.patch_pressure[i] = k.patch_bulk[i] * ((sum[0] + sum[1]) + (sum[2] + sum[3]));
  }
}

template <class Real>
void forces(const KernelView<Real>& k, int chunk, const Real4<Real>* u) {
  withKernel(k, [&](const auto& kernel) { kernel.forces(chunk, u); });
}

template <class Real>
constexpr KernelPasses<Real> passes{dilatation<Real>, sumPatches<Real>, forces<Real>};

}  // namespace

template <>
const KernelPasses<float>& passesFor<InstructionSet::PALPATE_KERNEL, float>() {
  return passes<float>;
}
template <>
const KernelPasses<double>& passesFor<InstructionSet::PALPATE_KERNEL, double>() {
  return passes<double>;
}

}  // namespace palpate
