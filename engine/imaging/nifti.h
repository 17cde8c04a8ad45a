#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "imaging/image.h"

namespace palpate {

/// NIfTI-1 and -2 in one file (.nii, .nii.gz), after nifti1.h and nifti2.h of the NIfTI working group.
struct NiftiOptions {
  /// Where the header says neither sform nor qform: take the voxels' axes for right, anterior and superior, the first
  /// voxel being at the origin, instead of refusing.
  bool assume_ras = false;
  std::function<void(const std::string&)> warn;  // told what is allowed but probably not meant
};

/// Voxels that an image may have at most: 800 along each side, 2 GB as we keep them.
constexpr std::size_t max_image_voxels = std::size_t{1} << 29;

/// Reads an image of numbers with three dimensions. Values are scl_slope * stored + scl_inter; what is no finite number
/// becomes 0, which is warned of. Lengths of the header are in m, mm or um as xyzt_units says (mm where it does not).
/// Where an image lies: sform, else qform.
/// @param name  of the file, for messages
/// Throws InputError where the bytes are no such image, cut short or damaged, have more dimensions, or colours. No
/// memory is taken before the sizes are known to fit the bytes that there are.
/// Test: imaging/nifti_test.cpp; hostile files: tests/fuzz.
Image imageFromNifti(std::string_view bytes, const std::string& name, const NiftiOptions& options = {});

enum class NiftiType { UInt8, Int16, Float32 };

/// The bytes of a NIfTI-1 file (NIfTI-2 where a side is longer than 32767 voxels), in mm, sform and, where the axes are
/// at right angles, qform.
/// @param slope  of whole numbers: values are rounded to multiples of it
std::string niftiFrom(const Image& image, NiftiType type, bool compressed, double slope = 1);

/// A displacement field as ITK has it: five dimensions, intent 1007 (vector), components along L, P, S, mm, float32.
/// @param field  m, in RAS as everything here
std::string niftiFrom(const VectorImage& field, bool compressed);

}  // namespace palpate
