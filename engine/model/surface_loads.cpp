#include "model/surface_loads.h"

namespace palpate {
namespace {

/// Runs each(k) for k in [0, count): whole parts on the team's members, divided by the count alone, so that no result
/// depends on the threads.
template <class Each>
void forAll(SpinTeam& team, std::size_t count, Each each) {
  constexpr std::size_t several = 8, small = 512;  // parts; what one thread does sooner than it wakes others
  const std::size_t all = count < small ? 1 : several;
  const auto run = [&](int part) {
    const auto p = static_cast<std::size_t>(part);
    for (std::size_t k = count * p / all; k < count * (p + 1) / all; ++k) each(k);
  };
  if (all == 1)
    run(0);
  else
    shareOut(team, static_cast<int>(all), run);
}

template <class Real>
Double4 placeOf(const SurfaceLoads& loads, const Real4<Real>* u, std::size_t v) {
  GroupOf<Real> even{}, odd{};
  int e = loads.begin[v];
  const int end = loads.begin[v + 1];
  for (; e + 2 <= end; e += 2) {
    even += static_cast<Real>(loads.N[e]) * load(u[loads.node[e]]);
    odd += static_cast<Real>(loads.N[e + 1]) * load(u[loads.node[e + 1]]);
  }
  if (e < end) even += static_cast<Real>(loads.N[e]) * load(u[loads.node[e]]);
  Double4 x;
  store(x, load(toReal4<double>(loads.X[v])) + __builtin_convertvector(even + odd, GroupOf<double>));
  return x;
}

}  // namespace

template <class Real>
void evaluate(const SurfaceLoads& loads, double time, const Real4<Real>* u, SurfaceLoadScratchOf<Real>& scratch,
              SpinTeam& team) {
  for (std::size_t k = 0; k < loads.course.size(); ++k)
    scratch.share[k] = static_cast<Real>(loads.course[k].curve.at(time, loads.course[k].duration));
  if (loads.face.empty()) return;
  forAll(team, loads.X.size(), [&](std::size_t v) { scratch.x[v] = placeOf(loads, u, v); });
  forAll(team, loads.face.size(), [&](std::size_t f) {
    const SurfaceLoads::Face& face = loads.face[f];
    const Vec3 x0 = toVec3(scratch.x[face.vertex[0]]);
    const Vec3 area = 0.5 * (toVec3(scratch.x[face.vertex[1]]) - x0).cross(toVec3(scratch.x[face.vertex[2]]) - x0);
    scratch.g[f] = toReal4<Real>(-static_cast<double>(scratch.share[face.load]) * loads.pressure[face.load] * area);
  });
}

template <class Real>
std::vector<Vec3> loadForces(const SurfaceLoads& loads, const SurfaceLoadScratchOf<Real>& scratch) {
  std::vector<Vec3> sum;
  for (std::size_t k = 0; k < loads.dead_force.size(); ++k)
    sum.emplace_back(static_cast<double>(scratch.share[k]) * loads.dead_force[k]);
  for (std::size_t f = 0; f < loads.face.size(); ++f)
    sum[loads.face[f].load] += static_cast<double>(loads.face[f].share) * toVec3(scratch.g[f]);
  return sum;
}

template void evaluate(const SurfaceLoads&, double, const Real4<float>*, SurfaceLoadScratchOf<float>&, SpinTeam&);
template void evaluate(const SurfaceLoads&, double, const Real4<double>*, SurfaceLoadScratchOf<double>&, SpinTeam&);
template std::vector<Vec3> loadForces(const SurfaceLoads&, const SurfaceLoadScratchOf<float>&);
template std::vector<Vec3> loadForces(const SurfaceLoads&, const SurfaceLoadScratchOf<double>&);

}  // namespace palpate
