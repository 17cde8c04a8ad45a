#pragma once

#include <string>
#include <vector>

#include "io/gltf_file.h"
#include "io/vtu_file.h"
#include "model/model.h"
#include "realtime/channels/snapshot.h"

namespace palpate::app {

inline constexpr double export_rate = 20;  // moments a second
inline constexpr double most_exported_seconds = 60;

/// What is wrong with a file to export to; empty: nothing.
std::string exportProblem(const std::string& path);

/// Whether it keeps the body's inside, too, which a search hides.
bool exportsInside(const std::string& path);

/// A run over time for other programs: *.gltf or *.glb with skin and tools as an animation, or *.pvd, ParaView's
/// series, whose moments (VTU: the body with displacement, stress, J) lie in a folder of the same name.
class RunExport {
 public:
  /// Throws std::runtime_error with file and reason where nothing can be written there.
  RunExport(std::string path, const Model& model);

  /// Takes a moment. Those of no new time are left out.
  void add(const Snapshot& snapshot);

  /// Writes what was taken, once there is some. Throws std::runtime_error with file and reason.
  void write() const;

 private:
  void addPoses(const Snapshot* snapshot);

  std::string path_;
  const Model& model_;
  GltfRun run_;
  std::vector<PvdFrame> series_;
};

}  // namespace palpate::app
