#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace palpate::fuzz {

/// What a reader took is not sound.
struct Fault : std::logic_error {
  using std::logic_error::logic_error;
};

/// A reader of input files, and what must hold whatever bytes it gets: it takes them, and what it makes of them is
/// sound, or it throws an InputError.
struct Reader {
  const char* name;
  std::vector<std::string> (*seeds)();  // inputs that it takes

  /// Throws InputError where the reader refuses, Fault where what it took is unsound; anything else that it throws is
  /// the reader's fault, as is a crash.
  void (*read)(const std::string& bytes);
};

std::span<const Reader> readers();

/// Throws std::invalid_argument, listing the names, where there is none.
const Reader& readerOf(const std::string& name);

/// Whether the reader takes the bytes. Throws where it does not do as it must.
bool takes(const Reader& reader, const std::string& bytes);

inline void hold(bool sound, const char* what) {
  if (!sound) throw Fault(what);
}

// One of these each for `readers`.
extern const Reader scene_reader, tool_script_reader, csv_reader, recording_reader, obj_reader, stl_reader,
    ply_reader, off_reader, vtk_reader, repair_reader, checkpoint_reader, preparation_reader, nifti_reader;

}  // namespace palpate::fuzz
