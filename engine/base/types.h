#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

namespace palpate {

/// Set-up works in double; what the real-time loop reads is float.
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Vec3f = Eigen::Vector3f;
using Quat = Eigen::Quaterniond;
using Box3 = Eigen::AlignedBox3d;

/// Smallest axis-aligned box around all points; empty where there are none.
inline Box3 boxOf(const std::vector<Vec3>& points) {
  Box3 box;
  for (const Vec3& x : points) box.extend(x);
  return box;
}

/// One node's vector as the kernels load it: x, y, z and an unused lane that stays 0.
template <class Real>
struct alignas(4 * sizeof(Real)) Real4 {
  Real x = 0, y = 0, z = 0, w = 0;
};
using Float4 = Real4<float>;    // the real-time loop's
using Double4 = Real4<double>;  // the batch solver's

template <class Real>
Vec3 toVec3(const Real4<Real>& a) {
  return {a.x, a.y, a.z};
}
template <class Real>
Real4<Real> toReal4(const Vec3& a) {
  return {static_cast<Real>(a.x()), static_cast<Real>(a.y()), static_cast<Real>(a.z()), 0};
}
inline Float4 toFloat4(const Vec3& a) { return toReal4<float>(a); }
inline bool isZero(const Float4& a) { return a.x == 0 && a.y == 0 && a.z == 0; }

/// Rigid pose: x_world = orientation * x_local + position. Position in m.
struct Pose {
  Vec3 position = Vec3::Zero();
  Quat orientation = Quat::Identity();

  Vec3 toWorld(const Vec3& local) const { return orientation * local + position; }
  Vec3 toLocal(const Vec3& world) const { return orientation.conjugate() * (world - position); }
  /// Whether its numbers are finite, and the orientation's not near 0.
  bool isSound() const { return position.allFinite() && orientation.coeffs().allFinite() && orientation.norm() > 0.5; }
};

/// Allocator for arrays that vector units stream: 64 bytes is a cache line and an AVX-512 register.
template <class T>
struct AlignedAllocator {
  using value_type = T;
  static constexpr std::align_val_t alignment{64};

  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) {}

  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), alignment)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, alignment); }
  template <class U>
  bool operator==(const AlignedAllocator<U>&) const {
    return true;
  }
};

template <class T>
using AlignedVector = std::vector<T, AlignedAllocator<T>>;

inline AlignedVector<Double4> inDouble(const AlignedVector<Float4>& field) {
  AlignedVector<Double4> result;
  result.reserve(field.size());
  for (const Float4& a : field) result.push_back({a.x, a.y, a.z, 0});
  return result;
}

}  // namespace palpate
