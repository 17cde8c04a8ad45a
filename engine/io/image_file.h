#pragma once

#include <string>

#include "base/input_error.h"
#include "imaging/nifti.h"

namespace palpate {

/// Reads a NIfTI file (imaging/nifti.h), compressed or not, whatever its name. Throws InputError at `asked_from` (where
/// another file names this one) where it can't be read, else at the file.
Image readImage(const std::string& path, const NiftiOptions& options = {}, const SourceLocation& asked_from = {});

/// Writes a NIfTI file, compressed where its name ends in .gz; whole or not at all.
/// Throws std::runtime_error that names the file and the reason.
void writeImage(const std::string& path, const Image& image, NiftiType type = NiftiType::Float32, double slope = 1);
void writeImage(const std::string& path, const Mask& mask);
void writeImage(const std::string& path, const VectorImage& field);

}  // namespace palpate
