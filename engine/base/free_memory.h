#pragma once

#include <cstddef>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace palpate {

/// Gives memory that is free back to the system, where its C library keeps it: after some hundred MB of many pieces.
inline void giveFreeMemoryBack() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace palpate
