#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "approximation/mmls.h"
#include "approximation/neighbours.h"
#include "base/float4.h"
#include "discretization/surface/surface_tree.h"
#include "imaging/image.h"

namespace palpate {

/// Where the points of a body at rest are now: x = X + u(X).
class Deformation {
 public:
  virtual ~Deformation() = default;

  /// u (m) and du/dX at a point of the body at rest, or a little outside. False where there is none.
  virtual bool at(const Vec3& X, Vec3& u, Mat3& gradient) const = 0;
  /// u (m) alone, which may cost less.
  virtual bool value(const Vec3& X, Vec3& u) const {
    Mat3 gradient;
    return at(X, u, gradient);
  }
  /// Distance of a point from the body's surface at rest, m; negative inside.
  virtual double surfaceDistance(const Vec3& X) const = 0;
  /// The same, quicker, by what is known: `other` is that of a point `apart` (m) away.
  virtual double surfaceDistance(const Vec3& X, double /*other*/, double /*apart*/) const { return surfaceDistance(X); }
  /// The body at rest, m.
  virtual Box3 box() const = 0;
};

/// The field that a solution is: u(X) = sum_j N_j(X) u_j by modified moving least squares (paper eqs. 1-7). Any number
/// of threads may ask.
class MmlsDeformation : public Deformation {
 public:
  /// @param X, radius, u  of the nodes (node_count), m
  /// @param surface       of the body at rest
  MmlsDeformation(std::vector<Vec3> X, std::vector<double> radius, std::vector<Vec3> u, const MmlsOptions& options,
                  TriangleSurface surface);

  bool at(const Vec3& X, Vec3& u, Mat3& gradient) const override;
  bool value(const Vec3& X, Vec3& u) const override;
  double surfaceDistance(const Vec3& X) const override { return surface_.signedDistance(X); }
  double surfaceDistance(const Vec3& X, double other, double apart) const override;
  Box3 box() const override { return boundingBox(surface_.surface()); }

 private:
  std::vector<Vec3> X_, u_;
  std::vector<double> radius_;
  MmlsOptions options_;
  /// Nodes that may reach points of a cube, of which a thread keeps those it was in.
  struct Cube;
  const Cube& cubeAround(const Vec3& X) const;

  Neighbours neighbours_;
  double side_;                // m, of the cubes
  std::vector<double> reach_;  // (node_count) m, from a cube's middle
  Neighbours in_reach_;
  std::uint64_t number_;  // no two have the same
  SurfaceTree surface_;
};

/// Another deformation sampled on a regular grid, and cubic between (Catmull-Rom, third order): a hundredth of the
/// cost. Samples outside the body to which the other does not reach are continued linearly from those beside them.
/// Where one of the 64 samples around is still missing, it asks the other. Where the field changes too quickly between
/// samples, near points that were moved and at the border, `value` asks the other, too.
class SampledDeformation : public Deformation {
 public:
  /// @param step  m, of the samples; a third of the nodes' spacing leaves errors below 0.01 mm of a smooth shift
  SampledDeformation(const Deformation& whole, double step);

  /// What is between the samples, which may be off by 0.1 mm where the field is rough.
  bool at(const Vec3& X, Vec3& u, Mat3& gradient) const override;
  /// Within 0.01 mm of the other's.
  bool value(const Vec3& X, Vec3& u) const override;
  /// Whether the other is asked for the value here.
  bool isRough(const Vec3& X) const;
  using Deformation::surfaceDistance;
  /// Linear between samples; far from the surface of the right sign, and no more than it is.
  double surfaceDistance(const Vec3& X) const override;
  Box3 box() const override { return whole_.box(); }

  const ImageGrid& grid() const { return distance_.grid; }
  /// u at a sample. @pre isKnown
  Vec3 sample(std::size_t v) const { return toVec3(u_[v]); }
  bool isKnown(std::size_t v) const { return known_[v] != 0; }
  float sampleDistance(std::size_t v) const { return distance_.value[v]; }
  double step() const { return step_; }

 private:
  /// What is known of the 64 samples around the cell that begins at a sample's right, front and upper neighbour.
  enum class Around : char { Missing, Smooth, Rough };
  struct Slopes;
  struct Weights;

  void sampleRow(int j, int k, Slopes& slopes);
  void extend(Slopes& slopes);
  void findWholeCells();
  void findRoughCells();
  double thirdDifference(std::size_t v) const;
  bool cellAt(const Vec3& X, std::size_t& first, Vec3& t) const;

  const Deformation& whole_;
  double step_;
  Image distance_;              // m
  AlignedVector<Float4> u_;     // (voxel_count)
  std::vector<char> known_;     // (voxel_count)
  std::vector<Around> around_;  // (voxel_count)
};

/// Where something came from.
struct Origin {
  Vec3 X = Vec3::Zero();         // m, at rest
  Mat3 gradient = Mat3::Zero();  // du/dX there
};

/// Finds where in the body at rest the point now at x came from. Newton's method on X + u(X) = x, from the sample whose
/// place now is nearest; where the field is rough (SampledDeformation::isRough) it ends with values of the whole field
/// and slopes of the sampled one. Any number of threads may ask.
class InverseDeformation {
 public:
  explicit InverseDeformation(const SampledDeformation& forward);

  /// @return false where no point of the body is at x now
  bool at(const Vec3& x, Origin& origin) const;
  /// The same from a good guess in origin.X where there is one, such as what moves as the voxel before: mostly one
  /// evaluation of the field, whose gradient is that a few um beside X at most.
  bool atNear(const Vec3& x, Origin& origin) const;
  /// The same by another field, of which the sampled one is an image, to 1e-9 m.
  bool at(const Vec3& x, const Deformation& exact, Origin& origin) const;

 private:
  enum class Outcome { Inside, Outside, Lost };
  Outcome newton(const Vec3& x, const Deformation& exact, int max_iterations, Origin& origin) const;
  bool polish(const Vec3& x, Origin& origin) const;
  void fillSeeds(const std::vector<std::int32_t>& own);
  bool startAt(const Vec3& x, Vec3& X) const;
  Vec3 placeOf(std::int32_t sample) const;

  const SampledDeformation& forward_;
  ImageGrid bins_;                  // of the world as it is now
  std::vector<std::int32_t> seed_;  // (bin_count) sample to start from, or -1
};

}  // namespace palpate
