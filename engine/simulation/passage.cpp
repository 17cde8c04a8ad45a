#include "simulation/passage.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "simulation/body_points.h"

namespace palpate {
namespace {

/// Whether node i of B has the row of N that node k of A has, as far as a force can tell.
bool sameRow(const Model& a, int k, const Model& b, int i, const std::vector<int>& from) {
  if ((a.X[k] - b.X[i]).norm() > same_place) return false;
  const ShapeTable &A = a.node_shape, &B = b.node_shape;
  const int count = B.begin[i + 1] - B.begin[i];
  if (A.begin[k + 1] - A.begin[k] != count) return false;
  for (int e = 0; e < count; ++e) {
    const int p = A.begin[k] + e, q = B.begin[i] + e;
    if (from[B.node[q]] != A.node[p] || std::abs(A.N[p] - B.N[q]) > same_N) return false;
  }
  return true;
}

/// A row of a table at the end of another.
void addRow(const ShapeTable& table, int row, ShapeTable& rows) {
  if (rows.begin.empty()) rows.begin.push_back(0);
  rows.node.insert(rows.node.end(), table.node.begin() + table.begin[row], table.node.begin() + table.begin[row + 1]);
  rows.N.insert(rows.N.end(), table.N.begin() + table.begin[row], table.N.begin() + table.begin[row + 1]);
  rows.begin.push_back(static_cast<int>(rows.node.size()));
}

Vec3 vectorOf(const Float4& a) { return {a.x, a.y, a.z}; }

/// Field values at the passage's rows from A's parameters, then B's parameters.
/// @param parameter  k -> A's, m
template <class Parameter>
void carry(const Passage& passage, const Parameter& parameter, PassageScratch& scratch) {
  const std::size_t rows = passage.node.size();
  for (std::size_t r = 0; r < rows; ++r) {
    Vec3 g = Vec3::Zero();
    for (int e = passage.at.begin[r]; e < passage.at.begin[r + 1]; ++e)
      g += passage.at.N[e] * parameter(passage.at.node[e]);
    scratch.wanted[r] = g;
  }
  for (std::size_t i = 0; i < passage.from.size(); ++i)
    if (passage.from[i] >= 0) scratch.values[i] = parameter(passage.from[i]);
  for (std::size_t r = 0; r < rows; ++r)
    if (passage.from[passage.node[r]] < 0) scratch.values[passage.node[r]] = scratch.wanted[r];
  for (int sweep = 0; sweep < passage_sweeps; ++sweep) {
    for (std::size_t r = 0; r < rows; ++r) {
      Vec3 g = scratch.wanted[r];
      for (int e = passage.own.begin[r]; e < passage.own.begin[r + 1]; ++e)
        g -= passage.own.N[e] * scratch.values[passage.own.node[e]];
      scratch.change[r] = passage_relaxation * g;
    }
    for (std::size_t r = 0; r < rows; ++r) scratch.values[passage.node[r]] += scratch.change[r];
  }
}

}  // namespace

int Passage::newCount() const { return static_cast<int>(std::count(from.begin(), from.end(), -1)); }

Passage makePassage(const Place& a, const Place& b) {
  Passage passage;
  passage.from.assign(b.node.size(), -1);
  for (std::size_t i = 0, k = 0; i < b.node.size(); ++i) {
    while (k < a.node.size() && a.node[k] < b.node[i]) ++k;
    if (k < a.node.size() && a.node[k] == b.node[i]) passage.from[i] = static_cast<int>(k);
  }
  passage.at.begin.push_back(0);
  passage.own.begin.push_back(0);
  std::vector<Vec3> moved;
  for (int i = 0; i < b.model.nodeCount(); ++i) {
    const int k = passage.from[i];
    if (k >= 0 && sameRow(a.model, k, b.model, i, passage.from)) continue;
    passage.node.push_back(i);
    moved.push_back(b.model.X[i]);
    addRow(b.model.node_shape, i, passage.own);
  }
  std::vector<InadmissibleSupport> failed;
  const ShapeTable shape = shapeAt(a.model, moved, failed);
  if (!failed.empty()) throw std::runtime_error("a node of a place lies where the other has no approximation");
  for (std::size_t r = 0; r < passage.node.size(); ++r) {
    const int k = passage.from[passage.node[r]];
    if (k >= 0 && (a.model.X[k] - moved[r]).norm() <= same_place)
      addRow(a.model.node_shape, k, passage.at);  // at borders between materials a node's own parameter
    else
      addRow(shape, static_cast<int>(r), passage.at);
  }
  return passage;
}

void applyPassage(const Place& a, const Place& b, const Passage& passage, const State& before, PassageScratch& scratch,
                  State& state) {
  carry(
      passage, [&](int k) -> Vec3 { return vectorOf(before.u[k]) + vectorOf(before.u_low[k]); }, scratch);
  for (std::size_t i = 0; i < passage.from.size(); ++i) {
    const Vec3& u = scratch.values[i];
    state.u[i] = toFloat4(u);
    state.u_low[i] = toFloat4(u - vectorOf(state.u[i]));
  }
  for (std::size_t i = 0; i < passage.from.size(); ++i)
    if (const int k = passage.from[i]; k >= 0 && vectorOf(state.u[i]) == vectorOf(before.u[k]))
      state.u_low[i] = before.u_low[k];
  carry(
      passage, [&](int k) -> Vec3 { return vectorOf(before.du[k]); }, scratch);
  for (std::size_t i = 0; i < passage.from.size(); ++i) state.du[i] = toFloat4(scratch.values[i]);

  state.local_mass.active = before.local_mass.active;
  state.local_mass.momentum = before.local_mass.momentum;
  state.local_mass.force = before.local_mass.force;
  for (std::size_t i = 0; i < passage.from.size(); ++i)
    if (const int k = passage.from[i]; k >= 0) state.local_mass.factor[i] = before.local_mass.factor[k];
  for (std::size_t r = 0; r < passage.node.size(); ++r) {
    float& factor = state.local_mass.factor[passage.node[r]];
    if (passage.from[passage.node[r]] >= 0) continue;
    factor = 1;
    for (int e = passage.at.begin[r]; e < passage.at.begin[r + 1]; ++e)
      factor = std::max(factor, before.local_mass.factor[passage.at.node[e]]);
  }

  state.tick = before.tick;
  state.step = before.step;
  state.tool_pose = before.tool_pose;
  state.contact = before.contact;
  state.more = before.more;
  state.skull = before.skull;
  state.live.friction = before.live.friction;
  state.live.loads = before.live.loads;
  state.region_shift = before.region_shift;
  for (std::size_t m = 0; m < a.model.materials.size(); ++m)
    setMaterial(b.model, static_cast<int>(m), before.live.kernel.materials[m], state.live);
  state.energy = {};
}

}  // namespace palpate
