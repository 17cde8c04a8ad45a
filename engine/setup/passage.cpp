#include "setup/passage.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "setup/body_points.h"

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

using Both = PassageScratch::Both;

constexpr int passage_parts = 8;  // of the work, whatever the team

/// Calls each(begin, end) for parts of [0, count).
template <class Each>
void inParts(SpinTeam* team, std::size_t count, Each each) {
  if (team == nullptr) return each(0, count);
  shareRows(*team, passage_parts, count, [&](int, std::size_t begin, std::size_t end) { each(begin, end); });
}

Both sumOf(const Passage::Rows& rows, std::size_t row, const AlignedVector<Both>& values) {
  Both sum = Both::Zero();
  for (int e = rows.begin[row]; e < rows.begin[row + 1]; ++e) sum += rows.weight[e] * values[rows.node[e]];
  return sum;
}

void setDisplacement(const Vec3& u, std::size_t i, State& state) {
  state.u[i] = toFloat4(u);
  state.u_low[i] = toFloat4(u - toVec3(state.u[i]));
}

/// What the sweeps change of the parameters of passage.node, into scratch.change; new nodes have the field's value.
void solve(const Passage& passage, const State& before, PassageScratch& scratch, State& state, SpinTeam* team) {
  constexpr auto relaxation = static_cast<float>(passage_relaxation);
  inParts(team, before.u.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Float4 &u = before.u[k], &du = before.du[k];
      scratch.before[k] << u.x, u.y, u.z, 0, du.x, du.y, du.z, 0;
    }
  });
  inParts(team, passage.fresh.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const auto row = static_cast<std::size_t>(passage.fresh[f]), i = static_cast<std::size_t>(passage.node[row]);
      const auto whole = [&](int k) -> Vec3 { return toVec3(before.u[k]) + toVec3(before.u_low[k]); };
      setDisplacement(fieldAt(passage.at, row, whole), i, state);
      state.du[i] = toFloat4(fieldAt(passage.at, row, [&](int k) { return toVec3(before.du[k]); }));
      const Float4 &u = state.u[i], &du = state.du[i];
      scratch.before[before.u.size() + f] << u.x, u.y, u.z, 0, du.x, du.y, du.z, 0;
    }
  });
  // m - N d with d the change, m = g - N u before it; the first sweep is d = 1.2 m.
  inParts(team, passage.node.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      scratch.missing[r] = sumOf(passage.missing, r, scratch.before);
      scratch.change[r] = relaxation * scratch.missing[r];
    }
  });
  for (int sweep = 1; sweep < passage_sweeps; ++sweep) {
    inParts(team, passage.node.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t r = begin; r < end; ++r)
        scratch.changed[r] =
            scratch.change[r] + relaxation * (scratch.missing[r] - sumOf(passage.inner, r, scratch.change));
    });
    std::swap(scratch.change, scratch.changed);
  }
}

/// All but contacts.
void carryTissue(const Place& b, const Passage& passage, const State& before, PassageScratch& scratch, State& state,
                 SpinTeam* team) {
  for (std::size_t i = 0; i < passage.from.size(); ++i) {
    const int k = passage.from[i];
    if (k < 0) continue;
    state.u[i] = before.u[k];
    state.u_low[i] = before.u_low[k];
    state.du[i] = before.du[k];
  }
  solve(passage, before, scratch, state, team);
  for (std::size_t r = 0; r < passage.node.size(); ++r) {
    const auto i = static_cast<std::size_t>(passage.node[r]);
    const Both& change = scratch.change[r];
    setDisplacement(toVec3(state.u[i]) + toVec3(state.u_low[i]) + change.head<3>().cast<double>(), i, state);
    state.du[i] = toFloat4(Vec3(toVec3(state.du[i]) + change.segment<3>(4).cast<double>()));
  }

  std::fill(state.local_mass.factor.begin(), state.local_mass.factor.end(), 1.0F);
  state.local_mass.active = before.local_mass.active;
  state.local_mass.momentum = before.local_mass.momentum;
  state.local_mass.force = before.local_mass.force;
  if (before.local_mass.active) {
    for (std::size_t i = 0; i < passage.from.size(); ++i)
      if (const int k = passage.from[i]; k >= 0) state.local_mass.factor[i] = before.local_mass.factor[k];
    for (const int r : passage.fresh) {
      float& factor = state.local_mass.factor[passage.node[r]];
      factor = 1;
      for (int e = passage.at.begin[r]; e < passage.at.begin[r + 1]; ++e)
        factor = std::max(factor, before.local_mass.factor[passage.at.node[e]]);
    }
  }

  state.tick = before.tick;
  state.step = before.step;
  state.place = b.index;
  state.region_shift = before.region_shift;
  state.tool = before.tool;
  if (state.live.kernel.materials == before.live.kernel.materials) {  // with the patches that follow from them
    state.live.friction = before.live.friction;
    state.live.loads = before.live.loads;
  } else {
    carryLive(b.model, before.live, state.live);
  }
  if (!passage.history.empty())
    inParts(team, b.model.kernel.batch_material.size(), [&](std::size_t begin, std::size_t end) {
      carryHistory(passage.history, before.relaxation, begin, end, state.relaxation);
    });
  state.energy = {};
  state.energy.relaxation_flow = before.energy.relaxation_flow;
  state.energy.relaxation_power = before.energy.relaxation_power;
}

}  // namespace

void Passage::complete(int node_count_of_a) {
  std::vector<int> row(from.size(), -1), source = from;  // of u before the sweeps: a node of A, or one that is new
  fresh.clear();
  for (std::size_t r = 0; r < node.size(); ++r) {
    row[node[r]] = static_cast<int>(r);
    if (from[node[r]] >= 0) continue;
    source[node[r]] = node_count_of_a + newCount();
    fresh.push_back(static_cast<int>(r));
  }
  missing = inner = {{0}, {}, {}};
  std::vector<std::pair<int, double>> sum;  // source, weight
  for (int r = 0; r < static_cast<int>(node.size()); ++r) {
    sum.clear();
    for (int e = at.begin[r]; e < at.begin[r + 1]; ++e) sum.emplace_back(at.node[e], at.N[e]);
    for (int e = own.begin[r]; e < own.begin[r + 1]; ++e) {
      const int j = own.node[e];
      if (row[j] >= 0) {
        inner.node.push_back(row[j]);
        inner.weight.push_back(static_cast<float>(own.N[e]));
      }
      sum.emplace_back(source[j], -own.N[e]);
    }
    inner.end();
    std::stable_sort(sum.begin(), sum.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
    for (std::size_t e = 0; e < sum.size();) {
      const int k = sum[e].first;
      double weight = 0;
      for (; e < sum.size() && sum[e].first == k; ++e) weight += sum[e].second;
      if (weight == 0) continue;
      missing.node.push_back(k);
      missing.weight.push_back(static_cast<float>(weight));
    }
    missing.end();
  }
}

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
  std::vector<int> body;
  for (int i = 0; i < b.model.nodeCount(); ++i) {
    const int k = passage.from[i];
    if (k >= 0 && sameRow(a.model, k, b.model, i, passage.from)) continue;
    passage.node.push_back(i);
    moved.push_back(b.model.X[i]);
    body.push_back(b.model.bodyOfNode(i));
    passage.own.appendValues(b.model.node_shape, i);
  }
  const ShapeTable shape = shapeAt(a.model, moved, body);
  for (std::size_t r = 0; r < passage.node.size(); ++r) {
    const int k = passage.from[passage.node[r]];
    if (k >= 0 && (a.model.X[k] - moved[r]).norm() <= same_place)
      passage.at.appendValues(a.model.node_shape, k);  // at borders between materials a node's own parameter
    else
      passage.at.appendValues(shape, static_cast<int>(r));
  }
  passage.complete(a.model.nodeCount());
  passage.history = makeHistoryPassage(a.model, b.model);
  return passage;
}

void carryLive(const Model& b, const LiveParameters& before, LiveParameters& live) {
  live.friction = before.friction;
  live.loads = before.loads;
  const std::size_t patches = b.kernel.patch_begin.empty() ? 0 : b.kernel.patch_begin.size() - 1;
  live.kernel.patch_bulk.resize(patches);
  live.kernel.patch_shear.resize(patches);
  live.kernel.materials = before.kernel.materials;
  updatePatchBulk(b.kernel, live.kernel);
}

void applyPassage(const Place& b, const Passage& passage, const State& before, PassageScratch& scratch, State& state,
                  SpinTeam* team) {
  carryTissue(b, passage, before, scratch, state, team);
  state.contact = before.contact;
  state.skins = before.skins;
  state.rigid.force = before.rigid.force;
  state.rigid.normal = before.rigid.normal;
  state.rigid.lookAgain();
}

void applyPassage(const Place& b, const Passage& passage, State&& before, PassageScratch& scratch, State& state,
                  SpinTeam* team) {
  carryTissue(b, passage, before, scratch, state, team);
  swapContacts(state, before);
  state.rigid.lookAgain();
}

void swapContacts(State& a, State& b) {
  std::swap(a.contact, b.contact);
  std::swap(a.skins, b.skins);
  std::swap(a.rigid.force, b.rigid.force);
  std::swap(a.rigid.normal, b.rigid.normal);
}

}  // namespace palpate
