#pragma once

#include <string>
#include <vector>

#include "realtime/channels/snapshot.h"
#include "realtime/channels/tool_readings.h"

namespace palpate {

/// force.csv: a row for each tick, the force on the tool and what belongs to it. Read it by the columns' names.
extern const char* const force_csv_header;

/// A row with its line end. Numbers have nine digits, which tell neighbouring floats apart; the clock's times have at
/// most 1e-4 s of detail.
std::string forceCsvRow(const ForceSample& sample);

/// What a scene's rows have beyond these.
struct ForceColumns {
  ForceColumns() = default;  // none
  explicit ForceColumns(const Model& model, bool follows = false);

  ToolSet tools;
  std::vector<std::string> rigid;  // names of rigid bodies
  bool follows = false;            // the cloud follows the tool
};

/// Header and rows with them. Where there are several tools or jaws, each column is behind its tool's number
/// (tool1_opening_m, tool2_force_N_x): opening and pinch force of jaws; pose, force and torque of the tools beside the
/// first. Then the force of each rigid body on the tissue (floor_force_N_x). Where the cloud follows, at last the nodes
/// of its place, and 1 where that was late.
std::string forceCsvHeader(const ForceColumns& columns);
std::string forceCsvRow(const ForceSample& sample, const ToolReadings& readings, const ForceColumns& columns);

}  // namespace palpate
