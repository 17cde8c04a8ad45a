#include "mtled/bench/device_bench.h"

#include <cmath>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "base/build_info.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "io/output_file.h"
#include "mtled/run/progress.h"
#include "scene/device_settings.h"

namespace palpate::tools {
namespace {

const char* className(const DeviceTrial& trial) {
  return DeviceSettings::classes[static_cast<std::size_t>(trial.device_class)];
}
const char* handName(const DeviceTrial& trial) { return trial.firm ? "firm" : "light"; }
const char* motionName(const DeviceTrial& trial) {
  return trial.motion == HandMotion::Kind::Press ? "press" : "random";
}

std::vector<DeviceTrial> trials(bool quick) {
  std::vector<DeviceTrial> all;
  for (int device = 0; device < 3; ++device)
    for (const bool firm : {false, true})
      for (const double delay : {0.0, 0.002, 0.005})
        for (const auto motion : {HandMotion::Kind::Press, HandMotion::Kind::Random}) {
          if (quick && (firm == (device == 0) || delay == 0.002 || motion == HandMotion::Kind::Random)) continue;
          all.push_back({device, firm, delay, motion, motion == HandMotion::Kind::Press ? 6.6 : 4.5,
                         static_cast<std::uint64_t>(all.size() + 1)});
        }
  return all;
}

std::string jsonOf(const std::vector<DeviceRow>& rows) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const DeviceRow& row : rows) {
    const DeviceResult& r = row.result;
    all.push_back({{"body", row.body},
                   {"device", className(row.trial)},
                   {"hand", handName(row.trial)},
                   {"delay_s", row.trial.delay_s},
                   {"motion", motionName(row.trial)},
                   {"peak_force_N", r.peak_force},
                   {"limit_cycle", r.limit_cycle},
                   {"limit_cycle_Hz", r.limit_cycle_hz},
                   {"lowest_energy_J", r.lowest_energy_J},
                   {"damped_J", r.damped_J},
                   {"given_J", r.given_J},
                   {"static_error", r.static_error},
                   {"static_force_N", r.static_force},
                   {"tissue_stiffness_N_per_m", r.tissue_stiffness},
                   {"coupling_stiffness_N_per_m", r.coupling_stiffness},
                   {"felt_stiffness_N_per_m", r.felt_stiffness},
                   {"drag_Ns_per_m", r.drag},
                   {"silence_ms", r.silence_ms},
                   {"blow", r.blow},
                   {"latency_ticks", r.latency_ticks},
                   {"missed", missedBounds(r)}});
  }
  return nlohmann::ordered_json{{"build", buildInfo()}, {"rows", all}}.dump(2) + "\n";
}

}  // namespace

std::string missedBounds(const DeviceResult& r) {
  std::string missed;
  const auto add = [&](bool held, const char* what) {
    if (!held) missed += (missed.empty() ? "" : ", ") + std::string(what);
  };
  add(r.limit_cycle < DeviceBounds::limit_cycle, "limit cycle");
  add(r.lowest_energy_J >= DeviceBounds::energy_J, "energy");
  add(r.static_error < DeviceBounds::static_error, "static force");
  add(r.silence_ms <= DeviceBounds::silence_ms, "silence");
  add(r.latency_ticks <= DeviceBounds::latency_ticks, "latency");
  add(!r.frozen, "tissue lost");
  add(r.peak_force > 0, "no force");
  return missed;
}

void printDeviceRows(std::ostream& out, const std::vector<DeviceRow>& rows) {
  out << "                                                 above 20 Hz  observed   static       stiffness, N/m      "
         "drag"
         "  silence\n"
         "  body      device hand  delay motion   peak N   share    Hz        mJ    error  tissue    Kc   felt   N s/m"
         "       ms  blow  ticks  missed\n";
  for (const DeviceRow& row : rows) {
    const DeviceResult& r = row.result;
    out << format("  %-9s %-6s %-5s %3.0f ms %-7s %6.3f %6.3f %% %5.0f %9.4f", row.body.c_str(), className(row.trial),
                  handName(row.trial), 1e3 * row.trial.delay_s, motionName(row.trial), r.peak_force,
                  100 * r.limit_cycle, r.limit_cycle_hz, 1e3 * r.lowest_energy_J);
    if (r.static_error >= 0)
      out << format("  %5.2f %%  %6.0f %5.0f  %5.0f", 100 * r.static_error, r.tissue_stiffness, r.coupling_stiffness,
                    r.felt_stiffness);
    else
      out << format("        -       - %5.0f      -", r.coupling_stiffness);
    out << format("  %6.2f", r.drag)
        << (r.silence_ms >= 0 ? format("  %7.0f  %4.2f", r.silence_ms, r.blow) : std::string("        -     -"))
        << format("  %5.2f  ", r.latency_ticks) << missedBounds(r) << "\n";
  }
}

int deviceBench(const DeviceBenchOptions& options) {
  if (!options.json.empty()) writeWholeFile(options.json, "");
  std::vector<DeviceRow> rows;
  const std::vector<DeviceTrial> all = trials(options.quick);
  bool whole = true;
  {
    ProgressLine progress("devices");
    const std::vector<std::string> bodies{"liver", "gel", "inclusion"};
    for (std::size_t b = 0; b < bodies.size() && whole; ++b) {
      Model model = deviceBody(bodies[b]);
      for (std::size_t t = 0; t < all.size() && whole; ++t) {
        progress.show(static_cast<double>(b * all.size() + t) / static_cast<double>(bodies.size() * all.size()),
                      bodies[b]);
        model.scene.device = DeviceSettings::of(all[t].device_class);
        rows.push_back({bodies[b], all[t], runDeviceTrial(model, all[t])});
        whole = !interrupted();
      }
    }
  }
  std::cout
      << "Simulated devices in simulated hands, in simulated time; no device was connected.\n"
         "Kc is what the delay leaves of the coupling's stiffness; the hand feels it in series with the tissue, and a\n"
         "drag, as the tool follows with the loop's delay.\n\n";
  printDeviceRows(std::cout, rows);
  std::size_t missed = 0;
  for (const DeviceRow& row : rows) missed += missedBounds(row.result).empty() ? 0 : 1;
  std::cout << "\n  " << rows.size() - missed << " of " << rows.size()
            << " hold: no line above 20 Hz of 1 % of the peak "
            << "force, observed energy >= -1 mJ, force at rest within 2 %,\n  none 60 ms after the last pose, answer "
            << "within 2 ticks" << std::endl;
  if (!options.json.empty()) writeWholeFile(options.json, jsonOf(rows));
  return !whole || (options.check && missed > 0) ? 1 : 0;
}

}  // namespace palpate::tools
