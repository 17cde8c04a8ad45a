#include "mechanics/essential_boundary.h"

#include <algorithm>

#include "base/float4.h"

namespace palpate {
namespace {

/// The motions at a time as u = rotation (X - axis_point) + shift, the rotation less the identity.
void evaluate(const std::vector<BoundaryMotion>& motions, double time_s, const BoundaryShifts& moved,
              std::vector<Mat3>& rotation, std::vector<Vec3>& shift) {
  for (std::size_t b = 0; b < motions.size(); ++b) {
    const double s = motions[b].curve.at(time_s, motions[b].duration);
    rotation[b] = Eigen::AngleAxisd(s * motions[b].angle, motions[b].axis).toRotationMatrix() - Mat3::Identity();
    shift[b] = s * motions[b].translation + moved.at(b);
  }
}

/// y_k = y_k - sum of the row's entries: one row of a triangular solve.
/// Four partial sums, so that the subtractions overlap; their order is fixed.
template <class Real, class RowsOf>
GroupOf<Real> lessRow(const RowsOf& rows, int k, const Real4<Real>* x, GroupOf<Real> y) {
  const Real* value = rows.value.data();
  const int* column = rows.column.data();
  const int end = rows.begin[k + 1];
  GroupOf<Real> y1{}, y2{}, y3{};
  int e = rows.begin[k];
  for (; e + 4 <= end; e += 4) {
    y -= value[e] * load(x[column[e]]);
    y1 -= value[e + 1] * load(x[column[e + 1]]);
    y2 -= value[e + 2] * load(x[column[e + 2]]);
    y3 -= value[e + 3] * load(x[column[e + 3]]);
  }
  for (; e < end; ++e) y -= value[e] * load(x[column[e]]);
  return (y + y1) + (y2 + y3);
}

/// Adds what rows [begin, end) of a set carry.
template <class Real>
void addReactions(const EssentialBoundaryOf<Real>& boundary, const typename EssentialBoundaryOf<Real>::Set& set,
                  const Real4<Real>* traction, double alpha, const BoundaryScratchOf<Real>& scratch, int begin, int end,
                  std::vector<Reaction>& reaction) {
  for (int k = begin; k < end; ++k) {
    Vec3 arm_point = set.centre[k];  // in its present place, as imposed; a free component moves it little
    for (int c = 0; c < 3; ++c)
      if (const int b = set.whole[k][c]; b >= 0 && scratch.moves[b])
        arm_point[c] +=
            scratch.rotation[b].row(c).dot(set.centre[k] - boundary.motions[b].axis_point) + scratch.shift[b][c];
    for (int c = 0; c < 3; ++c) {
      const int b = set.boundary[k][c];
      if (b < 0) continue;
      Vec3 force = Vec3::Zero();
      force[c] = set.share[k] / alpha * static_cast<double>((&traction[k].x)[c]);
      reaction[b].force += force;
      reaction[b].moment += (arm_point - boundary.motions[b].axis_point).cross(force);
    }
  }
}

}  // namespace

template <class Real>
Vec3 imposeBoundary(const EssentialBoundaryOf<Real>& boundary, double time_s, double dt, double alpha,
                    const Real* inverse_mass, const std::type_identity_t<Real4<Real>>* u, Real4<Real>* du,
                    BoundaryScratchOf<Real>& scratch, SpinTeam& team, bool again) {
  evaluate(boundary.motions, time_s, scratch.moved, scratch.rotation, scratch.shift);
  evaluate(boundary.motions, time_s - dt, scratch.moved_before, scratch.rotation_before, scratch.shift_before);
  for (std::size_t b = 0; b < boundary.motions.size(); ++b)
    scratch.moves[b] =
        boundary.motions[b].moves() || !scratch.moved.at(b).isZero(0) || !scratch.moved_before.at(b).isZero(0);
  for (auto& part : scratch.part_reaction)
    for (auto& reaction : part)
      if (!scratch.goes_on) reaction = {};

  for (std::size_t s = 0; s < boundary.sets.size(); ++s) {
    const auto& set = boundary.sets[s];
    Real4<Real>* r = scratch.rhs[s].data();
    const int n = static_cast<int>(set.node.size());
    // r = u_bar - Phi u~                                         (bracket of eq. 24)
    shareRows(team, boundary_parts, n, [&](int, int begin, int end) {
      for (int k = begin; k < end; ++k) {
        Vec3 imposed = Vec3::Zero();
        for (int c = 0; c < 3; ++c) {
          const int b = set.boundary[k][c];
          if (b < 0 || !scratch.moves[b]) continue;
          const Vec3 arm = set.X[k] - boundary.motions[b].axis_point;
          imposed[c] = scratch.rotation[b].row(c).dot(arm) + scratch.shift[b][c];
          if (!u) imposed[c] -= scratch.rotation_before[b].row(c).dot(arm) + scratch.shift_before[b][c];
        }
        GroupOf<Real> sum = load(toReal4<Real>(imposed));
        if (!u) {
          sum += load(scratch.drift[s][k]);
          if (!again) scratch.drift[s][k] = {};
        }
        sum = lessRow<Real>(set.phi, k, du, sum);
        if (u) sum = lessRow<Real>(set.phi, k, u, sum);
        store(r[k], sum);
      }
    });
    // A^-1 r = U^-1 L^-1 r, alpha T
    for (int k = 0; k < n; ++k) store(r[k], lessRow<Real>(set.l, k, r, load(r[k])));
    for (int k = n - 1; k >= 0; --k) store(r[k], set.inverse_pivot[k] * lessRow<Real>(set.u, k, r, load(r[k])));
    for (int k = 0; k < n; ++k) r[k] = {r[k].x * set.mask[0], r[k].y * set.mask[1], r[k].z * set.mask[2], 0};
    // du += M^-1 V A^-1 r                                        (eqs. 23-25)
    shareRows(team, boundary_parts, static_cast<int>(set.touched.size()), [&](int part, int begin, int end) {
      for (int t = begin; t < end; ++t) {
        const int j = set.touched[t];
        store(du[j], load(du[j]) - inverse_mass[j] * lessRow<Real>(set.spread, t, r, GroupOf<Real>{}));
      }
      const auto row = [&](int p) { return n * p / boundary_parts; };
      addReactions(boundary, set, r, alpha, scratch, row(part), row(part + 1),
                   scratch.part_reaction[static_cast<std::size_t>(part)]);
    });
  }
  for (std::size_t s = 0; s < boundary.sets.size(); ++s) {
    auto &rhs = scratch.rhs[s], &first = scratch.first[s];
    for (std::size_t k = 0; k < rhs.size() && scratch.goes_on; ++k) store(rhs[k], load(rhs[k]) + load(first[k]));
    if (again) std::copy(rhs.begin(), rhs.end(), first.begin());
  }
  scratch.goes_on = again;
  Vec3 held = Vec3::Zero();
  for (std::size_t b = 0; b < boundary.motions.size(); ++b) {
    scratch.reaction[b] = {};
    for (const auto& part : scratch.part_reaction) {
      scratch.reaction[b].force += part[b].force;
      scratch.reaction[b].moment += part[b].moment;
    }
    if (!boundary.motions[b].moves()) held += scratch.reaction[b].force;
  }
  return held;
}

void correctBoundaryDrift(const EssentialBoundary& boundary, double time_s, const Float4* u, const Float4* u_low,
                          BoundaryScratch& scratch) {
  constexpr double share = 0.1;
  evaluate(boundary.motions, time_s, scratch.moved, scratch.rotation, scratch.shift);
  for (std::size_t s = 0; s < boundary.sets.size(); ++s) {
    const auto& set = boundary.sets[s];
    for (std::size_t k = 0; k < set.node.size(); ++k) {
      Vec3 away = Vec3::Zero();  // u_bar - Phi u
      for (int c = 0; c < 3; ++c)
        if (const int b = set.boundary[k][c]; b >= 0)
          away[c] = scratch.rotation[b].row(c).dot(set.X[k] - boundary.motions[b].axis_point) + scratch.shift[b][c];
      for (int e = set.phi.begin[k]; e < set.phi.begin[k + 1]; ++e) {
        const int j = set.phi.column[e];
        away -= static_cast<double>(set.phi.value[e]) * (toVec3(u[j]) + toVec3(u_low[j]));
      }
      scratch.drift[s][k] = toFloat4(share * away);
    }
  }
}

template <class Real>
void addNodeReactions(const EssentialBoundaryOf<Real>& boundary, const BoundaryScratchOf<Real>& scratch, double alpha,
                      std::vector<Vec3>& force) {
  for (std::size_t s = 0; s < boundary.sets.size(); ++s) {
    const auto& set = boundary.sets[s];
    for (std::size_t k = 0; k < set.node.size(); ++k)
      for (int c = 0; c < 3; ++c) {
        const double traction =
            static_cast<double>(set.mask[c]) * set.share[k] / alpha * static_cast<double>((&scratch.rhs[s][k].x)[c]);
        if (set.node[k] >= 0)
          force[set.node[k]][c] += traction;
        else  // a point between the nodes
          for (int e = set.phi.begin[k]; e < set.phi.begin[k + 1]; ++e)
            force[set.phi.column[e]][c] += static_cast<double>(set.phi.value[e]) * traction;
      }
  }
}

#define PALPATE_INSTANTIATE(Real)                                                                            \
  template Vec3 imposeBoundary(const EssentialBoundaryOf<Real>&, double, double, double, const Real*,        \
                               const Real4<Real>*, Real4<Real>*, BoundaryScratchOf<Real>&, SpinTeam&, bool); \
  template void addNodeReactions(const EssentialBoundaryOf<Real>&, const BoundaryScratchOf<Real>&, double,   \
                                 std::vector<Vec3>&);
PALPATE_INSTANTIATE(float)
PALPATE_INSTANTIATE(double)
#undef PALPATE_INSTANTIATE

}  // namespace palpate
