#include "mtled/verify/verify_command.h"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/parallel_for.h"
#include "io/output_file.h"
#include "mtled/report/pictures.h"
#include "mtled/report/report_page.h"
#include "mtled/run/progress.h"
#include "mtled/verify/verification_case.h"

namespace palpate::tools {
namespace {

std::vector<VerificationCase> chosenCases(const std::vector<std::string>& names) {
  std::vector<VerificationCase> chosen;
  for (const auto& name : names) {
    const auto& all = verificationCases();
    const auto found = std::find_if(all.begin(), all.end(), [&](const VerificationCase& c) { return name == c.name; });
    if (found == all.end()) {
      std::string known;
      for (const auto& c : all) known += std::string(known.empty() ? "" : ", ") + c.name;
      throw InputError({}, "there is no verification case " + inQuotes(name), "the cases are " + known);
    }
    chosen.push_back(*found);
  }
  return names.empty() ? verificationCases() : chosen;
}

CaseResult runCase(const VerificationCase& verification_case, CaseContext context) {
  ProgressLine progress(verification_case.name);
  context.progress = [&](double fraction, const std::string& what) { progress.show(fraction, what); };
  const auto start = std::chrono::steady_clock::now();
  CaseResult result;
  try {
    result = verification_case.run(context);
  } catch (const std::exception& error) {
    if (interrupted()) throw;
    // One broken case must not hide the others'.
    result.name = verification_case.name;
    result.title = verification_case.about;
    result.text = std::string("The case could not be run: ") + error.what();
    result.bounds.push_back({"The case runs", 0, 1, false, "", error.what()});
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace

int verifyCommand(const VerifyOptions& options) {
  const auto cases = chosenCases(options.cases);
  CaseContext context;
  context.quick = options.quick;
  context.threads = threadsOr(options.threads);
  context.references = sourceFolder() + "/tests/reference";
  std::unique_ptr<Pictures> pictures;
  if (!options.report.empty()) {
    checkReport(options.report);
    pictures = openPictures();
    context.pictures = pictures.get();
    context.folder = options.report;
  }

  Report report;
  report.title = "Verification of Palpate's solver";
  report.intro =
      "Our figures beside the paper's (Joldes et al., *Suite of Meshless Algorithms for Accurate Computation of Soft "
      "Tissue Deformation "
      "for Surgical Simulation*) and beside independent references. \"As the paper\" is its formulation; *node "
      "patches* average the "
      "volume over the cells around a node, against locking; *consistent gradients* satisfy the divergence theorem.";
  if (!options.report.empty() && !pictures) report.intro += "\n\nPictures: " + withoutPictures() + ".";
  report.command = "build/release/tools/mtled verify";
  for (const auto& name : options.cases) report.command += " " + name;
  if (options.quick) report.command += " --quick";
  if (!options.report.empty()) report.command += " --report " + options.report;
  report.build = buildInfo();
  const auto write = [&] {
    if (!options.json.empty()) writeWholeFile(options.json, jsonOf(report));
    if (!options.report.empty()) writeReport(options.report, report);
  };
  if (!options.json.empty()) checkWritable(options.json);
  report.missing = cases.size();
  for (const auto& c : cases) {
    if (interrupted()) throw std::runtime_error("interrupted; what was done is kept");
    report.cases.push_back(runCase(c, context));
    --report.missing;
    printCase(std::cout, report.cases.back());
    std::cout << std::endl;
    write();  // what is done stays if the rest is interrupted
  }
  printSummary(std::cout, report);
  if (!options.report.empty() && !pictures) std::cout << "\n  pictures " << withoutPictures() << "\n";
  return report.held() ? 0 : 1;
}

}  // namespace palpate::tools
