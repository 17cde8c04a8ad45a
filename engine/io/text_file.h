#pragma once

#include <cstdint>
#include <string>

#include "base/input_error.h"

namespace palpate {

/// What is read at most unless a caller says otherwise: a binary STL file of twenty million faces fits.
constexpr std::uintmax_t default_max_file_bytes = std::uintmax_t{1} << 30;

/// A file's bytes. Throws InputError at `asked_from` (where another file names this one), or at the
/// file itself, where it is missing, no regular file (a folder, a device, a pipe, which need not end), longer than
/// `max_bytes`, or can't be read.
std::string readWholeFile(const std::string& path, const SourceLocation& asked_from = {},
                          std::uintmax_t max_bytes = default_max_file_bytes);

}  // namespace palpate
