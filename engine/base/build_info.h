#pragma once

#include <string>

namespace palpate {

/// One line for reports: version, compiler, build type, instruction set of the kernel, sanitizers.
std::string buildInfo();

std::string programVersion();

/// A hash of the engine's sources as they were compiled: programs that agree in it and in buildInfo compute the same
/// bits on the same processor.
std::string sourceIdentity();

/// The source tree that the program was built from.
std::string sourceFolder();

/// Where assets/ and shaders/ are: $PALPATE_DATA_DIR; else share/palpate of the folder that the program, or the library
/// that this is in, was installed to, wherever that is now; else the source tree.
std::string dataFolder();

}  // namespace palpate
