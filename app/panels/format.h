#pragma once

#include <string>

namespace palpate::app {

/// printf into a string; at most 511 characters.
std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

}  // namespace palpate::app
