#include <cstdarg>
#include <cstdio>

#include "api/border.h"

/// libpalpate keeps why a call is not done, of this library's calls, too.
std::int32_t palpate::api::refuse(std::int32_t code, const char* why, ...) {
  palpate_error error{};
  std::va_list values;
  va_start(values, why);
  std::vsnprintf(error.text, sizeof error.text, why, values);
  va_end(values);
  return palpate_keep_error(code, error.text);
}
