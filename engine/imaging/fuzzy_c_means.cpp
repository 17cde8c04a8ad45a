#include "imaging/fuzzy_c_means.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/input_error.h"
#include "base/parallel_for.h"
#include "base/ranked.h"

namespace palpate {
namespace {

constexpr int max_classes = 6;
constexpr int bin_count = 1024;
constexpr std::size_t sample_count = 60'000;

/// Weighted values: a histogram, or voxels of weight 1.
struct Sample {
  std::vector<double> value, weight;
};

Sample histogramOf(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  Sample h;
  h.weight.assign(bin_count, 0);
  const double width = (*high - *low) / bin_count;
  for (int b = 0; b < bin_count; ++b) h.value.push_back(*low + (b + 0.5) * width);
  for (const double v : values)
    ++h.weight[static_cast<std::size_t>(width > 0 ? std::min(bin_count - 1.0, (v - *low) / width) : 0)];
  return h;
}

/// Start: the middles of `classes` equal shares of the voxels, moved apart where values are equal.
std::vector<double> quantiles(const Sample& h, int classes) {
  double total = 0;
  for (const double w : h.weight) total += w;
  std::vector<double> centre;
  double sum = 0;
  for (std::size_t b = 0; b < h.value.size(); ++b) {
    sum += h.weight[b];
    while (static_cast<int>(centre.size()) < classes &&
           sum >= total * (static_cast<double>(centre.size()) + 0.5) / classes)
      centre.push_back(h.value[b]);
  }
  const double least = (h.value.back() - h.value.front()) / (4 * bin_count);
  for (std::size_t i = 1; i < centre.size(); ++i) centre[i] = std::max(centre[i], centre[i - 1] + least);
  return centre;
}

/// New centres of a histogram; returns the largest move.
double moveCentres(const Sample& h, std::vector<double>& centre) {
  std::array<double, max_classes> u{}, sum{}, weight{};
  for (std::size_t b = 0; b < h.value.size(); ++b) {
    if (h.weight[b] == 0) continue;
    fuzzyMemberships(h.value[b], centre, u.data());
    for (std::size_t i = 0; i < centre.size(); ++i) {
      sum[i] += h.weight[b] * u[i] * u[i] * h.value[b];
      weight[i] += h.weight[b] * u[i] * u[i];
    }
  }
  double largest = 0;
  for (std::size_t i = 0; i < centre.size(); ++i) {
    const double moved = weight[i] > 0 ? sum[i] / weight[i] : centre[i];
    largest = std::max(largest, std::abs(moved - centre[i]));
    centre[i] = moved;
  }
  std::sort(centre.begin(), centre.end());
  return largest;
}

/// Centres of a histogram at rest.
std::vector<double> centresOf(const std::vector<double>& values, int classes, int max_iterations) {
  const Sample h = histogramOf(values);
  std::vector<double> centre = quantiles(h, classes);
  const double enough = 1e-5 * (h.value.back() - h.value.front());
  for (int k = 0; k < max_iterations; ++k)
    if (moveCentres(h, centre) <= enough) break;
  return centre;
}

/// Polynomials of x, y, z in [-1, 1] up to a degree: products of Legendre polynomials, nearly orthogonal on a box.
class Polynomial {
 public:
  Polynomial(int degree, const Vec3& low, const Vec3& high) : degree_(degree), middle_((low + high) / 2) {
    half_ = ((high - low) / 2).cwiseMax(1.0);
    for (int a = 0; a <= degree; ++a)
      for (int b = 0; a + b <= degree; ++b)
        for (int c = 0; a + b + c <= degree; ++c)
          if (a + b + c > 0) power_.push_back({a, b, c});  // the constant is the centres'
  }
  int size() const { return static_cast<int>(power_.size()); }

  /// @param terms  (size)
  void evaluate(const Vec3& index, double* terms) const {
    double legendre[3][max_degree + 1];
    const Vec3 t = (index - middle_).cwiseQuotient(half_);
    for (int a = 0; a < 3; ++a) {
      legendre[a][0] = 1;
      if (degree_ > 0) legendre[a][1] = t[a];
      for (int n = 2; n <= degree_; ++n)
        legendre[a][n] = ((2 * n - 1) * t[a] * legendre[a][n - 1] - (n - 1) * legendre[a][n - 2]) / n;
    }
    for (std::size_t k = 0; k < power_.size(); ++k)
      terms[k] = legendre[0][power_[k][0]] * legendre[1][power_[k][1]] * legendre[2][power_[k][2]];
  }
  static constexpr int max_degree = 5;
  static constexpr int max_terms = 56;

 private:
  int degree_;
  Vec3 middle_, half_;
  std::vector<std::array<int, 3>> power_;
};

/// The bias as coefficients of a polynomial.
struct Bias {
  Polynomial polynomial;
  Eigen::VectorXd coefficient;
  double mean = 0;  // of the polynomial over the mask

  double at(const Vec3& index) const {
    double terms[Polynomial::max_terms], sum = -mean;
    polynomial.evaluate(index, terms);
    for (int k = 0; k < polynomial.size(); ++k) sum += coefficient[k] * terms[k];
    return sum;
  }
};

/// Fits bias and centres to voxels in turn. @param x  their logarithms; index  where they are
int fitBias(const std::vector<double>& x, const std::vector<Vec3>& index, int max_iterations,
            const std::function<void(double)>& progress, std::vector<double>& centre, Bias& bias) {
  const auto terms = static_cast<Eigen::Index>(bias.polynomial.size());
  const auto count = static_cast<Eigen::Index>(x.size());
  Eigen::MatrixXd P(terms, count);
  for (Eigen::Index k = 0; k < count; ++k)
    bias.polynomial.evaluate(index[static_cast<std::size_t>(k)], P.col(k).data());
  const Eigen::VectorXd mean = P.rowwise().mean();
  P.colwise() -= mean;  // zero mean of the field
  Eigen::VectorXd b = Eigen::VectorXd::Zero(count), weight(count), residual(count);
  constexpr double enough = 1e-4;  // of a logarithm: a ten-thousandth of an intensity
  int done = 0;
  for (; done < max_iterations; ++done) {
    if (progress) progress(static_cast<double>(done) / max_iterations);
    std::array<double, max_classes> u{}, sum{}, total{};
    for (Eigen::Index k = 0; k < count; ++k) {
      const double y = x[static_cast<std::size_t>(k)] - b[k];
      fuzzyMemberships(y, centre, u.data());
      double w = 0, expected = 0;
      for (std::size_t i = 0; i < centre.size(); ++i) {
        const double u2 = u[i] * u[i];
        w += u2;
        expected += u2 * centre[i];
        sum[i] += u2 * y;
        total[i] += u2;
      }
      weight[k] = w;
      residual[k] = x[static_cast<std::size_t>(k)] - expected / w;
    }
    double moved = 0;
    for (std::size_t i = 0; i < centre.size(); ++i) {
      const double v = total[i] > 0 ? sum[i] / total[i] : centre[i];
      moved = std::max(moved, std::abs(v - centre[i]));
      centre[i] = v;
    }
    std::sort(centre.begin(), centre.end());
    const Eigen::MatrixXd weighted = P * weight.asDiagonal();
    Eigen::MatrixXd normal = weighted * P.transpose();
    normal.diagonal().array() += 1e-9 * normal.trace() / static_cast<double>(terms);  // flat masks leave terms free
    const Eigen::VectorXd fitted = normal.ldlt().solve(weighted * residual);
    const Eigen::VectorXd field = P.transpose() * fitted;
    moved = std::max(moved, (field - b).cwiseAbs().maxCoeff());
    b = field;
    bias.coefficient = fitted;
    if (moved < enough) break;
  }
  bias.mean = bias.coefficient.dot(mean);
  return done;
}

/// Calls each(voxel, index) for the voxels of a mask in slices, on all cores.
template <class Each>
void forMask(const Mask& mask, Each each) {
  parallelFor(
      mask.grid.size[2],
      [&](int first, int last) {
        for (int k = first; k < last; ++k)
          for (int j = 0; j < mask.grid.size[1]; ++j)
            for (int i = 0; i < mask.grid.size[0]; ++i)
              if (const std::size_t v = mask.grid.at(i, j, k); mask.value[v]) each(v, Vec3(i, j, k));
      },
      1);
}

/// Every n-th voxel of the mask, at most sample_count, with the mask's box.
struct Chosen {
  std::vector<double> value;  // intensities
  std::vector<Vec3> index;
  Vec3 low = Vec3::Constant(1e9), high = Vec3::Constant(-1e9);
};

Chosen chosenOf(const Image& scan, const Mask& mask, std::size_t inside) {
  Chosen chosen;
  const std::size_t stride = (inside + sample_count - 1) / sample_count;
  std::size_t seen = 0;
  forVoxels(mask.grid, [&](int i, int j, int k) {
    if (!mask(i, j, k)) return;
    const Vec3 index(i, j, k);
    chosen.low = chosen.low.cwiseMin(index);
    chosen.high = chosen.high.cwiseMax(index);
    if (seen++ % stride != 0) return;
    chosen.value.push_back(scan(i, j, k));
    chosen.index.push_back(index);
  });
  return chosen;
}

/// Standard deviation of the noise, from the differences of neighbours in the mask: half of these cross no border of
/// tissue, so that their median is the noise's (0.6745 of a normal deviation, times sqrt(2) of two voxels).
double noiseOf(const Image& scan, const Mask& mask) {
  std::vector<float> difference;
  for (int k = 0; k < mask.grid.size[2]; ++k)
    for (int j = 0; j < mask.grid.size[1]; ++j)
      for (int i = 1; i < mask.grid.size[0]; ++i)
        if (mask(i, j, k) && mask(i - 1, j, k)) difference.push_back(std::abs(scan(i, j, k) - scan(i - 1, j, k)));
  if (difference.empty()) return 0;
  return ranked(difference, difference.size() / 2) / (0.6745 * std::sqrt(2.0));
}

/// Each voxel as the mean of those around it in the mask that are like it in `guide` (Tomasi and Manduchi 1998; with
/// another image as guide Petschnigg et al. 2004): noise goes, borders stay. It must outlive its arguments' use.
class Denoiser {
 public:
  /// @param alike  difference of the guide's values that still counts for exp(-1/2); 0: nothing is alike
  Denoiser(const Image& scan, const Image& guide, const Mask& mask, double alike)
      : scan_(scan), guide_(guide), mask_(mask) {
    if (!(alike > 0)) return;
    const Vec3 h = scan.grid.spacing();
    for (int n = 0; n < 27; ++n) {
      const Vec3 d = Eigen::Vector3i(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1).cast<double>().cwiseProduct(h) / h.minCoeff();
      nearness_[n] = static_cast<float>(std::exp(-d.squaredNorm() / 2));
    }
    per_entry_ = static_cast<float>(entries_per_deviation / alike);
    // Linear between entries 1/64 of a deviation apart the exponential is exact to 3e-5.
    for (int e = 0; e <= last_entry; ++e) {
      const double d = static_cast<double>(e) / entries_per_deviation;
      likeness_.push_back(static_cast<float>(std::exp(-d * d / 2)));
    }
  }

  float at(int i, int j, int k) const {
    const ImageGrid& grid = mask_.grid;
    const std::size_t v = grid.at(i, j, k);
    if (likeness_.empty()) return scan_.value[v];
    float sum = 0, total = 0;
    for (int z = std::max(k - 1, 0); z <= std::min(k + 1, grid.size[2] - 1); ++z)
      for (int y = std::max(j - 1, 0); y <= std::min(j + 1, grid.size[1] - 1); ++y)
        for (int x = std::max(i - 1, 0); x <= std::min(i + 1, grid.size[0] - 1); ++x) {
          const std::size_t other = grid.at(x, y, z);
          if (!mask_.value[other]) continue;
          const float weight = nearness_[x - i + 1 + 3 * (y - j + 1) + 9 * (z - k + 1)] *
                               likenessOf(std::abs(guide_.value[other] - guide_.value[v]));
          sum += weight * (scan_.value[other] - scan_.value[v]);
          total += weight;
        }
    return scan_.value[v] + sum / total;
  }

  Image whole() const {
    Image result = scan_;
    forMask(mask_, [&](std::size_t v, const Vec3& index) {
      result.value[v] = at(static_cast<int>(index[0]), static_cast<int>(index[1]), static_cast<int>(index[2]));
    });
    return result;
  }

 private:
  static constexpr int entries_per_deviation = 64, last_entry = 8 * entries_per_deviation;  // exp(-32) is nothing

  float likenessOf(float difference) const {
    const float at = std::min(difference * per_entry_, static_cast<float>(last_entry - 1));
    const auto entry = static_cast<std::size_t>(at);
    return likeness_[entry] + (at - static_cast<float>(entry)) * (likeness_[entry + 1] - likeness_[entry]);
  }

  const Image &scan_, &guide_;
  const Mask& mask_;
  float nearness_[27] = {}, per_entry_ = 0;
  std::vector<float> likeness_;
};

/// The intensity below which logarithms would only show noise: a twentieth of the median.
double floorOf(std::vector<double> values) { return std::max(1e-30, 0.05 * ranked(values, values.size() / 2)); }

}  // namespace

void fuzzyMemberships(double y, const std::vector<double>& centre, double* u) {
  const std::size_t classes = centre.size();
  std::fill_n(u, classes, 0.0);
  if (y <= centre.front()) {
    u[0] = 1;
    return;
  }
  if (y >= centre.back()) {
    u[classes - 1] = 1;
    return;
  }
  double sum = 0;
  for (std::size_t i = 0; i < classes; ++i) {
    const double distance2 = (y - centre[i]) * (y - centre[i]);
    if (distance2 == 0) {
      std::fill_n(u, classes, 0.0);
      u[i] = 1;
      return;
    }
    u[i] = 1 / distance2;
    sum += u[i];
  }
  for (std::size_t i = 0; i < classes; ++i) u[i] /= sum;
}

FuzzyClasses fuzzyCMeans(const Image& noisy, const Mask& mask, const FuzzyOptions& options,
                         const std::function<void(double)>& progress) {
  const std::size_t inside = countOf(mask);
  if (options.classes < 2 || options.classes > max_classes)
    throw InputError({}, std::to_string(options.classes) + " tissue classes", "give 2 to 6");
  if (inside == 0) throw InputError({}, "the mask is empty", "is it the mask of this scan?");
  const double noise = noiseOf(noisy, mask);
  // What is alike is told better by what the first pass leaves; averaging that again would wash thin sulci out.
  const Image once = Denoiser(noisy, noisy, mask, 2 * noise).whole(), scan = Denoiser(noisy, once, mask, noise).whole();
  Chosen chosen = chosenOf(scan, mask, inside);
  if (const auto [low, high] = std::minmax_element(chosen.value.begin(), chosen.value.end()); !(*low < *high))
    throw InputError({}, "all intensities in the mask are equal", "is it the mask of this scan?");

  FuzzyClasses result;
  Bias bias{Polynomial(std::clamp(options.bias_degree, 0, Polynomial::max_degree), chosen.low, chosen.high), {}};
  bias.coefficient = Eigen::VectorXd::Zero(bias.polynomial.size());
  if (options.bias_degree > 0) {
    // The bias is smooth: here averaging twice only takes noise away.
    const Denoiser twice(once, once, mask, 2 * noise);
    std::vector<double> smoothest;
    for (const Vec3& index : chosen.index)
      smoothest.push_back(static_cast<double>(
          twice.at(static_cast<int>(index[0]), static_cast<int>(index[1]), static_cast<int>(index[2]))));
    const double least = floorOf(smoothest);
    std::vector<double> x;
    x.reserve(smoothest.size());
    for (const double value : smoothest) x.push_back(std::log(std::max(value, least)));
    std::vector<double> centre = centresOf(x, options.classes, options.max_iterations);
    result.iterations = fitBias(x, chosen.index, options.max_iterations, progress, centre, bias);
  }
  for (std::size_t k = 0; k < chosen.value.size(); ++k) chosen.value[k] *= std::exp(-bias.at(chosen.index[k]));
  result.centre = centresOf(chosen.value, options.classes, 10 * options.max_iterations);

  result.bias = Image(scan.grid, 1.0F);
  result.membership.assign(static_cast<std::size_t>(options.classes), Image(scan.grid, 0.0F));
  forMask(mask, [&](std::size_t v, const Vec3& index) {
    const double factor = std::exp(bias.at(index));
    std::array<double, max_classes> u{};
    fuzzyMemberships(scan.value[v] / factor, result.centre, u.data());
    result.bias.value[v] = static_cast<float>(factor);
    for (std::size_t i = 0; i < result.membership.size(); ++i) result.membership[i].value[v] = static_cast<float>(u[i]);
  });
  return result;
}

}  // namespace palpate
