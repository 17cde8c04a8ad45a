#include "contact/skin_rows.h"

#include <algorithm>

#include "contact/skin_forces.h"

namespace palpate {
namespace {

using Eigen::Vector4f;
using Row = SkinContactScratch::Row;

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

/// Of a vertex's to a force on itself, that it has to one between it and what it touches.
constexpr float least_response = 0.01F;

}  // namespace

SkinRows::SkinRows(const ContactStep& step, SkinContactState* state, SkinContactScratch* scratch)
    : step_(step), state_(state), scratch_(scratch) {
  if (state_ == nullptr) return;
  for (const Row& row : rows()) push(row, lanesOf(state_->force[row.slot]));
}

std::span<Row> SkinRows::rows() const { return {scratch_->row.data(), static_cast<std::size_t>(scratch_->row_count)}; }

/// A force on the vertex, and its opposite on the face.
void SkinRows::push(const Row& row, const Vector4f& f) const {
  if (f.isZero(0)) return;
  const Group scaled = step_.alpha * loadGroup(f.data());
  for (int e = row.begin; e < row.end; ++e) {
    const int node = scratch_->node[e];
    store(step_.du[node], load(step_.du[node]) + (scratch_->N[e] * step_.inverse_mass[node]) * scaled);
  }
}

std::size_t SkinRows::makeRows() {
  if (state_ == nullptr) return 0;
  for (Row& row : rows()) {
    row.predicted = difference(*scratch_, row, step_.du);
    const float before = row.lift + row.normal.dot(row.apart + difference(*scratch_, row, step_.u));
    row.gap = before + row.normal.dot(row.predicted);
    Float4& last = state_->force[row.slot];
    const Vector4f old = lanesOf(last);
    const int vertex = state_->vertex[row.slot];
    float response = 0;
    for (int e = row.begin; e < row.end; ++e)
      response += scratch_->N[e] * scratch_->N[e] * step_.inverse_mass[scratch_->node[e]];
    // Nor where it is not a number, nor what the same nodes move, as at a slit's tip.
    if (!(row.gap < near_gap) || !(response > least_response * compliance(step_.skin, vertex, step_.inverse_mass))) {
      push(row, -old);
      last = {};
      continue;
    }
    scratch_->active[active_++] = static_cast<int>(&row - scratch_->row.data());
    row.highest = before < 0 ? before + fastest_return : 1e3F;
    row.stiffness = layerStiffness(step_, vertex, static_cast<double>(row.area));
    row.mobility = step_.alpha * response;
    // Not so soft that what comes fast takes several steps to stop.
    row.stiffness = std::max(row.stiffness, 1 / row.mobility);
    const float normal_force = row.normal.dot(old);
    row.stick = old - normal_force * row.normal;
    row.force = std::max(0.0F, normal_force) * row.normal + row.stick;
    push(row, row.force - old);
  }
  return active_;
}

bool SkinRows::sweep(bool forwards) {
  const auto rowAt = [&](std::size_t k) -> Row& { return scratch_->row[active(k)]; };
  const auto pushRow = [&](const Row& row, const Vector4f& f) { push(row, f); };
  sweeps_.goOn(active_, rowAt, pushRow);
  sweeps_.sweepRows(
      active_, forwards, rowAt, [&](const Row& row) { return difference(*scratch_, row, step_.du); }, pushRow);
  return sweeps_.end(step_.settled);
}

SkinContact SkinRows::finish() {
  SkinContact contact;
  if (state_ == nullptr) return contact;
  for (std::size_t k = 0; k < active_; ++k) {
    const Row& row = scratch_->row[active(k)];
    store(state_->force[row.slot], loadGroup(row.force.data()));
    if (row.force.isZero(0)) continue;
    ++contact.count;
    contact.max_penetration = std::max(contact.max_penetration, static_cast<double>(row.penetration));
  }
  contact.overflow = scratch_->overflow;
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
