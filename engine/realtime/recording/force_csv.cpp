#include "realtime/recording/force_csv.h"

#include "base/number_text.h"
#include "model/model.h"
#include "step/trust.h"

namespace palpate {

const char* const force_csv_header =
    "time_s,depth_m,advance_m,force_raw_N_x,force_raw_N_y,force_raw_N_z,"
    "force_filtered_N_x,force_filtered_N_y,force_filtered_N_z,trust,"
    "tool_x_m,tool_y_m,tool_z_m,tool_qx,tool_qy,tool_qz,tool_qw,torque_Nm_x,torque_Nm_y,torque_Nm_z,contacts,"
    "expected_error\n";

namespace {

/// Without a sign at zero, which recordings don't keep.
std::string number(double value) { return format("%.9g", value == 0 ? 0 : value); }

}  // namespace

std::string forceCsvRow(const ForceSample& s) {
  std::string row;
  const auto add = [&row](double value) { row += number(value) + ','; };
  for (const double value : {s.time_s, s.depth_m, s.advance_m}) add(value);
  for (const double value : s.force_raw) add(value);
  for (const double value : s.force_filtered) add(value);
  row.append(doubtName(s.doubt)) += ',';
  for (const double value : s.tool_pose.position) add(value);
  for (const double value : s.tool_pose.orientation.coeffs()) add(value);
  for (const double value : s.torque) add(value);
  return row + std::to_string(s.contact_count) + format(",%.3g\n", s.expected_error);
}

ForceColumns::ForceColumns(const Model& model, bool cloud_follows) : tools(model.tools), follows(cloud_follows) {
  for (const RigidBody& body : model.rigid.body) rigid.push_back(body.name);
}

std::string forceCsvHeader(const ForceColumns& columns) {
  std::string header(force_csv_header);
  header.pop_back();
  const ToolSet& tools = columns.tools;
  for (std::size_t k = 0; k < tools.tool.size(); ++k) {
    const std::string name = ",tool" + std::to_string(k + 1) + "_";
    if (k > 0)
      for (const char* column : {"x_m", "y_m", "z_m", "qx", "qy", "qz", "qw", "force_N_x", "force_N_y", "force_N_z",
                                 "torque_Nm_x", "torque_Nm_y", "torque_Nm_z", "contacts"})
        header.append(name).append(column);
    if (tools.tool[k].jaws) header.append(name).append("opening_m").append(name).append("pinch_N");
  }
  for (const std::string& name : columns.rigid)
    for (const char* column : {"_force_N_x", "_force_N_y", "_force_N_z"})
      header.append(",").append(name).append(column);
  return header + (columns.follows ? ",nodes,place_late\n" : "\n");
}

std::string forceCsvRow(const ForceSample& sample, const ToolReadings& readings, const ForceColumns& columns) {
  const ToolSet& tools = columns.tools;
  std::string row = forceCsvRow(sample);
  row.pop_back();
  const auto add = [&row](double value) { row += ',' + number(value); };
  for (std::size_t k = 0; k < tools.tool.size(); ++k) {
    const ToolReading& t = readings.tool[k];
    if (k > 0) {
      for (const double value : t.pose) add(value);
      for (const double value : t.force) add(value);
      for (const double value : t.torque) add(value);
      row += ',' + std::to_string(t.contact_count);
    }
    if (tools.tool[k].jaws) add(t.opening), add(t.pinch);
  }
  for (std::size_t b = 0; b < columns.rigid.size(); ++b)
    for (const float value : sample.rigid_force[b]) add(static_cast<double>(value));
  if (columns.follows) row += ',' + std::to_string(sample.node_count) + (sample.place_late ? ",1" : ",0");
  return row + '\n';
}

}  // namespace palpate
