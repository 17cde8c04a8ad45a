#pragma once

#include <string>

namespace palpate {

/// One line for reports: version, compiler, build type, instruction set of the kernel, sanitizers.
std::string buildInfo();

}  // namespace palpate
