#include "api/border.h"
#include "api/handles.h"

using namespace palpate;
using namespace palpate::api;

namespace {

std::int32_t toolProblem(const palpate_simulation* simulation, std::int32_t tool) {
  if (const std::int32_t code = nullAmong({{simulation, "simulation"}})) return code;
  return outside("tool", tool, 0, simulation->model->tools.toolCount());
}

}  // namespace

extern "C" {

int32_t palpate_tool_count(const palpate_model* model, int32_t* count) {
  if (const int32_t code = nullAmong({{model, "model"}, {count, "count"}})) return code;
  *count = model->model->tools.toolCount();
  return PALPATE_OK;
}

int32_t palpate_set_tool_target(palpate_simulation* simulation, int32_t tool, const double* pose, uint64_t sequence) {
  if (const int32_t code = toolProblem(simulation, tool)) return code;
  if (const int32_t code = poseProblem(pose, "pose")) return code;
  if (tool == 0) return palpate_set_target(simulation, pose, sequence);
  HandSlot& hand = simulation->loop.toolHands().further[static_cast<std::size_t>(tool - 1)];
  hand.back() = {poseFrom(pose), sequence};
  hand.publish();
  return PALPATE_OK;
}

int32_t palpate_set_opening(palpate_simulation* simulation, int32_t tool, double opening) {
  if (const int32_t code = toolProblem(simulation, tool)) return code;
  if (!(opening >= 0 && opening <= Request::farthest))
    return refuse(PALPATE_BAD_ARGUMENT, "opening is %g, not in 0 .. %g", opening, Request::farthest);
  const auto k = static_cast<std::size_t>(tool);
  if (!simulation->model->tools.tool[k].jaws) return refuse(PALPATE_BAD_ARGUMENT, "tool %d has no jaws", tool);
  simulation->loop.toolHands().opening[k].store(opening, std::memory_order_relaxed);
  return PALPATE_OK;
}

int32_t palpate_read_tool(const palpate_simulation* simulation, int32_t tool, palpate_tool_state* state) {
  if (const int32_t code = toolProblem(simulation, tool)) return code;
  palpate_tool_state out{};
  const ToolReadings readings = simulation->loop.toolReadings();
  const ToolReading& t = readings.tool[static_cast<std::size_t>(tool)];
  out.contact_count = static_cast<std::int32_t>(t.contact_count);
  out.tick = readings.tick;
  std::copy(t.pose.begin(), t.pose.end(), out.pose);
  out.opening = t.opening;
  std::copy(t.force.begin(), t.force.end(), out.force);
  std::copy(t.torque.begin(), t.torque.end(), out.torque);
  out.pinch = t.pinch;
  out.expected_error = t.expected_error;
  return fill(state, out);
}

}  // extern "C"
