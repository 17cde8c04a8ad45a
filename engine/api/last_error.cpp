#include <cstdarg>
#include <cstdio>

#include "api/border.h"

namespace {

thread_local palpate_error last{};  // of the calling thread

}  // namespace

std::int32_t palpate::api::refuse(std::int32_t code, const char* why, ...) {
  std::va_list values;
  va_start(values, why);
  std::vsnprintf(last.text, sizeof last.text, why, values);
  va_end(values);
  return code;
}

std::int32_t palpate::api::poseProblem(const double* pose, const char* what) {
  if (pose == nullptr) return refuse(PALPATE_BAD_ARGUMENT, "%s is NULL", what);
  if (const std::int32_t code = placeProblem(pose, what)) return code;
  if (isPose(pose)) return PALPATE_OK;
  return refuse(PALPATE_BAD_ARGUMENT, "%s has the quaternion x %g, y %g, z %g, w %g, which is no unit one", what,
                pose[3], pose[4], pose[5], pose[6]);
}

std::int32_t palpate::api::placeProblem(const double* x, const char* what) {
  if (x == nullptr) return refuse(PALPATE_BAD_ARGUMENT, "%s is NULL", what);
  if (isPlace(x)) return PALPATE_OK;
  return refuse(PALPATE_BAD_ARGUMENT, "%s is (%g, %g, %g): give finite numbers of at most %g", what, x[0], x[1], x[2],
                Request::farthest);
}

extern "C" const char* palpate_last_error(void) { return last.text; }

extern "C" std::int32_t palpate_keep_error(std::int32_t code, const char* text) {
  return palpate::api::refuse(code, "%s", text);
}
