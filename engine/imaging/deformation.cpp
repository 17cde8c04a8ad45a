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

/// Where an inverse is good enough, m: a thousandth of what is promised.
constexpr double inverse_accuracy = 1e-9;

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
  u_.assign(distance_.value.size(), Vec3f::Zero());
  known_.assign(distance_.value.size(), 0);
  std::vector<Eigen::Matrix3f> gradients(distance_.value.size(), Eigen::Matrix3f::Zero());
  parallelFor(
      size[1] * size[2],
      [&](int first, int last) {
        for (int row = first; row < last; ++row)
          for (int i = 0; i < size[0]; ++i) {
            const int j = row % size[1], k = row / size[1];
            const std::size_t v = distance_.grid.at(i, j, k);
            const Vec3 X = distance_.grid.worldOf(i, j, k);
            const double distance = whole.surfaceDistance(X);
            distance_.value[v] = static_cast<float>(distance);
            if (distance > samples_beyond * step) continue;
            Vec3 u;
            Mat3 gradient;
            if (!whole.at(X, u, gradient)) continue;
            u_[v] = u.cast<float>();
            gradients[v] = gradient.cast<float>();
            known_[v] = 1;
          }
      },
      1);
  extend(gradients);
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
                  u += u_[other] - static_cast<float>(step_) * (gradient[other] * way);
                  slope += gradient[other];
                  ++count;
                }
                if (count == 0) continue;
                u_[v] = u / count;
                gradient[v] = slope / count;
                known_[v] = 1;
              }
        },
        1);
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
  double weight[3][4], slope[3][4];
  for (int a = 0; a < 3; ++a) {
    const double floor = std::floor(index[a]), t = index[a] - floor, t2 = t * t, t3 = t2 * t;
    if (!(floor >= 1 && floor < grid.size[static_cast<std::size_t>(a)] - 2)) return whole_.at(X, u, gradient);
    low[a] = static_cast<int>(floor) - 1;
    const double w[4] = {-0.5 * t + t2 - 0.5 * t3, 1 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2 * t2 - 1.5 * t3,
                         -0.5 * t2 + 0.5 * t3};
    const double d[4] = {-0.5 + 2 * t - 1.5 * t2, -5 * t + 4.5 * t2, 0.5 + 4 * t - 4.5 * t2, -t + 1.5 * t2};
    std::copy(w, w + 4, weight[a]);
    for (int s = 0; s < 4; ++s) slope[a][s] = d[s] / step_;
  }
  u.setZero();
  gradient.setZero();
  for (int s = 0; s < 4; ++s)
    for (int r = 0; r < 4; ++r) {
      const std::size_t row = grid.at(low[0], low[1] + r, low[2] + s);
      Vec3 value = Vec3::Zero(), along = Vec3::Zero();
      for (std::size_t q = 0; q < 4; ++q) {
        if (!known_[row + q]) return whole_.at(X, u, gradient);
        const Vec3 sampled = u_[row + q].cast<double>();
        value += weight[0][q] * sampled;
        along += slope[0][q] * sampled;
      }
      u += weight[1][r] * weight[2][s] * value;
      gradient.col(0) += weight[1][r] * weight[2][s] * along;
      gradient.col(1) += slope[1][r] * weight[2][s] * value;
      gradient.col(2) += weight[1][r] * slope[2][s] * value;
    }
  return true;
}

InverseDeformation::InverseDeformation(const SampledDeformation& forward) : forward_(forward) {
  const ImageGrid& grid = forward.grid();
  Box3 box;
  const auto each = [&](auto visit) {
    for (int k = 0; k < grid.size[2]; ++k)
      for (int j = 0; j < grid.size[1]; ++j)
        for (int i = 0; i < grid.size[0]; ++i) {
          const std::size_t v = grid.at(i, j, k);
          if (forward.isKnown(v) && static_cast<double>(forward.sampleDistance(v)) <= forward.step())
            visit(v, Vec3(grid.worldOf(i, j, k) + forward.sample(v).cast<double>()));
        }
  };
  each([&](std::size_t, const Vec3& x) { box.extend(x); });
  if (box.isEmpty()) box.extend(Vec3(Vec3::Zero()));
  const double step = forward.step();
  std::array<int, 3> size{};
  for (int a = 0; a < 3; ++a) size[static_cast<std::size_t>(a)] = 2 + static_cast<int>(box.sizes()[a] / step);
  bins_ = ImageGrid(size, Mat3::Identity() * step, box.min());
  seed_.assign(bins_.voxelCount(), -1);
  std::vector<float> nearest(seed_.size(), 1e30F);
  each([&](std::size_t v, const Vec3& x) {
    const Vec3 index = bins_.indexOf(x);
    const int i = static_cast<int>(std::lround(index[0])), j = static_cast<int>(std::lround(index[1])),
              k = static_cast<int>(std::lround(index[2]));
    const std::size_t bin = bins_.at(i, j, k);
    const auto distance = static_cast<float>((index - Vec3(i, j, k)).squaredNorm());
    if (distance >= nearest[bin]) return;
    nearest[bin] = distance;
    seed_[bin] = static_cast<std::int32_t>(v);
  });
  near_.assign(seed_.size(), 0);
  constexpr int r = farthest_seed;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        if (seed_[bins_.at(i, j, k)] < 0) continue;
        const int from = std::max(0, i - r), to = std::min(size[0] - 1, i + r);
        for (int c = std::max(0, k - r); c <= std::min(size[2] - 1, k + r); ++c)
          for (int b = std::max(0, j - r); b <= std::min(size[1] - 1, j + r); ++b)
            std::fill_n(&near_[bins_.at(from, b, c)], to - from + 1, char{1});
      }
}

bool InverseDeformation::at(const Vec3& x, const Deformation& exact, Vec3& X, Mat3& gradient) const {
  constexpr int max_iterations = 30;
  return seedAt(x, X) && newton(x, exact, max_iterations, X, gradient) == Outcome::Inside;
}

bool InverseDeformation::atNear(const Vec3& x, Vec3& X, Mat3& gradient) const {
  constexpr int max_iterations = 4;  // the next voxel's result is that near
  const Vec3 start = X;
  if (newton(x, forward_, max_iterations, X, gradient) == Outcome::Inside) return true;
  X = start;
  return at(x, X, gradient);
}

InverseDeformation::Outcome InverseDeformation::newton(const Vec3& x, const Deformation& exact, int max_iterations,
                                                       Vec3& X, Mat3& gradient) const {
  for (int k = 0; k < max_iterations; ++k) {
    // A step from the nearest sample leads near the solution: what is so far outside of the body does not come back.
    if (k > 0 && forward_.surfaceDistance(X) > forward_.step()) return Outcome::Outside;
    Vec3 u;
    if (!exact.at(X, u, gradient)) return Outcome::Lost;
    const Vec3 residual = X + u - x;
    if (residual.norm() < inverse_accuracy) return exact.surfaceDistance(X) <= 0 ? Outcome::Inside : Outcome::Outside;
    Vec3 step = (Mat3::Identity() + gradient).inverse() * residual;
    if (!step.allFinite()) return Outcome::Lost;
    const double longest = 2 * forward_.step();  // far steps of a folding start lead anywhere
    if (step.norm() > longest) step *= longest / step.norm();
    X -= step;
  }
  return Outcome::Lost;
}

/// A sample whose place now is near x; false where there is none.
bool InverseDeformation::seedAt(const Vec3& x, Vec3& X) const {
  constexpr int farthest = farthest_seed;
  const ImageGrid& grid = forward_.grid();
  const Vec3 index = bins_.indexOf(x);
  int middle[3];
  for (int a = 0; a < 3; ++a) {
    if (!(index[a] > -farthest && index[a] < bins_.size[static_cast<std::size_t>(a)] + farthest)) return false;
    middle[a] = std::clamp(static_cast<int>(std::lround(index[a])), 0, bins_.size[static_cast<std::size_t>(a)] - 1);
  }
  if (!near_[bins_.at(middle[0], middle[1], middle[2])]) return false;
  const auto placeOf = [&](std::size_t v) {
    const auto row = static_cast<std::size_t>(grid.size[0]), plane = row * static_cast<std::size_t>(grid.size[1]);
    return grid.worldOf(static_cast<int>(v % row), static_cast<int>(v % plane / row), static_cast<int>(v / plane));
  };
  double best = 1e300;
  for (int reach = 1; reach <= farthest && best == 1e300; ++reach)
    for (int k = std::max(0, middle[2] - reach); k <= std::min(bins_.size[2] - 1, middle[2] + reach); ++k)
      for (int j = std::max(0, middle[1] - reach); j <= std::min(bins_.size[1] - 1, middle[1] + reach); ++j)
        for (int i = std::max(0, middle[0] - reach); i <= std::min(bins_.size[0] - 1, middle[0] + reach); ++i) {
          const std::int32_t v = seed_[bins_.at(i, j, k)];
          if (v < 0) continue;
          const Vec3 start = placeOf(static_cast<std::size_t>(v));
          const double distance =
              (start + forward_.sample(static_cast<std::size_t>(v)).cast<double>() - x).squaredNorm();
          if (distance < best) {
            best = distance;
            X = start;
          }
        }
  return best < 1e300;
}

}  // namespace palpate
