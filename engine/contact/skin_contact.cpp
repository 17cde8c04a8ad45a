#include "contact/skin_contact.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "contact/coulomb_friction.h"
#include "contact/skin_forces.h"

namespace palpate {
namespace {

using Eigen::Vector4f;
using Row = SkinContactScratch::Row;

constexpr int most_skin_sweeps = 24;
constexpr float skin_settled = 1e-4F;  // of the forces, as solveContact's

/// m, within which a pair takes part though it does not touch: forces on its neighbours may push it there.
constexpr float near_skin = 1e-4F;

/// m a step, by which what is too deep comes back at most.
constexpr float skin_return = 2e-5F;

Vector4f forceOf(const Float4& a) { return {a.x, a.y, a.z, 0}; }

/// A field at the row's vertex, that at the face's point taken off.
Vector4f difference(const SkinContactScratch& scratch, const Row& row, const Float4* field) {
  Group even{}, odd{};
  int e = row.begin;
  for (; e + 2 <= row.end; e += 2) {
    even += scratch.N[e] * load(field[scratch.node[e]]);
    odd += scratch.N[e + 1] * load(field[scratch.node[e + 1]]);
  }
  if (e < row.end) even += scratch.N[e] * load(field[scratch.node[e]]);
  Vector4f sum;
  storeGroup(sum.data(), even + odd);
  return sum;
}

/// A force on the vertex, and its opposite on the face.
void applyPair(const SkinContactScratch& scratch, const Row& row, const Vector4f& f, float alpha,
               const float* inverse_mass, Float4* du) {
  const Group scaled = alpha * loadGroup(f.data());
  for (int e = row.begin; e < row.end; ++e) {
    Float4& increment = du[scratch.node[e]];
    store(increment, load(increment) + (scratch.N[e] * inverse_mass[scratch.node[e]]) * scaled);
  }
}

/// Solves one pair's law with all other forces held; returns the change of its force.
Vector4f updateForce(Row& row, const Vector4f& increment) {
  const float K = row.stiffness, A = row.mobility;
  const float normal_old = row.normal.dot(row.force);
  const float free = row.gap + row.normal.dot(increment - row.predicted) - A * normal_old;  // the gap without it
  const float law = -K / (1 + K * A) * free, most = (row.highest - free) / A;
  const float normal_new = std::max(0.0F, std::min(law, most));
  Vector4f force = normal_new * row.normal;
  if (row.friction > 0 && normal_new > 0) {
    const Vector4f slip = increment - row.normal.dot(increment) * row.normal;
    force += frictionForce(row.stick, slip, row.force - normal_old * row.normal, K, A, row.friction * normal_new);
  }
  const Vector4f change = force - row.force;
  row.force = force;
  return change;
}

/// The pairs that touch, or nearly. The last step's forces act from the start: the gaps are then those of where the
/// skins go.
std::size_t findActive(const SkinModel& skin, float alpha, const float* inverse_mass, const Float4* u, Float4* du,
                       SkinContactState& state, SkinContactScratch& scratch) {
  const std::span<Row> rows(scratch.row.data(), static_cast<std::size_t>(scratch.row_count));
  for (const Row& row : rows)
    if (const Vector4f f = forceOf(state.force[row.slot]); !f.isZero(0))
      applyPair(scratch, row, f, alpha, inverse_mass, du);
  std::size_t count = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    Row& row = rows[r];
    row.predicted = difference(scratch, row, du);
    const float before = row.lift + row.normal.dot(row.apart + difference(scratch, row, u));
    row.gap = before + row.normal.dot(row.predicted);
    Float4& last = state.force[row.slot];
    const Vector4f old = forceOf(last);
    if (!(row.gap < near_skin)) {  // nor where it is not a number
      if (!old.isZero(0)) applyPair(scratch, row, -old, alpha, inverse_mass, du);
      last = {};
      continue;
    }
    scratch.active[count++] = static_cast<int>(r);
    row.highest = before < 0 ? before + skin_return : 1e3F;
    row.stiffness = static_cast<float>(skin.bulk_stiffness * skin.area[state.vertex[row.slot]]);
    float response = 0;
    for (int e = row.begin; e < row.end; ++e) response += scratch.N[e] * scratch.N[e] * inverse_mass[scratch.node[e]];
    row.mobility = alpha * response;
    // Not so soft that what comes fast takes several steps to stop.
    row.stiffness = std::max(row.stiffness, 1 / row.mobility);
    const float normal_force = row.normal.dot(old);
    row.stick = old - normal_force * row.normal;
    row.force = std::max(0.0F, normal_force) * row.normal + row.stick;
    if (const Vector4f turned = row.force - old; !turned.isZero(0))
      applyPair(scratch, row, turned, alpha, inverse_mass, du);
  }
  return count;
}

}  // namespace

SkinContact solveSkinContact(const SkinModel& skin, double alpha, const float* inverse_mass, const Float4* u,
                             Float4* du, SkinContactState& state, SkinContactScratch& scratch) {
  const auto alpha_f = static_cast<float>(alpha);
  const std::size_t count = findActive(skin, alpha_f, inverse_mass, u, du, state, scratch);
  bool settled = count == 0;
  for (int sweep = 0; sweep < most_skin_sweeps && !settled; ++sweep) {
    float changed = 0, size = 0;
    for (std::size_t k = 0; k < count; ++k) {
      Row& row = scratch.row[static_cast<std::size_t>(scratch.active[sweep % 2 == 0 ? k : count - 1 - k])];
      const Vector4f change = updateForce(row, difference(scratch, row, du));
      size += row.force.squaredNorm();
      if (change.isZero(0)) continue;
      changed += change.squaredNorm();
      applyPair(scratch, row, change, alpha_f, inverse_mass, du);
    }
    settled = changed <= skin_settled * skin_settled * size;
  }
  SkinContact contact;
  for (std::size_t k = 0; k < count; ++k) {
    const Row& row = scratch.row[static_cast<std::size_t>(scratch.active[k])];
    store(state.force[row.slot], loadGroup(row.force.data()));
    if (row.force.isZero(0)) continue;
    ++contact.count;
    const Vector4f moved = difference(scratch, row, du) - row.predicted;
    contact.max_penetration = std::max(contact.max_penetration, -static_cast<double>(row.gap + row.normal.dot(moved)));
  }
  contact.overflow = scratch.overflow;
  return contact;
}

Vec3 skinForceOn(const SkinBodies& bodies, const SkinModel& skin, int organ, const SkinContactState& state) {
  const auto isOf = [&](int vertex) { return bodies.organ[bodies.body[vertex]] == organ; };
  Vec3 force = Vec3::Zero();
  for (int k = 0; k < state.count; ++k) {
    const Vec3 f = toVec3(state.force[k]);
    if (isOf(state.vertex[k])) force += f;
    if (isOf(skin.surface.triangles[state.face[k]][0])) force -= f;
  }
  return force;
}

}  // namespace palpate
