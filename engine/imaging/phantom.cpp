#include "imaging/phantom.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel_for.h"

namespace palpate {
namespace {

const Vec3 brain_centre(4 * mm, -18 * mm, 22 * mm), brain_semi_axes(68 * mm, 85 * mm, 62 * mm);
constexpr double intensity[3] = {220, 560, 880};  // of fluid, grey and white, T1

/// Distance to the envelope, m, to first order; negative inside. Flattened below.
double envelope(const Vec3& X) {
  const Vec3 p = X - brain_centre, unit = p.cwiseQuotient(brain_semi_axes);
  const double k = unit.norm(), slope = unit.cwiseQuotient(brain_semi_axes).norm();
  const double ball = slope < 1e-9 ? -brain_semi_axes.minCoeff() : k * (k - 1) / slope;
  const double base = -p.z() - 46 * mm;
  return std::max(ball, base);
}

/// Distance to the nearest sulcus' middle, m, where they go down to `depth` below the envelope.
double sulcus(const Vec3& X, double depth_here) {
  const Vec3 p = (X - brain_centre) / mm;
  const Vec3 bent = p + 7 * Vec3(std::sin(p.y() / 17), std::sin(p.z() / 15 + 1), std::sin(p.x() / 19 + 2));
  constexpr double period = 30, deepest = 15;  // mm
  const double k = std::numbers::pi / period;
  const double side = std::sin(k * (bent.y() + 0.35 * bent.z())) / k;
  const double across = std::sin(k * (bent.z() - 0.5 * std::abs(bent.x()) + 9)) / k;
  const double fissure = p.x();  // between the hemispheres
  const auto below = [&](double distance, double end) {
    return std::hypot(distance, std::max(0.0, depth_here / mm - end));
  };
  return mm * std::min({below(side, deepest), below(across, 0.7 * deepest), below(fissure, 28)});
}

double ellipsoid(const Vec3& p, const Vec3& at, const Vec3& axes) {
  const Vec3 unit = (p - at).cwiseQuotient(axes);
  return (unit.norm() - 1) * axes.minCoeff();
}

/// Distance to the ventricles, m.
double ventricles(const Vec3& X) {
  Vec3 p = (X - brain_centre) / mm;
  p.x() = std::abs(p.x());
  const double horn = ellipsoid(p, {11, 6 - 0.1 * p.x(), 6}, {6, 27, 8});
  const double third = ellipsoid(p, {0, 2, -6}, {2.5, 12, 9});
  return mm * std::min(horn, third);
}

double nuclei(const Vec3& X) {
  Vec3 p = (X - brain_centre) / mm;
  p.x() = std::abs(p.x());
  return mm * ellipsoid(p, {23, 4, -4}, {8, 17, 11});
}

/// A smooth field that is no polynomial: 0 .. 1.
double biasShape(const Vec3& X) {
  const Vec3 p = (X - brain_centre) / (90 * mm);
  return 0.5 + 0.5 * std::sin(1.1 * p.x() + 0.9 * p.y() - 0.7 * p.z() + 0.4) * std::cos(0.6 * p.y() - 0.8 * p.z());
}

/// Random numbers of a voxel alone, so that no order matters (Steele et al. 2014, splitmix64).
double uniform(std::uint64_t seed, std::uint64_t voxel, std::uint64_t draw) {
  std::uint64_t z = seed * 0x9e3779b97f4a7c15ull + voxel * 0xbf58476d1ce4e5b9ull + (draw + 1) * 0x94d049bb133111ebull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  z ^= z >> 31;
  return (static_cast<double>(z >> 11) + 0.5) * 0x1p-53;
}

/// |A + n| with complex noise n: what a magnitude image has (Gudbjartsson and Patz 1995).
double rician(double A, double sigma, std::uint64_t seed, std::uint64_t voxel) {
  const double r = sigma * std::sqrt(-2 * std::log(uniform(seed, voxel, 0)));
  const double angle = 2 * std::numbers::pi * uniform(seed, voxel, 1);
  return std::hypot(A + r * std::cos(angle), r * std::sin(angle));
}

void fillVoxel(Phantom& phantom, const PhantomOptions& options, int i, int j, int k) {
  constexpr int samples = 3;  // along each edge of a voxel
  const ImageGrid& grid = phantom.scan.grid;
  int count[3] = {0, 0, 0};
  for (int s = 0; s < samples * samples * samples; ++s) {
    const auto part = [](int a) { return (a + 0.5) / samples - 0.5; };
    bool inside = false;
    const PhantomTissue tissue =
        phantomTissue(grid.worldOf(Vec3(i + part(s % 3), j + part(s / 3 % 3), k + part(s / 9))), inside);
    if (inside) ++count[static_cast<int>(tissue)];
  }
  const Vec3 X = grid.worldOf(i, j, k);
  const int total = count[0] + count[1] + count[2];
  const std::size_t v = grid.at(i, j, k);
  double signal = 0;
  for (int t = 0; t < 3; ++t) {
    phantom.fraction[static_cast<std::size_t>(t)].value[v] =
        total > 0 ? static_cast<float>(count[t]) / static_cast<float>(total) : 0.0F;
    signal += intensity[t] * count[t] / (samples * samples * samples);
  }
  phantom.mask.value[v] = 2 * total > samples * samples * samples;
  if (phantom.mask.value[v])
    phantom.labels.value[v] = static_cast<float>(1 + (std::max_element(count, count + 3) - count));
  const double distance = envelope(X);
  if (distance > 7 * mm && distance < 13 * mm) signal += 450;  // the scalp; what is before it is skull, dark
  const double factor = (1 + options.bias * biasShape(X)) / (1 + options.bias / 2);
  phantom.bias.value[v] = static_cast<float>(factor);
  phantom.scan.value[v] = static_cast<float>(rician(signal * factor, options.noise * intensity[2], options.seed, v));
}

/// A grid of electrodes on the envelope over the right temporal and parietal side, and where it is pushed to.
void placeElectrodes(Phantom& phantom, const PhantomOptions& options) {
  const Vec3 towards = Vec3(0.75, 0.1, 0.65).normalized();
  const Vec3 along = Vec3(0.1, 1, 0).cross(towards).normalized(), across = towards.cross(along);
  constexpr double pitch = 10 * mm, width = 32 * mm;
  for (int r = 0; r < options.rows; ++r)
    for (int c = 0; c < options.columns; ++c) {
      const double a = (r - (options.rows - 1) / 2.0) * pitch, b = (c - (options.columns - 1) / 2.0) * pitch;
      // The point of the envelope on a ray from within.
      const Vec3 start = brain_centre + a * along + b * across;
      double low = 0, high = 120 * mm;
      for (int bisection = 0; bisection < 50; ++bisection) {
        const double middle = (low + high) / 2;
        (envelope(start + middle * towards) < 0 ? low : high) = middle;
      }
      const Vec3 X = start + low * towards;
      const double share = std::exp(-(a * a + b * b) / (2 * width * width));
      phantom.before.push_back(X);
      phantom.after.push_back(X - options.shift * share * towards);
    }
}

}  // namespace

PhantomTissue phantomTissue(const Vec3& X, bool& inside) {
  const double distance = envelope(X);
  inside = distance < 0;
  if (!inside) return PhantomTissue::Fluid;
  const double depth = -distance, fold = sulcus(X, depth), film = 1.2 * mm, gap = 1.3 * mm;
  const double cortex = std::min(depth - film, fold - gap);  // how far below the cortex' own surface
  if (cortex < 0 || ventricles(X) < 0) return PhantomTissue::Fluid;
  constexpr double ribbon = 4.5 * mm;
  return cortex < ribbon || nuclei(X) < 0 ? PhantomTissue::Grey : PhantomTissue::White;
}

Phantom makePhantom(const PhantomOptions& options) {
  Phantom phantom;
  const double edge = 192 * mm / options.voxels;
  const std::array<int, 3> size{static_cast<int>(std::ceil(168 * mm / edge)), options.voxels,
                                static_cast<int>(std::ceil(152 * mm / edge))};
  const Vec3 half = edge * Vec3(size[0] - 1, size[1] - 1, size[2] - 1) / 2;
  // Left to right as scanners store it, with a negative determinant (radiological order).
  const Mat3 axes = (Vec3(-edge, edge, edge)).asDiagonal();
  const ImageGrid grid(size, axes, brain_centre + Vec3(half.x(), -half.y(), -half.z() + 6 * mm));
  phantom.scan = phantom.labels = Image(grid);
  phantom.bias = Image(grid, 1.0F);
  phantom.fraction.assign(3, Image(grid));
  phantom.mask = Mask(grid);
  parallelFor(
      size[2],
      [&](int first, int last) {
        for (int k = first; k < last; ++k)
          for (int j = 0; j < size[1]; ++j)
            for (int i = 0; i < size[0]; ++i) fillVoxel(phantom, options, i, j, k);
      },
      1);
  placeElectrodes(phantom, options);
  return phantom;
}

}  // namespace palpate
