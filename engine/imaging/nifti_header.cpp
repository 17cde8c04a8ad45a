#include "imaging/nifti_header.h"

#include "base/input_error.h"

namespace palpate::nifti {
namespace {

Header readFirst(std::string_view b, bool swapped) {
  Header h;
  h.swapped = swapped;
  const auto real = [&](std::size_t at) { return static_cast<double>(numberAt<float>(b, at, swapped)); };
  const auto whole = [&](std::size_t at) { return numberAt<std::int16_t>(b, at, swapped); };
  for (std::size_t d = 0; d < 8; ++d) {
    h.dim[d] = whole(40 + 2 * d);
    h.pixdim[d] = real(76 + 4 * d);
  }
  h.datatype = whole(70);
  h.bitpix = whole(72);
  h.vox_offset = real(108);
  h.slope = real(112);
  h.intercept = real(116);
  h.units = static_cast<unsigned char>(b[123]);
  h.qform_code = whole(252);
  h.sform_code = whole(254);
  for (int c = 0; c < 3; ++c) {
    h.quaternion[c] = real(256 + 4 * static_cast<std::size_t>(c));
    h.qoffset[c] = real(268 + 4 * static_cast<std::size_t>(c));
    for (int k = 0; k < 4; ++k)
      h.srow(c, k) = real(280 + 16 * static_cast<std::size_t>(c) + 4 * static_cast<std::size_t>(k));
  }
  return h;
}

Header readSecond(std::string_view b, bool swapped) {
  Header h;
  h.bytes = header_bytes_2;
  h.swapped = swapped;
  const auto real = [&](std::size_t at) { return numberAt<double>(b, at, swapped); };
  const auto whole = [&](std::size_t at) { return numberAt<std::int32_t>(b, at, swapped); };
  for (std::size_t d = 0; d < 8; ++d) {
    h.dim[d] = numberAt<std::int64_t>(b, 16 + 8 * d, swapped);
    h.pixdim[d] = real(104 + 8 * d);
  }
  h.datatype = numberAt<std::int16_t>(b, 12, swapped);
  h.bitpix = numberAt<std::int16_t>(b, 14, swapped);
  h.vox_offset = static_cast<double>(numberAt<std::int64_t>(b, 168, swapped));
  h.slope = real(176);
  h.intercept = real(184);
  h.units = whole(500);
  h.qform_code = whole(344);
  h.sform_code = whole(348);
  for (int c = 0; c < 3; ++c) {
    h.quaternion[c] = real(352 + 8 * static_cast<std::size_t>(c));
    h.qoffset[c] = real(376 + 8 * static_cast<std::size_t>(c));
    for (int k = 0; k < 4; ++k)
      h.srow(c, k) = real(400 + 32 * static_cast<std::size_t>(c) + 8 * static_cast<std::size_t>(k));
  }
  return h;
}

}  // namespace

Header readHeader(std::string_view b, const std::string& name) {
  const auto refuse = [&](const std::string& problem, const std::string& advice) -> InputError {
    return {{name}, problem, advice};
  };
  const std::string no_nifti = "give a .nii or .nii.gz file; DICOM folders are converted by dcm2niix";
  if (b.size() < header_bytes_1)
    throw refuse("this is no NIfTI file: it has only " + std::to_string(b.size()) + " bytes", no_nifti);
  for (const bool swapped : {false, true}) {
    const auto size = numberAt<std::int32_t>(b, 0, swapped);
    if (size == static_cast<std::int32_t>(header_bytes_1)) {
      const std::string_view magic = b.substr(344, 4);
      if (magic == std::string_view("n+1\0", 4)) return readFirst(b, swapped);
      if (magic == std::string_view("ni1\0", 4))
        throw refuse("this is the header of a pair of files (.hdr and .img)", "convert them to one .nii file");
      throw refuse("this is an Analyze 7.5 header: it does not say which side is left", "convert it to NIfTI");
    }
    if (size == static_cast<std::int32_t>(header_bytes_2)) {
      if (b.size() < header_bytes_2) throw refuse("the NIfTI-2 header is cut short", "copy the file again");
      const std::string_view magic = b.substr(4, 8);
      if (magic == std::string_view("n+2\0\r\n\032\n", 8)) return readSecond(b, swapped);
      if (magic == std::string_view("ni2\0\r\n\032\n", 8))
        throw refuse("this is the header of a pair of files (.hdr and .img)", "convert them to one .nii file");
      throw refuse("the NIfTI-2 header is damaged: its signature is not that of the format",
                   "was it sent as text? Copy it again, as binary");
    }
  }
  throw refuse("this is no NIfTI file", no_nifti);
}

}  // namespace palpate::nifti
