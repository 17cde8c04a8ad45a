#pragma once

#include <string>
#include <vector>

#include "app/render/picture.h"

namespace palpate::app {

/// Writes pictures of one size as an animated PNG (the PNG specification's third edition, chunks acTL, fcTL, fdAT),
/// which browsers play without end and other programs show the first picture of. 255 colours for all pictures
/// together; what hardly changes from one to the next is not written again.
/// @param seconds       that each picture stays, 0.01 .. 60
/// @param last_seconds  that the last one stays
/// Throws std::invalid_argument for no pictures or unequal sizes, std::runtime_error with file and reason.
void writeAnimation(const std::string& file, const std::vector<Picture>& pictures, double seconds, double last_seconds);

}  // namespace palpate::app
