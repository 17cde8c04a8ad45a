#pragma once

#include <cstring>
#include <type_traits>

#include "base/kernel_namespace.h"
#include "base/types.h"

namespace palpate {
inline namespace PALPATE_KERNEL {

/// Four numbers in one register (or two); what a Real4 is computed with.
template <class Real>
struct GroupType {
  typedef Real type __attribute__((vector_size(4 * sizeof(Real))));  // NOLINT: `using` drops the attribute here
};
template <class Real>
using GroupOf = typename GroupType<Real>::type;
using Group = GroupOf<float>;

template <class Real>
GroupOf<Real> loadGroup(const Real* a) {  // a is aligned to a whole group
  GroupOf<Real> g;
  std::memcpy(&g, __builtin_assume_aligned(a, sizeof g), sizeof g);
  return g;
}
template <class Real>
void storeGroup(Real* a, const std::type_identity_t<GroupOf<Real>>& g) {
  std::memcpy(__builtin_assume_aligned(a, sizeof g), &g, sizeof g);
}

template <class Real>
GroupOf<Real> load(const Real4<Real>& a) {
  GroupOf<Real> g;
  std::memcpy(&g, &a, sizeof g);
  return g;
}
template <class Real>
void store(Real4<Real>& a, const std::type_identity_t<GroupOf<Real>>& g) {
  std::memcpy(static_cast<void*>(&a), &g, sizeof g);
}

/// y += a x
template <class Real>
void addScaled(Real4<Real>& y, std::type_identity_t<Real> a, const Real4<Real>& x) {
  store(y, load(y) + a * load(x));
}

/// y *= a
template <class Real>
void scale(Real4<Real>& y, std::type_identity_t<Real> a) {
  store(y, a * load(y));
}

}  // namespace PALPATE_KERNEL
}  // namespace palpate
