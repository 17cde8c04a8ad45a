#include "imaging/warp.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "base/parallel_for.h"

namespace palpate {
namespace {

/// Calls each(j, k) for all rows of voxels, on all cores; `progress` from this thread alone, before slices.
template <class Each>
void eachRow(const ImageGrid& grid, const std::function<void(double)>& progress, Each each) {
  std::atomic<int> done{0};
  const SetupWatch watch([&] {
    if (progress) progress(static_cast<double>(done.load()) / grid.size[2]);
  });
  parallelFor(
      grid.size[2],
      [&](int first, int last) {
        for (int k = first; k < last; ++k) {
          for (int j = 0; j < grid.size[1]; ++j) each(j, k);
          ++done;
        }
      },
      1);
}

/// Tells for the voxels of a row, from the first on, whether they lie in the body at rest.
class InsideAlongRow {
 public:
  InsideAlongRow(const SampledDeformation& forward, const ImageGrid& grid)
      : forward_(forward), steepest_(2 * grid.axes.col(0).norm()) {}

  bool operator()(const Vec3& X) {
    if (same_ > 0) {
      --same_;
      return inside_;
    }
    // Between samples of a distance that changes by a at most along each axis, it changes by sqrt(3) a at most.
    const double distance = forward_.surfaceDistance(X);
    inside_ = distance <= 0;
    same_ = static_cast<int>(std::abs(distance) / steepest_);
    return inside_;
  }

 private:
  const SampledDeformation& forward_;
  double steepest_;  // m, of the distance from voxel to voxel
  int same_ = 0;
  bool inside_ = false;
};

/// Beyond half a voxel from the outermost centres an image says nothing.
bool covers(const ImageGrid& grid, const Vec3& index) {
  for (int a = 0; a < 3; ++a)
    if (!(index[a] >= -0.5 && index[a] <= grid.size[static_cast<std::size_t>(a)] - 0.5)) return false;
  return true;
}

/// Calls each(v, index) for the voxels that are not vacated, with where on an image their content came from.
template <class Each>
void forSources(const ImageGrid& image, const BackwardField& field, Each each) {
  const ImageGrid& grid = field.body.grid;
  const bool same = sameGrid(image, grid);
  eachRow(grid, {}, [&](int j, int k) {
    const Vec3 begin = image.indexOf(grid.worldOf(0, j, k)), step = image.inverse * grid.axes.col(0);
    for (int i = 0; i < grid.size[0]; ++i) {
      const std::size_t v = grid.at(i, j, k);
      if (field.vacated.value[v]) continue;
      const Vec3 here = same ? Vec3(i, j, k) : Vec3(begin + i * step);
      each(v, field.body.value[v] ? Vec3(here + image.inverse * field.to_rest.value[v].cast<double>()) : here);
    }
  });
}

}  // namespace

BackwardField backwardField(const SampledDeformation& forward, const InverseDeformation& inverse, const ImageGrid& grid,
                            const std::function<void(double)>& progress) {
  BackwardField field;
  field.to_rest = VectorImage(grid, Vec3f::Zero());
  field.jacobian = Image(grid, 1.0F);
  field.body = field.vacated = Mask(grid);
  eachRow(grid, progress, [&](int j, int k) {
    InsideAlongRow insideAtRest(forward, grid);
    Origin origin;
    Vec3 before = Vec3::Zero();  // X of the voxel before in its row
    int found = 0;               // voxels in a row
    for (int i = 0; i < grid.size[0]; ++i) {
      const std::size_t v = grid.at(i, j, k);
      const Vec3 x = grid.worldOf(i, j, k);
      // The voxels before say where to start.
      const Vec3 last = origin.X;
      if (found > 0)
        origin.X += found > 1 ? Vec3(last - before) : Vec3(grid.axes.col(0) - origin.gradient * grid.axes.col(0));
      const bool is_body = found > 0 ? inverse.atNear(x, origin) : inverse.at(x, origin);
      const bool was_body = insideAtRest(x);
      before = last;
      found = is_body ? found + 1 : 0;
      if (!is_body) {
        field.vacated.value[v] = was_body;
        continue;
      }
      field.to_rest.value[v] = (origin.X - x).cast<float>();
      field.jacobian.value[v] = static_cast<float>((Mat3::Identity() + origin.gradient).determinant());
      field.body.value[v] = 1;
    }
  });
  return field;
}

VectorImage forwardField(const SampledDeformation& forward, const ImageGrid& grid) {
  VectorImage field(grid, Vec3f::Zero());
  eachRow(grid, {}, [&](int j, int k) {
    InsideAlongRow inside(forward, grid);
    for (int i = 0; i < grid.size[0]; ++i) {
      const Vec3 X = grid.worldOf(i, j, k);
      Vec3 u;
      if (inside(X) && forward.value(X, u)) field.value[grid.at(i, j, k)] = u.cast<float>();
    }
  });
  return field;
}

Image warped(const Image& image, const BackwardField& field, Between between, float fill) {
  Image result(field.body.grid, fill);
  const bool same = sameGrid(image.grid, result.grid);
  forSources(image.grid, field, [&](std::size_t v, const Vec3& index) {
    if (same && !field.body.value[v])
      result.value[v] = image.value[v];
    else if (covers(image.grid, index))
      result.value[v] = between == Between::Cubic     ? cubicValue(image, index)
                        : between == Between::Nearest ? nearestValue(image, index)
                                                      : linearValue(image, index);
  });
  return result;
}

Mask validOf(const ImageGrid& image, const BackwardField& field) {
  Mask valid(field.body.grid);
  forSources(image, field, [&](std::size_t v, const Vec3& index) { valid.value[v] = covers(image, index); });
  return valid;
}

WarpCheck checkField(const BackwardField& field, const Deformation& whole, const InverseDeformation& inverse,
                     int count) {
  std::vector<std::size_t> inside;
  for (std::size_t v = 0; v < field.body.value.size(); ++v)
    if (field.body.value[v]) inside.push_back(v);
  WarpCheck check;
  if (inside.empty()) return check;
  count = static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(count), inside.size()));
  std::vector<double> error(static_cast<std::size_t>(count), -1), round_trip(error.size(), 0);
  const ImageGrid& grid = field.body.grid;
  parallelFor(count, [&](int first, int last) {
    for (int n = first; n < last; ++n) {
      // The golden ratio's multiples are spread evenly and fall in step with no row of voxels.
      const double share = std::fmod((n + 1) * 0.6180339887498949, 1.0);
      const std::size_t v = inside[static_cast<std::size_t>(share * static_cast<double>(inside.size()))];
      const auto row = static_cast<std::size_t>(grid.size[0]), plane = row * static_cast<std::size_t>(grid.size[1]);
      const Vec3 x =
          grid.worldOf(static_cast<int>(v % row), static_cast<int>(v % plane / row), static_cast<int>(v / plane));
      const Vec3 written = x + field.to_rest.value[v].cast<double>();
      Origin origin;
      if (inverse.at(x, whole, origin)) error[static_cast<std::size_t>(n)] = (origin.X - written).norm();
      Vec3 u;
      Mat3 gradient;
      if (whole.at(written, u, gradient)) round_trip[static_cast<std::size_t>(n)] = (written + u - x).norm();
    }
  });
  for (std::size_t n = 0; n < error.size(); ++n) {
    check.round_trip = std::max(check.round_trip, round_trip[n]);
    if (error[n] < 0) continue;  // at the very surface one may find it inside, and the other not
    ++check.count;
    check.mean += error[n];
    check.max = std::max(check.max, error[n]);
  }
  if (check.count > 0) check.mean /= check.count;
  return check;
}

}  // namespace palpate
