#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/parallel_for.h"
#include "imaging/deformation.h"

namespace palpate {
namespace {

/// How far beyond the surface fields are sampled, and how far these samples are continued: cubic interpolation at the
/// surface asks for two more along each axis.
constexpr double samples_beyond = 3, continued_beyond = 4;

/// Distance from the surface, in samples, from which on it need not be exact: cells that the surface cuts are nearer.
constexpr double exact_distance = 3;

/// Depth below which slopes at samples are not asked for, in samples: no sample that is missing is so deep.
constexpr double slopes_to_depth = 3;

/// The third difference of samples along an axis, m, from which on the field between them is looked at. Catmull-Rom is
/// off by 0.016 of a cubic's third difference, by a tenth of that of what MMLS makes between nodes.
constexpr double suspicious_difference = 0.05e-3;

/// How far off the samples may be where the field is looked at, m: elsewhere in the cell it may be thrice that.
constexpr double rough_error = 2.5e-6;

}  // namespace

/// du/dX at the samples near the surface, from which those beyond are continued.
struct SampledDeformation::Slopes {
  std::vector<Eigen::Matrix3f> gradient;  // (voxel_count)
  std::vector<char> known;                // (voxel_count)
};

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
  Slopes slopes{std::vector<Eigen::Matrix3f>(u_.size(), Eigen::Matrix3f::Zero()), std::vector<char>(u_.size(), 0)};
  parallelFor(
      size[1] * size[2],
      [&](int first, int last) {
        for (int row = first; row < last; ++row) sampleRow(row % size[1], row / size[1], slopes);
      },
      1);
  extend(slopes);
  findWholeCells();
  findRoughCells();
}

void SampledDeformation::sampleRow(int j, int k, Slopes& slopes) {
  int far = 0;    // samples from here that are known to be far from the surface
  int last = -1;  // the last whose distance is exact
  double distance = 0, exact = 0;
  for (int i = 0; i < distance_.grid.size[0]; ++i) {
    const std::size_t v = distance_.grid.at(i, j, k);
    const Vec3 X = distance_.grid.worldOf(i, j, k);
    if (far > 0) {  // a step away the surface is nearer by no more than the step
      --far;
      distance -= std::copysign(step_, distance);
    } else {
      distance = last < 0 ? whole_.surfaceDistance(X) : whole_.surfaceDistance(X, exact, (i - last) * step_);
      far = std::max(0, static_cast<int>(std::abs(distance) / step_ - exact_distance));
      exact = distance;
      last = i;
    }
    distance_.value[v] = static_cast<float>(distance);
    if (distance > samples_beyond * step_) continue;
    Vec3 u;
    if (distance < -slopes_to_depth * step_) {
      if (!whole_.value(X, u)) continue;
    } else {
      Mat3 slope;
      if (!whole_.at(X, u, slope)) continue;
      slopes.gradient[v] = slope.cast<float>();
      slopes.known[v] = 1;
    }
    u_[v] = toFloat4(u);
    known_[v] = 1;
  }
}

/// Continues the samples by what those beside them say, a layer at a time.
void SampledDeformation::extend(Slopes& slopes) {
  const ImageGrid& grid = distance_.grid;
  constexpr int layers = 4;
  for (int layer = 0; layer < layers; ++layer) {
    const std::vector<char> before = slopes.known;
    parallelFor(
        grid.size[2],
        [&](int first, int last) {
          for (int k = std::max(first, 1); k < std::min(last, grid.size[2] - 1); ++k)
            for (int j = 1; j + 1 < grid.size[1]; ++j)
              for (int i = 1; i + 1 < grid.size[0]; ++i) {
                const std::size_t v = grid.at(i, j, k);
                if (known_[v] || static_cast<double>(distance_.value[v]) > continued_beyond * step_) continue;
                Vec3f u = Vec3f::Zero();
                Eigen::Matrix3f slope = Eigen::Matrix3f::Zero();
                float count = 0;
                for (int n = 0; n < 27; ++n) {
                  const int right = n % 3 - 1, ahead = n / 3 % 3 - 1, up = n / 9 - 1;
                  const Vec3f way = Eigen::Vector3i(right, ahead, up).cast<float>();
                  const std::size_t other = grid.at(i + right, j + ahead, k + up);
                  if (!before[other]) continue;
                  u += toVec3(u_[other]).cast<float>() - static_cast<float>(step_) * (slopes.gradient[other] * way);
                  slope += slopes.gradient[other];
                  ++count;
                }
                if (count == 0) continue;
                u_[v] = toFloat4((u / count).cast<double>());
                slopes.gradient[v] = slope / count;
                slopes.known[v] = known_[v] = 1;
              }
        },
        1);
  }
}

/// Along one axis after the other: whether four in a row are known, then four such rows, then four such planes.
void SampledDeformation::findWholeCells() {
  const ImageGrid& grid = distance_.grid;
  std::vector<char> whole = known_;
  const auto row = static_cast<std::size_t>(grid.size[0]), plane = row * static_cast<std::size_t>(grid.size[1]);
  for (const std::size_t stride : {std::size_t{1}, row, plane})
    for (std::size_t v = 0; v < whole.size(); ++v) {
      const std::size_t last = v + 3 * stride;  // what wraps into the next row begins no cell that is asked for
      whole[v] = last < whole.size() && whole[v] && whole[v + stride] && whole[v + 2 * stride] && whole[last];
    }
  around_.assign(whole.size(), Around::Missing);
  for (std::size_t v = 0; v < whole.size(); ++v)
    if (whole[v]) around_[v] = Around::Smooth;
}

/// The largest third difference, m, along the twelve lines of four samples that hold the edges of a cell.
double SampledDeformation::thirdDifference(std::size_t v) const {
  const auto row = static_cast<std::size_t>(distance_.grid.size[0]),
             plane = row * static_cast<std::size_t>(distance_.grid.size[1]);
  const std::size_t stride[3] = {1, row, plane};
  double largest2 = 0;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t edge = 0; edge < 4; ++edge) {
      const std::size_t s = stride[a],
                        first = v + (1 + (edge & 1)) * stride[(a + 1) % 3] + (1 + (edge >> 1)) * stride[(a + 2) % 3];
      const Vec3 third =
          toVec3(u_[first + 3 * s]) - toVec3(u_[first]) + 3 * (toVec3(u_[first + s]) - toVec3(u_[first + 2 * s]));
      largest2 = std::max(largest2, third.squaredNorm());
    }
  return std::sqrt(largest2);
}

/// Compares samples and field at five places of each cell in the body where third differences are large.
void SampledDeformation::findRoughCells() {
  const ImageGrid& grid = distance_.grid;
  // Along an axis, third differences do most harm at 0.21 and 0.79, with opposite signs: in one of the four they add
  // up.
  constexpr double near = 0.21, far = 0.79;
  const Vec3 places[5] = {{near, near, near}, {far, near, near}, {near, far, near}, {near, near, far}, {0.5, 0.5, 0.5}};
  const auto isOff = [&](const Vec3& X) {
    Vec3 sampled, u;
    Mat3 gradient;
    return !at(X, sampled, gradient) || !whole_.value(X, u) || (sampled - u).norm() > rough_error;
  };
  std::vector<Around> found = around_;
  parallelFor(
      grid.size[2] - 3,
      [&](int begin, int end) {
        for (int k = begin; k < end; ++k)
          for (int j = 0; j + 3 < grid.size[1]; ++j)
            for (int i = 0; i + 3 < grid.size[0]; ++i) {
              const std::size_t v = grid.at(i, j, k);
              const Vec3 corner = grid.worldOf(i + 1, j + 1, k + 1);
              if (around_[v] == Around::Missing ||
                  static_cast<double>(distance_.value[grid.at(i + 1, j + 1, k + 1)]) > std::sqrt(3.0) * step_ ||
                  !(thirdDifference(v) > suspicious_difference))
                continue;
              if (std::any_of(std::begin(places), std::end(places),
                              [&](const Vec3& place) { return isOff(corner + step_ * place); }))
                found[v] = Around::Rough;
            }
      },
      1);
  around_ = std::move(found);
}

double SampledDeformation::surfaceDistance(const Vec3& X) const {
  const Vec3 index = distance_.grid.indexOf(X);
  for (int a = 0; a < 3; ++a)
    if (index[a] < 0 || index[a] > distance_.grid.size[static_cast<std::size_t>(a)] - 1) return samples_beyond * step_;
  return linearValue(distance_, index);
}

/// The first of the 64 samples around a point, and where in their middle cell it is. False beyond the grid.
bool SampledDeformation::cellAt(const Vec3& X, std::size_t& first, Vec3& t) const {
  const ImageGrid& grid = distance_.grid;
  const Vec3 index = grid.indexOf(X);
  int low[3];
  for (int a = 0; a < 3; ++a) {
    const double floor = std::floor(index[a]);
    if (!(floor >= 1 && floor < grid.size[static_cast<std::size_t>(a)] - 2)) return false;
    low[a] = static_cast<int>(floor) - 1;
    t[a] = index[a] - floor;
  }
  first = grid.at(low[0], low[1], low[2]);
  return true;
}

/// Of four samples along each axis.
struct SampledDeformation::Weights {
  float value[3][4];

  explicit Weights(const Vec3& t_of) {
    for (int a = 0; a < 3; ++a) {
      const std::array<double, 4> w = cubicWeights(t_of[a]);
      for (std::size_t s = 0; s < 4; ++s) value[a][s] = static_cast<float>(w[s]);
    }
  }
};

bool SampledDeformation::isRough(const Vec3& X) const {
  std::size_t first = 0;
  Vec3 t;
  return !cellAt(X, first, t) || around_[first] != Around::Smooth;
}

bool SampledDeformation::value(const Vec3& X, Vec3& u) const {
  std::size_t first = 0;
  Vec3 t;
  if (!cellAt(X, first, t) || around_[first] != Around::Smooth) return whole_.value(X, u);
  const Weights weight(t);
  const auto row = static_cast<std::size_t>(distance_.grid.size[0]),
             plane = row * static_cast<std::size_t>(distance_.grid.size[1]);
  Group sum{};
  for (std::size_t s = 0; s < 4; ++s)
    for (std::size_t r = 0; r < 4; ++r) {
      const Float4* sample = &u_[first + s * plane + r * row];
      const float outer = weight.value[2][s] * weight.value[1][r];
      for (std::size_t q = 0; q < 4; ++q) sum += outer * weight.value[0][q] * load(sample[q]);
    }
  for (int c = 0; c < 3; ++c) u[c] = static_cast<double>(sum[c]);
  return true;
}

bool SampledDeformation::at(const Vec3& X, Vec3& u, Mat3& gradient) const {
  std::size_t first = 0;
  Vec3 place;
  if (!cellAt(X, first, place) || around_[first] == Around::Missing) return whole_.at(X, u, gradient);
  const Weights weights(place);
  const auto& weight = weights.value;
  float slope[3][4];
  for (int a = 0; a < 3; ++a) {
    const double t = place[a], t2 = t * t;
    const double d[4] = {-0.5 + 2 * t - 1.5 * t2, -5 * t + 4.5 * t2, 0.5 + 4 * t - 4.5 * t2, -t + 1.5 * t2};
    for (int s = 0; s < 4; ++s) slope[a][s] = static_cast<float>(d[s] / step_);
  }
  const auto row = static_cast<std::size_t>(distance_.grid.size[0]),
             plane = row * static_cast<std::size_t>(distance_.grid.size[1]);
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

}  // namespace palpate
