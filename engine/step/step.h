#pragma once

#include "model/model.h"
#include "model/state.h"

namespace palpate {

class Workspace;  // step/workspace.h: buffers and threads of one stepping thread

/// Advances the tissue by one dt, with the tools moving from where the state has them to `tools`, or less far where
/// the tissue would push harder than their max_force (ToolHold).
/// Paper sections 2.2-2.5: eqs. 12, 21-25, 31.
/// Real-time: no allocation, no lock, no throw.
StepReport step(const Model& model, State& state, const ToolPostures& tools, const Command& command,
                Workspace& workspace);

/// Advances one tick, substeps_per_tick steps, the tools going evenly from where they are to
/// command.tools, no faster than the scene allows. The report has the last
/// step's force and the worst of the rest. Where a step was lost (kBlowUp, kNotFinite), which ends the tick, the state
/// is of no use: the caller keeps that of before.
/// Real-time: as step().
StepReport tick(const Model& model, State& state, const Command& command, Workspace& workspace);

}  // namespace palpate
