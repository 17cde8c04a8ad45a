// mtled: solves scenes in batch, verifies the solver against the paper and independent references, and times its
// kernels.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/nearest_word.h"
#include "base/printable_text.h"
#include "io/output_file.h"
#include "mtled/atlas/atlas_command.h"
#include "mtled/bench/bench_command.h"
#include "mtled/fit/fit_command.h"
#include "mtled/frontier/frontier_command.h"
#include "mtled/solve/solve_command.h"
#include "mtled/verify/verification_case.h"
#include "mtled/verify/verify_command.h"

namespace {

constexpr int failed = 1, unusable_input = 2;

const char* const examples = R"(Examples:
  mtled solve assets/scenes/box_extension.toml --out /tmp/box    the equilibria on the way, for ParaView too
  mtled solve liver --tool indent_hold_retract               the tool's way, quasi-static
  mtled verify                               all cases beside the paper and independent references
  mtled verify cube torsion --report /tmp/v  two of them, as a page with pictures
  mtled bench --quick                        the force kernels' speed beside what this machine could do at most
  mtled frontier liver --quick               what each microsecond buys
  mtled fit liver --rate 1000                the most accurate setting that holds 1 kHz here
  mtled atlas --quick                        where the numbers are true, doubted or refused

Exit codes: 0 done, 1 failed, not converged or interrupted (what there is is kept), 2 bad option or scene.)";

/// The lines of the examples that show one command.
std::string examplesOf(const CLI::App& command) {
  std::istringstream all(examples);
  std::string shown = "Examples:";
  for (std::string line; std::getline(all, line);)
    if (line.starts_with("  mtled " + command.get_name() + " ")) shown += "\n" + line;
  return shown;
}

/// What to say of a first word that is no command; empty where it is one, or an option.
std::string wrongCommand(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return {};
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  const std::string word = argv[1];
  if (std::find(names.begin(), names.end(), word) != names.end()) return {};
  const std::string meant = palpate::nearestWord(word, names);
  return "\"" + palpate::printable(word) + "\" is not a command" +
         (meant.empty() ? "" : "; did you mean \"" + meant + "\"?") +
         (meant.empty() ? "; there are " + palpate::listed(names, "and") : "");
}

}  // namespace

int main(int argc, char** argv) {
  using namespace palpate;
  using namespace palpate::tools;
  CLI::App app{"mtled: meshless total-Lagrangian explicit dynamics in batch."};
  app.footer(examples);
  app.set_version_flag("--version", buildInfo());
  app.require_subcommand(1);

  SolveOptions solve;
  CLI::App* solve_app = app.add_subcommand("solve", "Solve a scene as its [solve] table says");
  solve_app->footer(examplesOf(*solve_app));
  solve_app->add_option("SCENE", solve.scene, "Scene file (.toml), or the name of one in assets/scenes")->required();
  solve_app->add_option("--out", solve.out, "Folder for the results (out/<scene>)")->type_name("DIR");
  solve_app
      ->add_option("--tool", solve.tool_script,
                   "Move the tool as a script says: a file, or the name of one in assets/tools")
      ->type_name("SCRIPT");
  solve_app->add_option("--threads", solve.threads, "Threads (one per core)")->type_name("N")->check(CLI::Range(1, 64));
  solve_app->add_flag("--resume", solve.resume, "Go on from the folder's checkpoint.bin");

  bool no_cache = false;
  solve_app->add_flag("--no-cache", no_cache, "Make the set-up anew and do not keep it");

  VerifyOptions verify;
  std::string names = "Cases:";
  for (const auto& c : verificationCases()) names += std::string("\n  ") + c.name + ": " + c.about;
  CLI::App* verify_app = app.add_subcommand("verify", "Compare the solver with the paper and independent references");
  verify_app->footer(names + "\n\n" + examplesOf(*verify_app));
  verify_app->add_option("CASE", verify.cases, "Cases (all)");
  verify_app->add_flag("--quick", verify.quick, "The coarse rows only");
  verify_app->add_option("--json", verify.json, "Write the results to this file")->type_name("FILE");
  verify_app->add_option("--report", verify.report, "Write a page with tables and pictures into this folder")
      ->type_name("DIR");
  verify_app->add_option("--threads", verify.threads, "Threads (one per core)")
      ->type_name("N")
      ->check(CLI::Range(1, 64));

  BenchOptions bench;
  CLI::App* bench_app = app.add_subcommand("bench", "Time the force kernels beside this machine's ceilings");
  bench_app->footer(examplesOf(*bench_app));
  bench_app->add_flag("--features", bench.features,
                      "Instead: what each feature that a scene may use costs, on and off");
  bench_app->add_flag("--quick", bench.quick, "Bodies of 1,000 and 5,000 nodes only, under half a minute");
  bench_app->add_option("--json", bench.json, "Write the results to this file")->type_name("FILE");
  bench_app->add_option("--plot", bench.plot, "Draw the roofline of one core into this PNG")->type_name("FILE");
  bench_app->add_option("--seconds", bench.seconds, "Time spent on each figure (0.5; 0.15 with --quick)")
      ->type_name("S")
      ->check(CLI::Range(0.001, 60.0));
  bench_app->add_flag("--check", bench.check, "Fail where a promise is missed: for a machine that is otherwise idle");

  FrontierOptions frontier;
  CLI::App* frontier_app =
      app.add_subcommand("frontier", "Measure what each setting of a scene costs and how exact it is");
  frontier_app->footer(examplesOf(*frontier_app));
  frontier_app->add_option("SCENE", frontier.scene, "Scene file (.toml), or the name of one in assets/scenes")
      ->required();
  frontier_app->add_option("--out", frontier.out, "Folder for the results (out/<scene>_frontier)")->type_name("DIR");
  frontier_app
      ->add_option("--tool", frontier.tool_script,
                   "The tool's way: a script, or the name of one in assets/tools (the built-in indentation)")
      ->type_name("SCRIPT");
  frontier_app->add_option("--report", frontier.report, "Write a page with tables and the picture into this folder")
      ->type_name("DIR");
  frontier_app->add_flag("--quick", frontier.quick, "The most telling settings, and a coarser reference");
  frontier_app->add_flag("--resume", frontier.resume, "Keep the settings that the folder has already");

  FitOptions fit;
  CLI::App* fit_app =
      app.add_subcommand("fit", "Find the most accurate setting of a scene that holds a rate on this machine");
  fit_app->footer(examplesOf(*fit_app));
  fit_app->add_option("SCENE", fit.scene, "Scene file (.toml), or the name of one in assets/scenes")->required();
  fit_app->add_option("--rate", fit.rate_hz, "Ticks a second (the scene's)")
      ->type_name("HZ")
      ->check(CLI::Range(100.0, 2000.0));
  fit_app->add_option("--cores", fit.cores, "Threads for the physics (one per core)")
      ->type_name("N")
      ->check(CLI::Range(1, 64));
  fit_app->add_option("--out", fit.out, "Scene file to write (out/<scene>_<rate>hz.toml)")->type_name("FILE");
  fit_app->add_option("--json", fit.json, "Write what was found to this file")->type_name("FILE");
  fit_app
      ->add_option("--tool", fit.tool_script,
                   "The tool's way: a script, or the name of one in assets/tools (the built-in indentation)")
      ->type_name("SCRIPT");
  fit_app->add_flag("--uniform", fit.uniform, "The same spacing everywhere, for a tool that goes anywhere");
  fit_app->add_flag("--resume", fit.resume, "Keep what was tried already: FILE.fit.json beside the scene to write");

  AtlasOptions atlas;
  std::string axes = "Axes (AXIS/VALUE for one cell):";
  for (const auto& axis : atlasAxes()) axes += "\n  " + axis.key + ": " + axis.title;
  CLI::App* atlas_app = app.add_subcommand(
      "atlas", "Map where the numbers are true: each cell stable, degraded or refused, none silently wrong");
  atlas_app->footer(axes + "\n\n" + examplesOf(*atlas_app));
  atlas_app->add_option("CELL", atlas.cells, "Cells or whole axes (all)");
  atlas_app->add_flag("--quick", atlas.quick, "A third of the cells, under a minute");
  atlas_app->add_option("--out", atlas.out, "Folder for atlas.json, atlas.csv and atlas.png (out/atlas)")
      ->type_name("DIR");
  atlas_app->add_option("--json", atlas.json, "Write the results to this file, too")->type_name("FILE");
  atlas_app->add_option("--report", atlas.report, "Write a page with the map into this folder")->type_name("DIR");
  atlas_app->add_flag("--resume", atlas.resume, "Keep the cells that the folder has already");

  const auto runCommand = [&] {
    if (*bench_app) return benchCommand(bench);
    if (*fit_app) return fitCommand(fit);
    if (*atlas_app) return atlasCommand(atlas);
    if (*frontier_app) return frontierCommand(frontier);
    return *verify_app ? verifyCommand(verify) : solveCommand(solve);
  };
  if (const std::string wrong = wrongCommand(app, argc, argv); !wrong.empty()) {
    std::cerr << "mtled: " << wrong << std::endl;
    return unusable_input;
  }
  catchInterrupts();
  try {
    int code = 0;
    try {
      app.parse(argc, argv);
      solve.use_cache = !no_cache;
      code = runCommand();
    } catch (const CLI::ParseError& error) {  // help and version, too
      code = app.exit(error) == 0 ? 0 : unusable_input;
    }
    finishStandardOutput();
    return code;
  } catch (const InputError& error) {
    std::cerr << "mtled: " << printable(error.what(), LineEnds::Keep) << std::endl;
    return unusable_input;
  } catch (const std::exception& error) {
    std::cerr << "mtled: " << printable(error.what(), LineEnds::Keep) << std::endl;
    return failed;
  }
}
