#pragma once

#include <memory>
#include <vector>

#include "approximation/mmls.h"
#include "approximation/neighbours.h"
#include "discretization/surface/surface_tree.h"
#include "imaging/image.h"

namespace palpate {

/// Where the points of a body at rest are now: x = X + u(X).
class Deformation {
 public:
  virtual ~Deformation() = default;

  /// u (m) and du/dX at a point of the body at rest, or a little outside. False where there is none.
  virtual bool at(const Vec3& X, Vec3& u, Mat3& gradient) const = 0;
  /// Distance of a point from the body's surface at rest, m; negative inside.
  virtual double surfaceDistance(const Vec3& X) const = 0;
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
  double surfaceDistance(const Vec3& X) const override { return surface_.signedDistance(X); }
  Box3 box() const override { return boundingBox(surface_.surface()); }

 private:
  std::vector<Vec3> X_, u_;
  std::vector<double> radius_;
  MmlsOptions options_;
  Neighbours neighbours_;
  SurfaceTree surface_;
};

/// Another deformation sampled on a regular grid, and cubic between (Catmull-Rom, third order): a hundredth of the
/// cost. Samples outside the body to which the other does not reach are continued linearly from those beside them. Where
/// one of the 64 samples around is still missing, it asks the other.
class SampledDeformation : public Deformation {
 public:
  /// @param step  m, of the samples; a third of the nodes' spacing leaves errors below 0.01 mm of a smooth shift
  SampledDeformation(const Deformation& whole, double step);

  bool at(const Vec3& X, Vec3& u, Mat3& gradient) const override;
  /// Linear between samples.
  double surfaceDistance(const Vec3& X) const override;
  Box3 box() const override { return whole_.box(); }

  const ImageGrid& grid() const { return distance_.grid; }
  /// u at a sample. @pre isKnown
  const Vec3f& sample(std::size_t v) const { return u_[v]; }
  bool isKnown(std::size_t v) const { return known_[v] != 0; }
  float sampleDistance(std::size_t v) const { return distance_.value[v]; }
  double step() const { return step_; }

 private:
  void extend(std::vector<Eigen::Matrix3f>& gradient);

  const Deformation& whole_;
  double step_;
  Image distance_;           // m
  std::vector<Vec3f> u_;     // (voxel_count)
  std::vector<char> known_;  // (voxel_count)
};

/// Finds where in the body at rest the point now at x came from. Newton's method on X + u(X) = x, from the sample whose
/// place now is nearest. Any number of threads may ask.
class InverseDeformation {
 public:
  explicit InverseDeformation(const SampledDeformation& forward);

  /// @param exact  the field to solve with: the sampled one, or the one that it was sampled from
  /// @param gradient  du/dX there
  /// @return false where no point of the body is at x now
  bool at(const Vec3& x, const Deformation& exact, Vec3& X, Mat3& gradient) const;
  bool at(const Vec3& x, Vec3& X, Mat3& gradient) const { return at(x, forward_, X, gradient); }
  /// The same for the sampled field, from a good guess X where there is one, such as what moves as the voxel before.
  bool atNear(const Vec3& x, Vec3& X, Mat3& gradient) const;

 private:
  enum class Outcome { Inside, Outside, Lost };
  Outcome newton(const Vec3& x, const Deformation& exact, int max_iterations, Vec3& X, Mat3& gradient) const;
  bool seedAt(const Vec3& x, Vec3& X) const;

  const SampledDeformation& forward_;
  ImageGrid bins_;                  // of the world as it is now
  std::vector<std::int32_t> seed_;  // (bin_count) sample that is now nearest to the bin's middle, or -1
  std::vector<char> near_;          // (bin_count) whether a seed is near enough to start from
};

}  // namespace palpate
