#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "model/preparation.h"

namespace palpate {

using KeyHash = std::array<std::uint64_t, 2>;

/// 128 bits of a string. Not for secrets.
KeyHash hashOf(const std::string& bytes);

/// Writes a preparation into an open file. Returns 0 or the errno.
int writePreparation(int file, const KeyHash& key, const Preparation& preparation);

/// Reads it back, bit for bit. False where the file is damaged, cut short, of another layout or for another key;
/// `preparation` then holds nothing useful. What it holds is as it was written, whoever wrote it: see isSound. Never
/// takes more memory than the file is long.
bool readPreparation(int file, const KeyHash& key, Preparation& preparation);

}  // namespace palpate
