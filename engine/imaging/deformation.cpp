#include "imaging/deformation.h"

#include <algorithm>
#include <cmath>

#include "approximation/shape_functions.h"
#include "base/parallel_for.h"

namespace palpate {
namespace {

/// How far beyond the surface fields are sampled, and how far these samples are continued: cubic interpolation at the
/// surface asks for two more along each axis.
constexpr double samples_beyond = 3, continued_beyond = 4;

/// How far from a bin a start is looked for: tissue stretched to thrice its length leaves such gaps.
constexpr int farthest_seed = 3;

/// Distance from the surface, in samples, from which on it need not be exact: cells that the surface cuts are nearer.
constexpr double exact_distance = 5;

/// Newton's method ends with a step from a residual below this, m. That step leaves |d^2u/dX^2| r^2: of a field that
/// changes by its own slope of 1 within 2 mm less than 1e-8 m, a hundredth of what is promised.
constexpr double last_step = 3e-6;

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

SampledDeformation::SampledDeformation(const Deformation& whole, double step) : whole_(whole), step_(step) {
  Box3 box = whole.box();
  const double margin = (samples_beyond + 1) * step;
  box.min().array() -= margin;
  box.max().array() += margin;
  std::array<int, 3> size{};
  for (int a = 0; a < 3; ++a)
    size[static_cast<std::size_t>(a)] = 2 + static_cast<int>(std::ceil(box.sizes()[a] / step));
  distance_ = Image(ImageGrid(size, Mat3::Identity() * step, box.min()));
  u_.assign(distance_.value.size(), Float4{});
  known_.assign(distance_.value.size(), 0);
  std::vector<Eigen::Matrix3f> gradients(distance_.value.size(), Eigen::Matrix3f::Zero());
  parallelFor(
      size[1] * size[2],
      [&](int first, int last) {
        for (int row = first; row < last; ++row) sampleRow(row % size[1], row / size[1], gradients);
      },
      1);
  extend(gradients);
  findWholeCells();
}

void SampledDeformation::sampleRow(int j, int k, std::vector<Eigen::Matrix3f>& gradient) {
  int far = 0;  // samples from here that are known to be far from the surface
  double distance = 0;
  for (int i = 0; i < distance_.grid.size[0]; ++i) {
    const std::size_t v = distance_.grid.at(i, j, k);
    const Vec3 X = distance_.grid.worldOf(i, j, k);
    if (far > 0) {  // a step away the surface is nearer by no more than the step
      --far;
      distance -= std::copysign(step_, distance);
    } else {
      distance = whole_.surfaceDistance(X);
      far = std::max(0, static_cast<int>(std::abs(distance) / step_ - exact_distance));
    }
    distance_.value[v] = static_cast<float>(distance);
    if (distance > samples_beyond * step_) continue;
    Vec3 u;
    Mat3 slope;
    if (!whole_.at(X, u, slope)) continue;
    u_[v] = toFloat4(u);
    gradient[v] = slope.cast<float>();
    known_[v] = 1;
  }
}

/// Continues the samples by what those beside them say, a layer at a time.
void SampledDeformation::extend(std::vector<Eigen::Matrix3f>& gradient) {
  const ImageGrid& grid = distance_.grid;
  constexpr int layers = 4;
  for (int layer = 0; layer < layers; ++layer) {
    const std::vector<char> before = known_;
    parallelFor(
        grid.size[2],
        [&](int first, int last) {
          for (int k = std::max(first, 1); k < std::min(last, grid.size[2] - 1); ++k)
            for (int j = 1; j + 1 < grid.size[1]; ++j)
              for (int i = 1; i + 1 < grid.size[0]; ++i) {
                const std::size_t v = grid.at(i, j, k);
                if (before[v] || static_cast<double>(distance_.value[v]) > continued_beyond * step_) continue;
                Vec3f u = Vec3f::Zero();
                Eigen::Matrix3f slope = Eigen::Matrix3f::Zero();
                float count = 0;
                for (int n = 0; n < 27; ++n) {
                  const int right = n % 3 - 1, ahead = n / 3 % 3 - 1, up = n / 9 - 1;
                  const Vec3f way = Eigen::Vector3i(right, ahead, up).cast<float>();
                  const std::size_t other = grid.at(i + right, j + ahead, k + up);
                  if (!before[other]) continue;
                  u += toVec3(u_[other]).cast<float>() - static_cast<float>(step_) * (gradient[other] * way);
                  slope += gradient[other];
                  ++count;
                }
                if (count == 0) continue;
                u_[v] = toFloat4((u / count).cast<double>());
                gradient[v] = slope / count;
                known_[v] = 1;
              }
        },
        1);
  }
}

/// Along one axis after the other: whether four in a row are known, then four such rows, then four such planes.
void SampledDeformation::findWholeCells() {
  const ImageGrid& grid = distance_.grid;
  surrounded_ = known_;
  const auto row = static_cast<std::size_t>(grid.size[0]), plane = row * static_cast<std::size_t>(grid.size[1]);
  for (const std::size_t stride : {std::size_t{1}, row, plane})
    for (std::size_t v = 0; v < surrounded_.size(); ++v) {
      const std::size_t last = v + 3 * stride;  // what wraps into the next row begins no cell that is asked for
      surrounded_[v] = last < surrounded_.size() && surrounded_[v] && surrounded_[v + stride] &&
                       surrounded_[v + 2 * stride] && surrounded_[last];
    }
}

double SampledDeformation::surfaceDistance(const Vec3& X) const {
  const Vec3 index = distance_.grid.indexOf(X);
  for (int a = 0; a < 3; ++a)
    if (index[a] < 0 || index[a] > distance_.grid.size[static_cast<std::size_t>(a)] - 1) return samples_beyond * step_;
  return linearValue(distance_, index);
}

bool SampledDeformation::at(const Vec3& X, Vec3& u, Mat3& gradient) const {
  const ImageGrid& grid = distance_.grid;
  const Vec3 index = grid.indexOf(X);
  int low[3];
  float weight[3][4], slope[3][4];
  for (int a = 0; a < 3; ++a) {
    const double floor = std::floor(index[a]), t = index[a] - floor, t2 = t * t, t3 = t2 * t;
    if (!(floor >= 1 && floor < grid.size[static_cast<std::size_t>(a)] - 2)) return whole_.at(X, u, gradient);
    low[a] = static_cast<int>(floor) - 1;
    const double w[4] = {-0.5 * t + t2 - 0.5 * t3, 1 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2 * t2 - 1.5 * t3,
                         -0.5 * t2 + 0.5 * t3};
    const double d[4] = {-0.5 + 2 * t - 1.5 * t2, -5 * t + 4.5 * t2, 0.5 + 4 * t - 4.5 * t2, -t + 1.5 * t2};
    for (int s = 0; s < 4; ++s) {
      weight[a][s] = static_cast<float>(w[s]);
      slope[a][s] = static_cast<float>(d[s] / step_);
    }
  }
  const std::size_t first = grid.at(low[0], low[1], low[2]);
  if (!surrounded_[first]) return whole_.at(X, u, gradient);
  const auto row = static_cast<std::size_t>(grid.size[0]), plane = row * static_cast<std::size_t>(grid.size[1]);
  Group sum{}, along_x{}, along_y{}, along_z{};
  for (std::size_t s = 0; s < 4; ++s) {
    Group value{}, x_slope{}, y_slope{};
    for (std::size_t r = 0; r < 4; ++r) {
      const Float4* sample = &u_[first + s * plane + r * row];
      Group here{}, along{};
      for (std::size_t q = 0; q < 4; ++q) {
        const Group sampled = load(sample[q]);
        here += weight[0][q] * sampled;
        along += slope[0][q] * sampled;
      }
      value += weight[1][r] * here;
      x_slope += weight[1][r] * along;
      y_slope += slope[1][r] * here;
    }
    sum += weight[2][s] * value;
    along_x += weight[2][s] * x_slope;
    along_y += weight[2][s] * y_slope;
    along_z += slope[2][s] * value;
  }
  for (int c = 0; c < 3; ++c) {
    u[c] = static_cast<double>(sum[c]);
    gradient.row(c) << static_cast<double>(along_x[c]), static_cast<double>(along_y[c]),
        static_cast<double>(along_z[c]);
  }
  return true;
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
  return startAt(x, origin.X) && newton(x, forward_, patient, origin) == Outcome::Inside;
}

bool InverseDeformation::atNear(const Vec3& x, Origin& origin) const {
  constexpr int hurried = 4;  // the next voxel's result is that near
  return newton(x, forward_, hurried, origin) == Outcome::Inside || at(x, origin);
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
