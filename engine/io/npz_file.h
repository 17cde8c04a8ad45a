#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/types.h"

namespace palpate {

/// An array of an .npz file: a name and what follows the zip's header, an .npy of version 1.0.
struct NpzArray {
  std::string name;
  std::string npy;
};

/// (count, 3) doubles.
NpzArray npzVectors(const std::string& name, std::span<const Vec3> vectors);
/// (count, 4) int32.
NpzArray npzCells(const std::string& name, std::span<const std::array<int, 4>> cells);

/// Writes what `numpy.load(path)` reads, uncompressed, whole or not at all; the same arrays give the same bytes.
/// Throws std::runtime_error as writeWholeFile does, or where it would be 4 GB or more.
void writeNpz(const std::string& path, std::span<const NpzArray> arrays);

}  // namespace palpate
