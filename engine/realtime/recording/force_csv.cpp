#include "realtime/recording/force_csv.h"

#include <cstdio>

#include "simulation/trust.h"

namespace palpate {

const char* const force_csv_header =
    "time_s,depth_m,advance_m,force_raw_N_x,force_raw_N_y,force_raw_N_z,"
    "force_filtered_N_x,force_filtered_N_y,force_filtered_N_z,trust,"
    "tool_x_m,tool_y_m,tool_z_m,tool_qx,tool_qy,tool_qz,tool_qw,torque_Nm_x,torque_Nm_y,torque_Nm_z,contacts\n";

std::string forceCsvRow(const ForceSample& s) {
  std::string row;
  const auto add = [&row](double value) {
    char text[32];
    const int length = std::snprintf(text, sizeof text, "%.9g,", value);
    row.append(text, static_cast<std::size_t>(length));
  };
  for (const double value : {s.time_s, s.depth_m, s.advance_m}) add(value);
  for (const double value : s.force_raw) add(value);
  for (const double value : s.force_filtered) add(value);
  row.append(doubtName(s.doubt)) += ',';
  for (const double value : s.tool_pose.position) add(value);
  for (const double value : s.tool_pose.orientation.coeffs()) add(value);
  for (const double value : s.torque) add(value);
  return row + std::to_string(s.contact_count) + '\n';
}

}  // namespace palpate
