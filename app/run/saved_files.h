#pragma once

#include <deque>
#include <string>
#include <vector>

#include "app/panels/press_curves.h"
#include "app/render/picture.h"
#include "app/trainer/task_score.h"
#include "model/model.h"
#include "realtime/channels/snapshot.h"
#include "realtime/recording/recording.h"

namespace palpate::app {

/// What the File menu saves: in out/<scene>, under the first name that is free, so that nothing is overwritten.
/// Each function returns the file and throws std::runtime_error with file and reason where it can't be written.
class SavedFiles {
 public:
  /// @param scene  as it was named: a file, or the name of one in assets/scenes
  explicit SavedFiles(const std::string& scene);

  std::string picture(const Picture& picture) const;
  std::string forces(const std::deque<ForceSample>& samples) const;
  std::string presses(const PressCurves& presses) const;
  /// As writeScore.
  std::string score(const TaskScore& score, const SheetHead& head, const Picture& page) const;
  std::string recording(const Recording& recording) const;
  std::string state(const Model& model, const Snapshot& snapshot) const;

 private:
  std::string free(const std::string& name, const std::string& ending) const;

  std::string folder_;
};

/// The names of a score's files in their folder: the sheet as JSON, and, with the same stem, the map of pressures as
/// CSV and a page to print as PNG.
std::vector<std::string> scoreFiles(const std::string& json_file);

/// Writes them, and returns their names. Throws std::runtime_error with file and reason where they can't be written.
std::vector<std::string> writeScore(const std::string& json_file, const TaskScore& score, const SheetHead& head,
                                    const Picture& page);

/// Takes the three away, if there is such a sheet.
void removeScore(const std::string& json_file);

/// The deformed body for ParaView: displacement at the nodes; in the cells J and, of the materials in force, pressure
/// and von Mises stress, but that of tissue that relaxes: a snapshot does not know what has.
void writeStateVtu(const std::string& path, const Model& model, const Snapshot& snapshot);

}  // namespace palpate::app
