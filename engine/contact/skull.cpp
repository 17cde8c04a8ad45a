#include "contact/skull.h"

#include <algorithm>
#include <cmath>

#include "contact/skin_forces.h"

namespace palpate {
namespace {

using Eigen::Vector4f;

constexpr int most_sweeps = 8;
constexpr float settled_change = 1e-4F;  // of the forces, as solveContact's

/// m, within which a point takes part though it does not touch: forces on its neighbours may push it there.
constexpr double near_gap = 1e-5;

/// m a step, by which a point that is outside comes back at most.
constexpr double fastest_return = 2e-5;

Vector4f lanesOf(const Float4& a) { return {a.x, a.y, a.z, 0}; }

/// Solves one point's law with all other forces held; returns the change of its force.
float updateRow(SkullState::Row& row, const Vector4f& increment) {
  const float K = row.stiffness, A = row.mobility;
  const float now = row.gap + row.normal.dot(increment - row.predicted);
  const float free = now - A * row.force;  // the gap without this force
  const float law = -K / (1 + K * A) * free, most = (row.highest - free) / A;
  const float force = std::max(0.0F, std::min(law, most));
  const float change = force - row.force;
  row.force = force;
  return change;
}

/// The points that touch, or nearly, as rows; the last step's forces act from the start, turned with the shell.
int findRows(const Skull& skull, const SkinModel& skin, float alpha, const float* inverse_mass, const Float4* u,
             Float4* du, SkullState& state) {
  for (int p = 0; p < skull.pointCount(); ++p)
    if (const Vector4f f = lanesOf(state.force[p]); !f.isZero(0))
      applyForce(skin, skull.vertex[p], f, alpha, inverse_mass, du);
  int count = 0;
  for (int p = 0; p < skull.pointCount(); ++p) {
    const int v = skull.vertex[p];
    const Vec3 start = skinPosition(skin, v, u);
    const Vector4f predicted = interpolateAtVertex(skin, v, du), old = lanesOf(state.force[p]);
    const Vec3 way = predicted.head<3>().cast<double>();
    Vec3 normal, normal_before;
    double gap = skull.at(start + way, normal);
    const bool known = gap < static_cast<double>(Skull::away);
    double before = known && !(gap + skull.correction[p] < near_gap) ? gap : skull.at(start, normal_before);
    if (!known && before < static_cast<double>(Skull::away)) {  // a long step: as if the shell went on straight
      normal = normal_before.normalized();
      gap = before + normal.dot(way);
    }
    if (!(before < static_cast<double>(Skull::away))) before = gap;  // it comes back from far out: slowly
    gap += skull.correction[p];
    before += skull.correction[p];
    if (!(gap < near_gap)) {  // nor where it is not a number
      if (!old.isZero(0)) applyForce(skin, v, -old, alpha, inverse_mass, du);
      state.force[p] = {};
      continue;
    }
    SkullState::Row& row = state.row[count++];
    row.point = p;
    row.normal << normal.normalized().cast<float>(), 0;
    row.predicted = predicted;
    row.gap = static_cast<float>(gap);
    row.highest = before < 0 ? static_cast<float>(before + fastest_return) : Skull::away;
    row.stiffness = static_cast<float>(skull.stiffness) * skull.area[p];
    row.mobility = alpha * compliance(skin, v, inverse_mass);
    row.force = std::max(0.0F, row.normal.dot(old));
    const Vector4f turned = row.force * row.normal - old;
    if (!turned.isZero(0)) applyForce(skin, v, turned, alpha, inverse_mass, du);
  }
  return count;
}

}  // namespace

double Skull::at(const Vec3& x, Vec3& normal) const {
  const Vec3 index = (x - origin) / cell;
  normal = Vec3::UnitZ();
  int low[3];
  for (int a = 0; a < 3; ++a) {
    if (!(index[a] >= 0 && index[a] < count[static_cast<std::size_t>(a)] - 1)) return static_cast<double>(away);
    low[a] = static_cast<int>(index[a]);
  }
  const double r = index[0] - low[0], s = index[1] - low[1], t = index[2] - low[2];
  const auto row = static_cast<std::size_t>(count[0]), plane = row * static_cast<std::size_t>(count[1]);
  const float* g =
      gap.data() + static_cast<std::size_t>(low[2]) * plane + static_cast<std::size_t>(low[1]) * row + low[0];
  double c[2][2][2];  // z, y, x
  for (std::size_t k = 0; k < 2; ++k)
    for (std::size_t j = 0; j < 2; ++j)
      for (std::size_t i = 0; i < 2; ++i) {
        const float value = g[k * plane + j * row + i];
        if (value >= away) return static_cast<double>(away);
        c[k][j][i] = static_cast<double>(value);
      }
  const auto mix = [](double a, double b, double share) { return a + share * (b - a); };
  const auto alongX = [&](const double(&face)[2][2]) {
    return mix(face[0][1] - face[0][0], face[1][1] - face[1][0], s);
  };
  const auto line = [&](int k, int j) { return mix(c[k][j][0], c[k][j][1], r); };
  normal.x() = mix(alongX(c[0]), alongX(c[1]), t);
  normal.y() = mix(line(0, 1) - line(0, 0), line(1, 1) - line(1, 0), t);
  const double lower = mix(line(0, 0), line(0, 1), s), upper = mix(line(1, 0), line(1, 1), s);
  normal.z() = upper - lower;
  if (normal.squaredNorm() < 1e-6 * cell * cell) return static_cast<double>(away);  // between two walls
  const double value = mix(lower, upper, t);
  return value < -farthest_out ? static_cast<double>(away) : value;
}

SkullState makeSkullState(const Skull& skull) {
  SkullState state;
  state.force.assign(skull.vertex.size(), Float4{});
  state.row.resize(skull.vertex.size());
  return state;
}

SkullContact solveSkull(const Skull& skull, const SkinModel& skin, double alpha, const float* inverse_mass,
                        const Float4* u, Float4* du, SkullState& state) {
  const auto alpha_f = static_cast<float>(alpha);
  const int count = findRows(skull, skin, alpha_f, inverse_mass, u, du, state);
  bool settled = count == 0;
  for (int sweep = 0; sweep < most_sweeps && !settled; ++sweep) {
    float changed = 0, size = 0;
    for (int k = 0; k < count; ++k) {
      SkullState::Row& row = state.row[static_cast<std::size_t>(sweep % 2 == 0 ? k : count - 1 - k)];
      const int v = skull.vertex[row.point];
      const float change = updateRow(row, interpolateAtVertex(skin, v, du));
      size += row.force * row.force;
      if (change == 0) continue;
      changed += change * change;
      applyForce(skin, v, change * row.normal, alpha_f, inverse_mass, du);
    }
    settled = changed <= settled_change * settled_change * size;
  }
  SkullContact contact;
  for (int k = 0; k < count; ++k) {
    const SkullState::Row& row = state.row[static_cast<std::size_t>(k)];
    const Vector4f force = row.force * row.normal;
    store(state.force[row.point], loadGroup(force.data()));
    contact.force += force.head<3>().cast<double>();
    contact.count += row.force > 0;
    const Vector4f moved = interpolateAtVertex(skin, skull.vertex[row.point], du) - row.predicted;
    contact.max_penetration = std::max(contact.max_penetration, -static_cast<double>(row.gap + row.normal.dot(moved)));
  }
  return contact;
}

}  // namespace palpate
