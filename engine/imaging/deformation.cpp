#include "imaging/deformation.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "approximation/mmls_value.h"
#include "approximation/shape_functions.h"
#include "base/parallel_for.h"

namespace palpate {
namespace {

/// How far from a bin a start is looked for: tissue stretched to thrice its length leaves such gaps.
constexpr int farthest_seed = 3;

/// Newton's method ends with a step from a residual below this, m. That step leaves |d^2u/dX^2| r^2: of a field that
/// changes by its own slope of 1 within 2 mm less than 1e-8 m, a hundredth of what is promised.
constexpr double last_step = 3e-6;

/// Residual after which one more step is the last by values of the whole field, m, and how often these are asked for at
/// most. The sampled slopes may be off by a third: the last step leaves a third of it.
constexpr double polished = 1e-5;
constexpr int max_polishings = 3;

/// Side of the cubes whose points share a list of nodes that may reach them, in least radii: smaller cubes are filled
/// more often, larger ones' lists have more nodes that are too far. A cube has some ten samples, hundreds of voxels.
constexpr double cube_side = 0.35;

/// Cubes that a thread keeps: a slab of them through a brain.
constexpr std::size_t kept_cubes = 2048;

std::atomic<std::uint64_t> deformation_count{0};

/// Radii of nodes by which they reach the middles of all cubes whose points they reach.
std::vector<double> reachOf(std::vector<double> radius, double side) {
  for (double& r : radius) r += std::sqrt(0.75) * side * (1 + 1e-9);
  return radius;
}

/// Iterations after which Newton's method from a sample nearby gives up.
constexpr int patient = 30;

}  // namespace

MmlsDeformation::MmlsDeformation(std::vector<Vec3> X, std::vector<double> radius, std::vector<Vec3> u,
                                 const MmlsOptions& options, TriangleSurface surface)
    : X_(std::move(X)),
      u_(std::move(u)),
      radius_(std::move(radius)),
      options_(options),
      neighbours_(X_, radius_),
      side_(radius_.empty() ? 1 : cube_side * *std::min_element(radius_.begin(), radius_.end())),
      reach_(reachOf(radius_, side_)),
      in_reach_(X_, reach_),
      number_(++deformation_count),
      surface_(std::move(surface)) {}

bool MmlsDeformation::at(const Vec3& X, Vec3& u, Mat3& gradient) const {
  struct Scratch {
    std::vector<int> support;
    std::vector<Vec3> X;
    std::vector<double> radius;
  };
  static thread_local Scratch s;
  Mmls<3> mmls(options_);
  neighbours_.find(X, s.support);
  if (s.support.size() < 4) return false;
  s.X.clear();
  s.radius.clear();
  for (const int j : s.support) {
    s.X.push_back(X_[static_cast<std::size_t>(j)]);
    s.radius.push_back(radius_[static_cast<std::size_t>(j)]);
  }
  if (!mmls.evaluate(X, s.X.data(), s.radius.data(), static_cast<int>(s.support.size()))) return false;
  if (!AdmissibilityLimits{}.admit(mmls.quality())) return false;
  u.setZero();
  gradient.setZero();
  for (std::size_t n = 0; n < s.support.size(); ++n) {
    const Vec3& u_j = u_[static_cast<std::size_t>(s.support[n])];
    u += mmls.N()[n] * u_j;
    gradient += u_j * mmls.gradN()[n].transpose();
  }
  return true;
}

struct MmlsDeformation::Cube {
  std::uint64_t owner = 0;  // its number
  std::array<std::int64_t, 3> place{};
  std::vector<int> node;
};

const MmlsDeformation::Cube& MmlsDeformation::cubeAround(const Vec3& X) const {
  static thread_local std::vector<Cube> kept(kept_cubes);
  std::array<std::int64_t, 3> place;
  Vec3 middle;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto c = static_cast<Eigen::Index>(a);
    place[a] = static_cast<std::int64_t>(std::floor(X[c] / side_));
    middle[c] = (static_cast<double>(place[a]) + 0.5) * side_;
  }
  // Those of a slab 64 wide and 32 long fall in places of their own.
  Cube& cube = kept[static_cast<std::uint64_t>(place[0] + 64 * place[1] + 1009 * place[2]) % kept_cubes];
  if (cube.owner != number_ || cube.place != place) {
    in_reach_.find(middle, cube.node);
    const auto isBeyond = [&](int j) {  // of the whole cube
      const auto n = static_cast<std::size_t>(j);
      const Vec3 gap = ((X_[n] - middle).cwiseAbs().array() - 0.5 * side_).max(0.0);
      return gap.squaredNorm() > radius_[n] * radius_[n] * (1 + 1e-9);
    };
    cube.node.erase(std::remove_if(cube.node.begin(), cube.node.end(), isBeyond), cube.node.end());
    cube.owner = number_;
    cube.place = place;
  }
  return cube;
}

bool MmlsDeformation::value(const Vec3& X, Vec3& u) const {
  static thread_local std::vector<MmlsValue::Node> support;
  static thread_local MmlsValue mmls{MmlsOptions{}};
  mmls.use(options_);
  if (!X.allFinite()) return false;
  support.clear();
  for (const int j : cubeAround(X).node) {
    const auto n = static_cast<std::size_t>(j);
    if ((X_[n] - X).squaredNorm() < radius_[n] * radius_[n]) support.push_back({X_[n], radius_[n], u_[n]});
  }
  return mmls.at(X, support, u);
}

double MmlsDeformation::surfaceDistance(const Vec3& X, double other, double apart) const {
  if (std::abs(other) <= apart) return surface_.signedDistance(X);  // there may be surface between
  // A hair more than the triangle inequality says, for rounding.
  const SurfaceTree::Closest foot = surface_.closest(X, (std::abs(other) + apart) * (1 + 1e-9));
  return foot.triangle < 0 ? surface_.signedDistance(X) : std::copysign(foot.distance, other);
}

InverseDeformation::InverseDeformation(const SampledDeformation& forward) : forward_(forward) {
  const ImageGrid& grid = forward.grid();
  Box3 box;
  const auto each = [&](auto visit) {
    for (std::size_t v = 0; v < grid.voxelCount(); ++v)
      if (forward.isKnown(v) && static_cast<double>(forward.sampleDistance(v)) <= forward.step())
        visit(v, placeOf(static_cast<std::int32_t>(v)) + forward.sample(v));
  };
  each([&](std::size_t, const Vec3& x) { box.extend(x); });
  if (box.isEmpty()) box.extend(Vec3(Vec3::Zero()));
  const double step = forward.step();
  std::array<int, 3> size{};
  for (int a = 0; a < 3; ++a) size[static_cast<std::size_t>(a)] = 2 + static_cast<int>(box.sizes()[a] / step);
  bins_ = ImageGrid(size, Mat3::Identity() * step, box.min());
  std::vector<std::int32_t> own(bins_.voxelCount(), -1);
  std::vector<float> nearest(own.size(), 1e30F);
  each([&](std::size_t v, const Vec3& x) {
    const Vec3 index = bins_.indexOf(x);
    const int i = static_cast<int>(std::lround(index[0])), j = static_cast<int>(std::lround(index[1])),
              k = static_cast<int>(std::lround(index[2]));
    const std::size_t bin = bins_.at(i, j, k);
    const auto distance = static_cast<float>((index - Vec3(i, j, k)).squaredNorm());
    if (distance >= nearest[bin]) return;
    nearest[bin] = distance;
    own[bin] = static_cast<std::int32_t>(v);
  });
  fillSeeds(own);
}

Vec3 InverseDeformation::placeOf(std::int32_t sample) const {
  const ImageGrid& grid = forward_.grid();
  const int row = grid.size[0], plane = row * grid.size[1];
  return grid.worldOf(sample % row, sample % plane / row, sample / plane);
}

/// For each bin the sample whose place now is nearest to its middle, of its own and those of the bins around.
/// @param own  (bin_count) the nearest of those in the bin itself, or -1
void InverseDeformation::fillSeeds(const std::vector<std::int32_t>& own) {
  seed_.assign(own.size(), -1);
  const auto& size = bins_.size;
  const auto nearestWithin = [&](int i, int j, int k, int reach) {
    const Vec3 middle = bins_.worldOf(i, j, k);
    double least = 1e300;
    std::int32_t best = -1;
    for (int c = std::max(0, k - reach); c <= std::min(size[2] - 1, k + reach); ++c)
      for (int b = std::max(0, j - reach); b <= std::min(size[1] - 1, j + reach); ++b)
        for (int a = std::max(0, i - reach); a <= std::min(size[0] - 1, i + reach); ++a) {
          const std::int32_t v = own[bins_.at(a, b, c)];
          if (v < 0) continue;
          const double distance = (placeOf(v) + forward_.sample(static_cast<std::size_t>(v)) - middle).squaredNorm();
          if (distance >= least) continue;
          least = distance;
          best = v;
        }
    return best;
  };
  parallelFor(
      size[2],
      [&](int first, int last) {
        for (int k = first; k < last; ++k)
          for (int j = 0; j < size[1]; ++j)
            for (int i = 0; i < size[0]; ++i) {
              std::int32_t& seed = seed_[bins_.at(i, j, k)];
              seed = own[bins_.at(i, j, k)];
              for (int reach = 1; reach <= farthest_seed && seed < 0; ++reach) seed = nearestWithin(i, j, k, reach);
            }
      },
      1);
}

bool InverseDeformation::at(const Vec3& x, Origin& origin) const {
  return startAt(x, origin.X) && newton(x, forward_, patient, origin) == Outcome::Inside && polish(x, origin);
}

bool InverseDeformation::atNear(const Vec3& x, Origin& origin) const {
  constexpr int hurried = 4;  // the next voxel's result is that near
  return newton(x, forward_, hurried, origin) == Outcome::Inside ? polish(x, origin) : at(x, origin);
}

/// Goes on by values of the whole field where the sampled one is rough. True, for what was found inside stays that: at
/// the very surface by less than the sampling's error.
bool InverseDeformation::polish(const Vec3& x, Origin& origin) const {
  if (!forward_.isRough(origin.X)) return true;
  const Mat3 inverse = (Mat3::Identity() + origin.gradient).inverse();
  for (int k = 0; k < max_polishings; ++k) {
    Vec3 u;
    if (!forward_.value(origin.X, u)) return true;
    const Vec3 residual = origin.X + u - x;
    origin.X -= inverse * residual;
    if (residual.squaredNorm() < polished * polished) break;
  }
  return true;
}

bool InverseDeformation::at(const Vec3& x, const Deformation& exact, Origin& origin) const {
  if (!startAt(x, origin.X)) return false;
  Origin sampled = origin;
  if (newton(x, forward_, patient, sampled) != Outcome::Lost) origin = sampled;
  return newton(x, exact, patient, origin) == Outcome::Inside;
}

InverseDeformation::Outcome InverseDeformation::newton(const Vec3& x, const Deformation& exact, int max_iterations,
                                                       Origin& origin) const {
  Vec3& X = origin.X;
  for (int k = 0; k < max_iterations; ++k) {
    // A step from the nearest sample leads near the solution: what is so far outside of the body does not come back.
    if (k > 0 && forward_.surfaceDistance(X) > forward_.step()) return Outcome::Outside;
    Vec3 u;
    if (!exact.at(X, u, origin.gradient)) return Outcome::Lost;
    const Vec3 residual = X + u - x;
    Vec3 step = (Mat3::Identity() + origin.gradient).inverse() * residual;
    if (!step.allFinite()) return Outcome::Lost;
    const double longest = 2 * forward_.step();  // far steps of a folding start lead anywhere
    if (step.norm() > longest) step *= longest / step.norm();
    X -= step;
    if (residual.norm() < last_step) return exact.surfaceDistance(X) <= 0 ? Outcome::Inside : Outcome::Outside;
  }
  return Outcome::Lost;
}

/// A sample whose place now is near x; false where there is none.
bool InverseDeformation::startAt(const Vec3& x, Vec3& X) const {
  const Vec3 index = bins_.indexOf(x);
  int bin[3];
  for (int a = 0; a < 3; ++a) {
    const int size = bins_.size[static_cast<std::size_t>(a)];
    if (!(index[a] > -farthest_seed && index[a] < size + farthest_seed)) return false;
    bin[a] = std::clamp(static_cast<int>(std::lround(index[a])), 0, size - 1);
  }
  const std::int32_t seed = seed_[bins_.at(bin[0], bin[1], bin[2])];
  if (seed >= 0) X = placeOf(seed);
  return seed >= 0;
}

}  // namespace palpate
