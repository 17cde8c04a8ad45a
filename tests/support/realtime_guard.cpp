#include "support/realtime_guard.h"

#include <dlfcn.h>
#include <pthread.h>

#include <cerrno>
#include <cstddef>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

namespace palpate::test {
bool guardAvailable() { return false; }
void startGuard() {}
GuardCounts stopGuard() { return {}; }
}  // namespace palpate::test

#else

namespace {

thread_local bool guarded = false;
thread_local palpate::test::GuardCounts counts;

void allocated() {
  if (guarded) ++counts.allocations;
}
void locked() {
  if (guarded) ++counts.locks;
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

namespace palpate::test {

bool guardAvailable() { return true; }

void startGuard() {
  counts = {};
  guarded = true;
}

GuardCounts stopGuard() {
  guarded = false;
  return counts;
}

}  // namespace palpate::test

extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
  allocated();
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  allocated();
  return __libc_calloc(count, size);
}
void* realloc(void* p, std::size_t size) {
  allocated();
  return __libc_realloc(p, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  allocated();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  allocated();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** p, std::size_t alignment, std::size_t size) {
  allocated();
  *p = __libc_memalign(alignment, size);
  return *p != nullptr ? 0 : ENOMEM;
}
void free(void* p) {
  if (guarded && p != nullptr) ++counts.frees;
  __libc_free(p);
}

int pthread_mutex_lock(pthread_mutex_t* mutex) {
  static const auto real = next<int (*)(pthread_mutex_t*)>("pthread_mutex_lock");
  locked();
  return real(mutex);
}
int pthread_rwlock_rdlock(pthread_rwlock_t* lock) {
  static const auto real = next<int (*)(pthread_rwlock_t*)>("pthread_rwlock_rdlock");
  locked();
  return real(lock);
}
int pthread_rwlock_wrlock(pthread_rwlock_t* lock) {
  static const auto real = next<int (*)(pthread_rwlock_t*)>("pthread_rwlock_wrlock");
  locked();
  return real(lock);
}
int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  static const auto real = next<int (*)(pthread_cond_t*, pthread_mutex_t*)>("pthread_cond_wait");
  locked();
  return real(condition, mutex);
}

}  // extern "C"

#endif
