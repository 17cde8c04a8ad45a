#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/render/picture.h"

namespace palpate::app {

/// Exit codes of `palpate`, in the order in which they are chosen where several apply.
namespace exit_code {
inline constexpr int done = 0, failed = 1, unusable_input = 2, doubted = 3, frozen = 4, differs = 5, interrupted = 130;
}

/// Numbers that a run's report must have: a JSON object whose keys are those of report.json, and whose values are a
/// text or a whole number (to be equal), or {"value": v, "abs": a} or {"value": v, "rel": r} with a tolerance.
class Baseline {
 public:
  /// @param blank_report  report.json's text as the run's will be, but for its values
  /// Throws InputError with the place in the file and what is wrong there, a key that the report won't have included.
  Baseline(const std::string& file, const std::string& blank_report);

  /// What differs, a line for each key; empty: nothing. @param report  report.json's text
  std::vector<std::string> differences(const std::string& report) const;

 private:
  std::string file_, text_;
};

/// Whether `picture` looks like `reference`: the mean colour difference (CIELAB) at most `tolerance`, and the share of
/// strongly different pixels (PictureDifference::strong_delta_E) at most 0.4 % for each unit of it, so that no spot
/// stands out. Empty: it does; else the sentence that says which limit it missed. Where it does and `image` is not
/// empty, a picture of the differences is written there.
std::string pictureDifference(const Picture& reference, const Picture& picture, double tolerance,
                              const std::string& image);

/// What a run was made from, beside its pictures: scene, hashes, build, OpenGL, options and files.
struct Manifest {
  std::string scene_file, scene_hash, model_hash, opengl, command;
  int width = 0, height = 0;
  std::vector<double> picture_times_s;
  std::vector<std::string> files;
};
std::string toJson(const Manifest& manifest);

}  // namespace palpate::app
