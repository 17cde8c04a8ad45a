#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace palpate::app {

/// An 8-bit sRGB image, upper row first.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // (height, width, 3)
};

/// Throws InputError that names the file and the reason.
Picture readPng(const std::string& file);

/// Throws std::runtime_error that names the file and the reason.
void writePng(const std::string& file, const Picture& picture);

}  // namespace palpate::app
