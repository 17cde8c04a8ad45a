#pragma once

#include <string>

namespace palpate {

/// One line for reports: version, compiler, build type, instruction set of the kernel, sanitizers.
std::string buildInfo();

/// A hash of the engine's sources as they were compiled: programs that agree in it and in buildInfo compute the same
/// bits on the same processor.
std::string sourceIdentity();

/// The source tree that the program was built from: where assets/ and shaders/ are.
std::string sourceFolder();

}  // namespace palpate
