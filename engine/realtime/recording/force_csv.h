#pragma once

#include <string>

#include "realtime/channels/snapshot.h"
#include "realtime/channels/tool_readings.h"

namespace palpate {

/// force.csv: a row for each tick, the force on the tool and what belongs to it. Read it by the columns' names.
extern const char* const force_csv_header;

/// A row with its line end. Numbers have nine digits, which tell neighbouring floats apart; the clock's times have at
/// most 1e-4 s of detail.
std::string forceCsvRow(const ForceSample& sample);

/// Header and rows with the columns that a scene with several tools or jaws has beyond these, each behind its tool's
/// number (tool1_opening_m, tool2_force_N_x): opening and pinch force of jaws; pose, force and torque of the tools
/// beside the first. Others: the same as above.
/// @param follows  the cloud follows the tool: at last the nodes of its place, and 1 where that was late
std::string forceCsvHeader(const ToolSet& tools, bool follows = false);
std::string forceCsvRow(const ForceSample& sample, const ToolReadings& readings, const ToolSet& tools,
                        bool follows = false);

}  // namespace palpate
