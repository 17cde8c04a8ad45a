#pragma once

#include <string>

#include "base/input_error.h"

namespace palpate {

/// A file's bytes. Throws InputError at `asked_from` (where another file names this one), or at the
/// file itself, where it is missing, a directory, or can't be read.
std::string readWholeFile(const std::string& path, const SourceLocation& asked_from = {});

}  // namespace palpate
