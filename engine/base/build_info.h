#pragma once

#include <string>

namespace palpate {

/// One line for reports: version, compiler, build type, instruction set, sanitizers.
std::string buildInfo();

}  // namespace palpate
