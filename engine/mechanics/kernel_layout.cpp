#include "mechanics/kernel_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "base/input_error.h"
#include "discretization/nodes/node_order.h"
#include "mechanics/bounded_pressure.h"
#include "mechanics/point_block_order.h"

namespace palpate {
namespace {

/// Work packages of one force evaluation: so many that a thread with a late or slow core leaves most of its share to
/// the
/// others; so few that clearing and summing their buffers stays below a few percent.
constexpr int chunk_count = 16;

using BlockGradients = std::vector<std::array<Vec3, 4>>;  // [node][point]

template <class Real>
int unionNode(const KernelLayoutOf<Real>& layout, std::size_t at) {
  return layout.short_node.empty() ? layout.node[at] : layout.short_node[at];
}

/// Points of one material after another, each in slices about a cell thick (thinner ones would make blocks flat) but
/// for
/// what pointBlockOrder exchanges, every material padded with -1 to whole batches.
std::vector<int> batchOrder(const ShapeTable& shape, const std::vector<Vec3>& point_X,
                            const std::vector<int>& point_material, int material_count,
                            std::vector<int>& batch_material) {
  std::vector<int> order;
  for (int m = 0; m < material_count; ++m) {
    std::vector<int> mine;
    std::vector<Vec3> X;
    for (int q = 0; q < static_cast<int>(point_X.size()); ++q)
      if (point_material[q] == m) {
        mine.push_back(q);
        X.push_back(point_X[q]);
      }
    std::vector<int> placed;
    for (int k : slicedOrder(X, 4, 2)) placed.push_back(mine[k]);
    while (placed.size() % 16 != 0) placed.push_back(-1);
    placed = pointBlockOrder(shape, std::move(placed));
    order.insert(order.end(), placed.begin(), placed.end());
    batch_material.resize(order.size() / 16, m);
  }
  return order;
}

/// How the points' moduli differ from their batches'. @pre  `base` is not empty
template <class Real>
void addShares(KernelLayoutOf<Real>& layout, const std::vector<int>& point_material, const std::vector<int>& base,
               const std::vector<Material>& materials) {
  layout.shear_share.assign(layout.point.size(), Real(1));
  layout.bulk_share = layout.shear_share;
  layout.stress_volume = layout.volume;
  for (std::size_t place = 0; place < layout.point.size(); ++place) {
    if (layout.point[place] < 0) continue;
    const Material& own = materials[point_material[layout.point[place]]];
    const Material& common = materials[base[point_material[layout.point[place]]]];
    layout.shear_share[place] = static_cast<Real>(own.shear_modulus / common.shear_modulus);
    layout.bulk_share[place] = static_cast<Real>(own.bulk_modulus / common.bulk_modulus);
    layout.stress_volume[place] *= layout.shear_share[place];
  }
}

/// Padding points are in no patch; their weights are zero.
template <class Real>
void addPatches(KernelLayoutOf<Real>& layout, const std::vector<double>& volume, const NodePatches& patches) {
  const std::size_t batches = layout.batch_material.size();
  layout.patch_node.assign(batches * 64, 0);
  layout.patch_weight.assign(batches * 64, Real(0));
  for (std::size_t slot = 0; slot < layout.point.size(); ++slot) {
    const int q = layout.point[slot];
    if (q < 0) continue;
    for (int a = 0; a < 4; ++a) {
      const std::size_t at = slot / 16 * 64 + static_cast<std::size_t>(a) * 16 + slot % 16;
      layout.patch_node[at] = patches.node[q][a];
      layout.patch_weight[at] = static_cast<Real>(patches.weight[q][a]);
      if (!layout.shear_share.empty()) layout.patch_weight[at] /= layout.shear_share[slot];
    }
  }
  if (!patches.own.empty()) {
    layout.own_bulk.assign(layout.point.size(), Real(0));
    for (std::size_t slot = 0; slot < layout.point.size(); ++slot) {
      if (layout.point[slot] < 0) continue;
      layout.own_bulk[slot] = static_cast<Real>(patches.own[layout.point[slot]]);
      if (!layout.shear_share.empty()) layout.own_bulk[slot] *= layout.bulk_share[slot] / layout.shear_share[slot];
    }
  }

  layout.patch_begin.assign(patches.volume.size() + 1, 0);
  for (const auto& nodes : patches.node)
    for (int node : nodes) ++layout.patch_begin[node + 1];
  std::partial_sum(layout.patch_begin.begin(), layout.patch_begin.end(), layout.patch_begin.begin());
  layout.patch_point.resize(layout.patch_begin.back());
  layout.patch_share.resize(layout.patch_begin.back());
  std::vector<int> next(layout.patch_begin.begin(), layout.patch_begin.end() - 1);
  for (std::size_t place = 0; place < layout.point.size(); ++place) {
    const int q = layout.point[place];
    for (int a = 0; q >= 0 && a < 4; ++a) {
      const int node = patches.node[q][a], at = next[node]++;
      layout.patch_point[at] = static_cast<std::int32_t>(place);
      layout.patch_share[at] = static_cast<Real>(volume[q] * patches.weight[q][a] / patches.volume[node]);
    }
  }
}

/// The entries of a block's points (-1: padding): act(p, entry of the shape table).
template <class Act>
void forEntries(const ShapeTable& shape, const int* point, Act act) {
  for (int p = 0; p < 4; ++p)
    for (int e = point[p] < 0 ? 0 : shape.begin[point[p]]; e < (point[p] < 0 ? 0 : shape.begin[point[p] + 1]); ++e)
      act(p, e);
}

/// Union support of a block's points, ascending.
/// @param place  (node_count) scratch, all -1; left so
void findUnion(const ShapeTable& shape, const int* point, std::vector<int>& place, std::vector<int>& nodes) {
  nodes.clear();
  forEntries(shape, point, [&](int, int e) {
    if (std::exchange(place[shape.node[e]], 0) < 0) nodes.push_back(shape.node[e]);
  });
  for (const int node : nodes) place[node] = -1;
  std::sort(nodes.begin(), nodes.end());
}

/// A block's gradients in double: [node][point], in the order of its union nodes.
/// @param place  as findUnion's
void gatherGradients(const ShapeTable& shape, const int* point, const std::vector<int>& nodes, std::vector<int>& place,
                     BlockGradients& gradN) {
  for (std::size_t n = 0; n < nodes.size(); ++n) place[nodes[n]] = static_cast<int>(n);
  gradN.assign(nodes.size(), {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()});
  forEntries(shape, point, [&](int p, int e) { gradN[place[shape.node[e]]][p] = shape.gradN[e]; });
  for (const int node : nodes) place[node] = -1;
}

/// Writes the tiles of a block's nodes [first, last): entry(node, point, component).
template <class Element, class Entry>
void appendTiles(AlignedVector<Element>& tiles, std::size_t node_begin, std::size_t node_end, Entry entry) {
  std::size_t at = tiles.size();
  tiles.resize(at + (node_end - node_begin) * 12);
  for (std::size_t first = node_begin; first < node_end; first += 4)
    for (int b = 0; b < 3; ++b)
      for (std::size_t n = first; n < first + 4; ++n)
        for (int p = 0; p < 4; ++p) tiles[at++] = entry(n, p, b);
}

/// Moves four nodes that span a large tetrahedron to the front: the pair furthest apart from the first node on, the
/// node
/// furthest from their line, the one furthest from that plane.
void anchorsFirst(std::vector<int>& nodes, const std::vector<Vec3>& X) {
  const auto bring = [&](std::size_t place, auto measure) {
    std::size_t best = place;
    double most = measure(X[nodes[place]]);
    for (std::size_t k = place; k < nodes.size(); ++k)
      if (const double here = measure(X[nodes[k]]); here > most) best = k, most = here;
    std::rotate(nodes.begin() + place, nodes.begin() + best, nodes.begin() + best + 1);
  };
  const Vec3 start = X[nodes[0]];
  bring(0, [&](const Vec3& x) { return (x - start).squaredNorm(); });
  const Vec3 a = X[nodes[0]];
  bring(1, [&](const Vec3& x) { return (x - a).squaredNorm(); });
  const Vec3 ab = X[nodes[1]] - a;
  bring(2, [&](const Vec3& x) { return ab.cross(x - a).squaredNorm(); });
  const Vec3 normal = ab.cross(X[nodes[2]] - a);
  bring(3, [&](const Vec3& x) { return std::abs(normal.dot(x - a)); });
}

/// Rounds all but the anchors' gradients to 16 bits and gives the anchors what keeps the zeroth and first moments:
/// an error
/// e at X_j acts on linear fields like e l_a(X_j) at the anchors, l_a their tetrahedron's linear coordinates.
/// @param gradN  is used up
void addRoundedTiles(KernelLayoutOf<float>& layout, const std::vector<int>& nodes, BlockGradients& gradN,
                     const std::vector<Vec3>& X) {
  const std::size_t block = layout.blocks.size() - 1;
  layout.scale.resize(block / 4 * 48 + 48, 1.0F);  // where there is no point, or no gradient but the anchors'
  if (gradN.empty()) {
    layout.gradN.resize(layout.gradN.size() + 48, 0.0F);
    return;
  }
  Mat3 edges;
  for (int c = 0; c < 3; ++c) edges.col(c) = X[nodes[c + 1]] - X[nodes[0]];
  if (nodes.size() < 4 || !(std::abs(edges.determinant()) > 1e-6 * std::pow(edges.colwise().norm().maxCoeff(), 3)))
    throw InputError(
        {}, "the nodes around a group of integration points lie in one plane, and 16-bit gradients can't be made",
        "use gradient_precision = \"float32\", or a larger support_factor");
  const Mat3 inverse_edges = edges.inverse();

  constexpr double largest_integer = 32767;
  std::array<Vec3, 4> scale;
  for (int p = 0; p < 4; ++p)
    for (int b = 0; b < 3; ++b) {
      double largest = 0;
      for (std::size_t n = 4; n < gradN.size(); ++n) largest = std::max(largest, std::abs(gradN[n][p][b]));
      float& s = layout.scale[block / 4 * 48 + b * 16 + block % 4 * 4 + p];
      if (largest > 0) s = static_cast<float>(largest / largest_integer);
      scale[p][b] = s;
    }
  for (std::size_t n = 4; n < gradN.size(); ++n) {
    const Vec3 l = inverse_edges * (X[nodes[n]] - X[nodes[0]]);
    for (int p = 0; p < 4; ++p)
      for (int b = 0; b < 3; ++b) {
        // float's rounding of the scale may carry the largest beyond the range by a hair
        const double integer =
            std::clamp(std::nearbyint(gradN[n][p][b] / scale[p][b]), -largest_integer, largest_integer);
        const double error = gradN[n][p][b] - integer * scale[p][b];
        gradN[0][p][b] += error * (1 - l.sum());
        for (int a = 0; a < 3; ++a) gradN[a + 1][p][b] += error * l[a];
        gradN[n][p][b] = integer;
      }
  }
  appendTiles(layout.gradN, 0, 4,
              [&](std::size_t n, int p, int b) { return static_cast<float>(gradN[n][p][b] / scale[p][b]); });
  appendTiles(layout.rounded_gradN, 4, nodes.size(), [&](std::size_t n, int p, int b) {
    return static_cast<std::int16_t>(n < gradN.size() ? gradN[n][p][b] : 0.0);
  });
}

/// Ranges of batches that are worked on together, and the nodes that each touches.
template <class Real>
void makeChunks(KernelLayoutOf<Real>& layout) {
  const int batches = static_cast<int>(layout.batch_material.size());
  for (int c = 0; c <= chunk_count; ++c) layout.chunk_begin.push_back(batches * c / chunk_count);
  for (int c = 0; c < chunk_count; ++c) {
    int begin = layout.node_count, end = 0;
    const auto include = [&](int node) {
      begin = std::min(begin, node);
      end = std::max(end, node + 1);
    };
    for (int q = layout.chunk_begin[c] * 4; q < layout.chunk_begin[c + 1] * 4; ++q)
      for (int k = 0; k < layout.blocks[q].group_count * 4; ++k)
        include(unionNode(layout, static_cast<std::size_t>(layout.blocks[q].tile_begin) * 4 + k));
    layout.chunk_node_begin.push_back(std::min(begin, end));
    layout.chunk_node_end.push_back(end);
  }
}

/// The passes compiled for an instruction set.
template <class Real>
const KernelPasses<Real>& passesOf(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::Avx512) return passesFor<InstructionSet::Avx512, Real>();
  if (set == InstructionSet::Avx2) return passesFor<InstructionSet::Avx2, Real>();
#endif
  if (set != InstructionSet::Plain) throw std::invalid_argument("no such kernel on this architecture");
  return passesFor<InstructionSet::Plain, Real>();
}

}  // namespace

template <class Real>
// NOLINTNEXTLINE(performance-unnecessary-value-param): moved from
KernelMaterialsOf<Real> makeKernelMaterials(const KernelLayoutOf<Real>& layout, std::vector<Material> materials) {
  KernelMaterialsOf<Real> result;
  result.materials = std::move(materials);
  if (!layout.patch_begin.empty()) result.patch_bulk.resize(layout.patch_begin.size() - 1);
  result.patch_shear.resize(result.patch_bulk.size());
  updatePatchBulk(layout, result);
  return result;
}

template <class Real>
void updatePatchBulk(const KernelLayoutOf<Real>& layout, KernelMaterialsOf<Real>& materials) {
  auto least_ratio = std::numeric_limits<Real>::infinity();  // of shear to bulk modulus
  // A patch's shares sum to 1, so this is the harmonic mean of the bulk moduli in it.
  for (std::size_t i = 0; i < materials.patch_bulk.size(); ++i) {
    Real sum = 0, least = 0;
    for (int e = layout.patch_begin[i]; e < layout.patch_begin[i + 1]; ++e) {
      const Material& material = materials.materials[layout.batch_material[layout.patch_point[e] / 16]];
      auto shear = static_cast<Real>(material.shear_modulus * material.longTermShare());
      auto bulk = static_cast<Real>(material.bulk_modulus);
      if (!layout.shear_share.empty()) {
        shear *= layout.shear_share[layout.patch_point[e]];
        bulk *= layout.bulk_share[layout.patch_point[e]];
      }
      sum += layout.patch_share[e] / bulk;
      if (e == layout.patch_begin[i] || shear < least) least = shear;
    }
    materials.patch_bulk[i] = sum > 0 ? 1 / sum : 0;
    materials.patch_shear[i] = least;
    if (sum > 0) least_ratio = std::min(least_ratio, least * sum);
  }
  materials.pressed_dilatation = -static_cast<Real>(pressed_from * pressure_limit) * least_ratio;
}

template <class Real>
KernelLayoutOf<Real> makeKernelLayout(const ShapeTable& shape, const std::vector<Vec3>& point_X,
                                      const std::vector<double>& volume, const std::vector<int>& point_material,
                                      const std::vector<Material>& materials, int node_count,
                                      const NodePatches& patches, GradientPrecision gradients,
                                      const std::vector<Vec3>& X, const std::vector<int>& base) {
  const bool rounded = gradients == GradientPrecision::Int16;
  if (rounded && (sizeof(Real) != 4 || static_cast<int>(X.size()) != node_count))
    throw std::invalid_argument("16-bit gradients need a float kernel and the nodes' positions");
  KernelLayoutOf<Real> layout;
  layout.node_count = node_count;
  layout.point_count = static_cast<int>(point_X.size());
  std::vector<int> computed_as = point_material;
  for (int& m : computed_as) m = base.empty() ? m : base[m];
  layout.point = batchOrder(shape, point_X, computed_as, static_cast<int>(materials.size()), layout.batch_material);
  const bool short_nodes = sizeof(Real) == 4 && node_count <= 65536;

  int tile_count = 0, rounded_count = 0;
  std::vector<int> place(static_cast<std::size_t>(node_count), -1), nodes;
  BlockGradients gradN;
  for (std::size_t first = 0; first < layout.point.size(); first += 4) {
    const int* point = &layout.point[first];
    findUnion(shape, point, place, nodes);
    if (rounded && nodes.size() >= 4) anchorsFirst(nodes, X);
    gatherGradients(shape, point, nodes, place, gradN);
    // Padding repeats the block's first nodes, whose forces were stored long before: a repeat of the
    // last one would wait for its store.
    for (int k = 0; nodes.size() % 4 != 0; ++k) nodes.push_back(nodes[k]);
    const int groups = static_cast<int>(nodes.size() / 4);
    layout.blocks.push_back({tile_count, rounded_count, groups});
    tile_count += groups;
    rounded_count += std::max(groups - 1, 0);
    if (short_nodes)
      for (int n : nodes) layout.short_node.push_back(static_cast<std::uint16_t>(n));
    else
      layout.node.insert(layout.node.end(), nodes.begin(), nodes.end());
    for (int p = 0; p < 4; ++p) layout.volume.push_back(point[p] < 0 ? Real(0) : static_cast<Real>(volume[point[p]]));
    if constexpr (std::is_same_v<Real, float>)
      if (rounded) {
        addRoundedTiles(layout, nodes, gradN, X);
        continue;
      }
    appendTiles(layout.gradN, 0, nodes.size(), [&](std::size_t n, int p, int b) {
      return n < gradN.size() ? static_cast<Real>(gradN[n][p][b]) : Real(0);
    });
  }

  layout.gradN.shrink_to_fit();  // they have grown to twice of what they hold
  layout.rounded_gradN.shrink_to_fit();

  if (!base.empty()) addShares(layout, point_material, base, materials);
  if (!patches.empty()) addPatches(layout, volume, patches);
  makeChunks(layout);
  return layout;
}

template <class Real>
KernelScratchOf<Real> makeKernelScratch(const KernelLayoutOf<Real>& layout, InstructionSet set) {
  KernelScratchOf<Real> scratch;
  scratch.passes = &passesOf<Real>(set);
  const std::size_t chunks = layout.chunk_begin.size() - 1, nodes = static_cast<std::size_t>(layout.node_count);
  scratch.force.resize(chunks * nodes);
  scratch.report.resize(chunks);
  scratch.cof2.assign(layout.point.size(), Real(3));
  scratch.J.assign(layout.point.size(), Real(1));
  scratch.squeeze.resize(layout.point.size());
  scratch.other.resize(layout.point.size());
  if (!layout.patch_node.empty()) {
    scratch.displacement_gradient.resize(layout.batch_material.size() * 144);
    scratch.dilatation.resize(layout.point.size());
    scratch.patch_pressure.resize(layout.patch_begin.size() - 1);
    scratch.cell_volume = makeCellVolumeScratch(layout.cell_volume, static_cast<int>(chunks));
  }
  return scratch;
}

template KernelMaterialsOf<float> makeKernelMaterials(const KernelLayoutOf<float>&, std::vector<Material>);
template void updatePatchBulk(const KernelLayoutOf<float>&, KernelMaterialsOf<float>&);
template KernelLayoutOf<float> makeKernelLayout(const ShapeTable&, const std::vector<Vec3>&, const std::vector<double>&,
                                                const std::vector<int>&, const std::vector<Material>&, int,
                                                const NodePatches&, GradientPrecision, const std::vector<Vec3>&,
                                                const std::vector<int>&);
template KernelScratchOf<float> makeKernelScratch(const KernelLayoutOf<float>&, InstructionSet);
template KernelMaterialsOf<double> makeKernelMaterials(const KernelLayoutOf<double>&, std::vector<Material>);
template void updatePatchBulk(const KernelLayoutOf<double>&, KernelMaterialsOf<double>&);
template KernelLayoutOf<double> makeKernelLayout(const ShapeTable&, const std::vector<Vec3>&,
                                                 const std::vector<double>&, const std::vector<int>&,
                                                 const std::vector<Material>&, int, const NodePatches&,
                                                 GradientPrecision, const std::vector<Vec3>&, const std::vector<int>&);
template KernelScratchOf<double> makeKernelScratch(const KernelLayoutOf<double>&, InstructionSet);

}  // namespace palpate
