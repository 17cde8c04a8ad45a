#include "mtled/bench/bench_command.h"

#include <algorithm>
#include <iostream>
#include <memory>

#include "base/build_info.h"
#include "base/input_error.h"
#include "io/output_file.h"
#include "mtled/bench/bench_run.h"
#include "mtled/bench/device_bench.h"
#include "mtled/bench/roofline.h"
#include "mtled/report/pictures.h"

namespace palpate::tools {
int benchCommand(const BenchOptions& options) {
  if (!(options.seconds >= 0 && options.seconds <= 60))
    throw InputError({}, "--seconds must be between 0 and 60", "leave it out for the usual length");
  if (options.device) {
    if (!options.plot.empty() || options.seconds > 0)
      throw InputError({}, "--device has neither a roofline nor times", "leave the other options out");
    return deviceBench({options.quick, options.json, options.check});
  }
  const double seconds = options.seconds > 0 ? options.seconds : options.quick ? 0.15 : 0.5;

  BenchReport report;
  report.build = buildInfo();
  report.command = "build/release/tools/mtled bench";
  if (options.quick) report.command += " --quick";
  if (options.seconds > 0) report.command += " --seconds " + formatted(options.seconds);
  report.machine = thisMachine();
  const auto write = [&] {
    if (!options.json.empty()) writeWholeFile(options.json, jsonOf(report));
  };
  std::unique_ptr<Pictures> pictures;
  if (!options.plot.empty()) {
    pictures = openPictures();
    if (pictures) writeWholeFile(options.plot, "");
  }
  write();  // a place that can't be written to is found before the work, not after
  // All shares hang on these few figures.
  constexpr double min_seconds = 0.5;
  report.ceilings =
      measureCeilings(report.machine, benchThreadCounts(report.machine.cores), std::max(min_seconds, seconds));
  printMachine(std::cout, report);
  for (const BenchSize& size : benchSizes(options.quick)) {
    report.bodies.push_back(benchBody(size, report.ceilings, seconds, report.bodies.empty()));
    printBody(std::cout, report.bodies.back());
    std::cout << std::flush;
    write();  // what is done stays if the rest is interrupted
  }
  printVerdicts(std::cout, report);
  if (pictures) pictures->write(options.plot, rooflineOf(report));
  if (!options.plot.empty() && !pictures) std::cout << "\n  roofline " << withoutPictures() << "\n";
  if (!report.right()) std::cout << "\n  A kernel's forces are wrong: its times mean nothing.\n";
  return benchExitCode(report, options.check);
}

int benchExitCode(const BenchReport& report, bool check) {
  const auto verdicts = verdictsOf(report);
  const bool missed =
      std::any_of(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.text() == "missed"; });
  return !report.right() || (check && missed) ? 1 : 0;
}

}  // namespace palpate::tools
