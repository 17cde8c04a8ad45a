#include "support/realtime_guard.h"

#include <dlfcn.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdlib>

namespace palpate::test {
namespace {

void onForbiddenCall(int, siginfo_t* info, void*) { _exit(100 + info->si_syscall % 100); }

}  // namespace

void allowOnlySleeping() {
  struct sigaction action {};
  action.sa_sigaction = onForbiddenCall;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSYS, &action, nullptr);
  const auto allow = [](unsigned call, unsigned char skip) {
    return sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, skip, 0);
  };
  // exit_group and rt_sigreturn are how the child ends; clock_gettime is the look at the thread's own
  // CPU clock before the sleep (and the time of day where the time stamp counter is not trusted);
  // getrusage follows a late tick.
  std::array<sock_filter, 9> program = {{
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      allow(SYS_clock_nanosleep, 6),
      allow(SYS_restart_syscall, 5),
      allow(SYS_clock_gettime, 4),
      allow(SYS_getrusage, 3),
      allow(SYS_exit_group, 2),
      allow(SYS_rt_sigreturn, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  }};
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 || prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) != 0) {
    _exit(kNoFilter);
  }
}

int exitCodeOfChild(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) _exit(body());
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

}  // namespace palpate::test

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
