#pragma once

#include <fstream>
#include <string>

#include "app/render/picture.h"
#include "io/output_file.h"
#include "realtime/channels/snapshot.h"
#include "realtime/recording/force_csv.h"

namespace palpate::app {

/// The folder that a run's results go to: force.csv, report.json, snapshot.png.
/// Each function throws std::runtime_error naming the file and the system's reason
/// when it can't be written (folder read-only, disk full).
class ResultFolder {
 public:
  /// Makes the folder where it is missing and begins force.csv beside an earlier one, so that a run that
  /// could not keep its results never starts, and one that is refused takes nothing away.
  /// @param with_forces  false: no force.csv; addForce does nothing
  explicit ResultFolder(const std::string& folder, bool with_forces = true);

  /// The run starts: force.csv takes the place of an earlier one, with these columns, and an earlier score sheet goes,
  /// which would not be of this run if that is interrupted.
  void begin(const ForceColumns& columns = {});

  /// One row of force.csv; none after one that could not be written.
  /// @param readings  of the same tick, where there are several tools or jaws
  void addForce(const ForceSample& sample, const ToolReadings& readings = {});
  /// Ends force.csv. Rows that could not be written are found here at the latest, and told once.
  void finishForces();
  bool keepsForces() const { return with_forces_ && !forces_lost_; }

  void writeReport(const std::string& json) const;
  void writePicture(const Picture& picture) const;

  std::string forceFile() const { return folder_ + "/force.csv"; }
  std::string reportFile() const { return folder_ + "/report.json"; }
  std::string soakJsonFile() const { return folder_ + "/soak.json"; }
  std::string soakTextFile() const { return folder_ + "/soak.txt"; }
  std::string pictureFile() const { return fileNamed("snapshot.png"); }
  std::string fileNamed(const std::string& name) const { return folder_ + "/" + name; }

 private:
  void checkForces();

  std::string folder_;
  bool with_forces_;
  ForceColumns columns_;
  bool forces_lost_ = false;  // for good: the system refused a row
  PendingFile pending_;       // force.csv
  std::ofstream forces_;
};

/// Throws std::runtime_error with the system's reason and `advice` unless `file` can be
/// created or overwritten. Leaves what there is as it is.
void checkWritable(const std::string& file, const std::string& advice);

}  // namespace palpate::app
