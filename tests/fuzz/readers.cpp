#include <algorithm>
#include <array>
#include <cstring>

#include "base/input_error.h"
#include "fuzz/reader.h"

namespace palpate::fuzz {

std::span<const Reader> readers() {
  static const std::array all{scene_reader,      tool_script_reader, csv_reader,  recording_reader, obj_reader,
                              stl_reader,        ply_reader,         off_reader,  vtk_reader,       repair_reader,
                              checkpoint_reader, preparation_reader, nifti_reader};
  return all;
}

const Reader& readerOf(const std::string& name) {
  std::string known;
  for (const Reader& reader : readers()) {
    if (reader.name == name) return reader;
    known += std::string(" ") + reader.name;
  }
  throw std::invalid_argument("no reader is named " + name + "; there are" + known);
}

bool takes(const Reader& reader, const std::string& bytes) {
  try {
    reader.read(bytes);
    return true;
  } catch (const InputError& error) {
    hold(std::strlen(error.what()) != 0, "a refusal that says nothing");
    return false;
  }
}

}  // namespace palpate::fuzz
