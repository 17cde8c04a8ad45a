#include "imaging/warp.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "base/parallel_for.h"

namespace palpate {
namespace {

/// Calls each(v, i, j, k) for all voxels in slices, on all cores; `progress` from this thread alone, before slices.
template <class Each>
void forVoxels(const ImageGrid& grid, const std::function<void(double)>& progress, Each each) {
  std::atomic<int> done{0};
  const SetupWatch watch([&] {
    if (progress) progress(static_cast<double>(done.load()) / grid.size[2]);
  });
  parallelFor(
      grid.size[2],
      [&](int first, int last) {
        for (int k = first; k < last; ++k) {
          for (int j = 0; j < grid.size[1]; ++j)
            for (int i = 0; i < grid.size[0]; ++i) each(grid.at(i, j, k), i, j, k);
          ++done;
        }
      },
      1);
}

/// Beyond half a voxel from the outermost centres an image says nothing.
bool covers(const ImageGrid& grid, const Vec3& index) {
  for (int a = 0; a < 3; ++a)
    if (!(index[a] >= -0.5 && index[a] <= grid.size[static_cast<std::size_t>(a)] - 0.5)) return false;
  return true;
}

/// Where on an image the voxel's content came from.
Vec3 sourceIndex(const ImageGrid& image, const BackwardField& field, std::size_t v, int i, int j, int k) {
  return image.indexOf(field.body.grid.worldOf(i, j, k) + field.to_rest.value[v].cast<double>());
}

}  // namespace

BackwardField backwardField(const SampledDeformation& forward, const ImageGrid& grid,
                            const std::function<void(double)>& progress) {
  BackwardField field;
  field.to_rest = VectorImage(grid, Vec3f::Zero());
  field.jacobian = Image(grid, 1.0F);
  field.body = field.vacated = Mask(grid);
  const InverseDeformation inverse(forward);
  forVoxels(grid, progress, [&](std::size_t v, int i, int j, int k) {
    const Vec3 x = grid.worldOf(i, j, k);
    Vec3 X;
    Mat3 gradient;
    // The voxel before in its row says where to start.
    bool found = false;
    if (i > 0 && field.body.value[v - 1] != 0) {
      X = x + field.to_rest.value[v - 1].cast<double>();
      found = inverse.atNear(x, X, gradient);
    } else {
      found = inverse.at(x, X, gradient);
    }
    if (found) {
      field.to_rest.value[v] = (X - x).cast<float>();
      field.jacobian.value[v] = static_cast<float>((Mat3::Identity() + gradient).determinant());
      field.body.value[v] = 1;
    } else {
      field.vacated.value[v] = forward.surfaceDistance(x) <= 0;
    }
  });
  return field;
}

VectorImage forwardField(const SampledDeformation& forward, const ImageGrid& grid) {
  VectorImage field(grid, Vec3f::Zero());
  forVoxels(grid, {}, [&](std::size_t v, int i, int j, int k) {
    const Vec3 X = grid.worldOf(i, j, k);
    Vec3 u;
    Mat3 gradient;
    if (forward.surfaceDistance(X) <= 0 && forward.at(X, u, gradient)) field.value[v] = u.cast<float>();
  });
  return field;
}

Image warped(const Image& image, const BackwardField& field, Between between, float fill) {
  Image result(field.body.grid, fill);
  forVoxels(result.grid, {}, [&](std::size_t v, int i, int j, int k) {
    if (field.vacated.value[v]) return;
    const Vec3 index = sourceIndex(image.grid, field, v, i, j, k);
    if (!covers(image.grid, index)) return;
    result.value[v] = between == Between::Cubic     ? cubicValue(image, index)
                      : between == Between::Nearest ? nearestValue(image, index)
                                                    : linearValue(image, index);
  });
  return result;
}

Mask validOf(const ImageGrid& image, const BackwardField& field) {
  Mask valid(field.body.grid);
  forVoxels(valid.grid, {}, [&](std::size_t v, int i, int j, int k) {
    valid.value[v] = !field.vacated.value[v] && covers(image, sourceIndex(image, field, v, i, j, k));
  });
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
      Vec3 X, u;
      Mat3 gradient;
      if (inverse.at(x, whole, X, gradient)) error[static_cast<std::size_t>(n)] = (X - written).norm();
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
