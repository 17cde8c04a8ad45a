// mtled: solves scenes in batch, verifies the solver against the paper and independent references, and times its
// kernels.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <functional>
#include <iostream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/nearest_word.h"
#include "base/printable_text.h"
#include "io/output_file.h"
#include "mtled/atlas/atlas_command.h"
#include "mtled/batch/batch_command.h"
#include "mtled/bench/bench_command.h"
#include "mtled/certify/certify_command.h"
#include "mtled/fit/fit_command.h"
#include "mtled/follow/follow_command.h"
#include "mtled/frontier/frontier_command.h"
#include "mtled/identify/identify_command.h"
#include "mtled/import/import_command.h"
#include "mtled/matrix/matrix_command.h"
#include "mtled/scan/brainshift_command.h"
#include "mtled/scan/import_scan.h"
#include "mtled/scan/phantom_command.h"
#include "mtled/scan/warp_command.h"
#include "mtled/solve/solve_command.h"
#include "mtled/verify/verification_case.h"
#include "mtled/verify/verify_command.h"

using namespace palpate;
using namespace palpate::tools;

namespace {

constexpr int failed = 1, unusable_input = 2;

const char* const examples = R"(Examples:
  mtled solve assets/scenes/box_extension.toml --out /tmp/box    the equilibria on the way, for ParaView too
  mtled solve liver --tool indent_hold_retract               the tool's way, quasi-static
  mtled verify                               all cases beside the paper and independent references
  mtled verify cube torsion --report /tmp/v  two of them, as a page with pictures
  mtled verify matrix --first 1000 --count 50   scenes drawn by lot beside closed forms and finer clouds
  mtled bench --quick                        the force kernels' speed beside what this machine could do at most
  mtled frontier liver --quick               what each microsecond buys
  mtled follow liver --quick                 a cloud that follows the tool, beside the scene as it is
  mtled fit liver --rate 1000                the most accurate setting that holds 1 kHz here
  mtled certify liver                        how exact a scene's force is, over depth; palpate then shows it
  mtled batch jobs.jsonl --jobs 8            many scenes, one thread each
  mtled identify kidney --measured force.csv    the material that gives a measured force curve
  mtled identify map.toml --regions --measured presses.csv   a map of stiffness from presses at many places
  mtled phantom --out out/phantom            a brain scan by formula, its mask and electrodes
  mtled import out/phantom/scan.nii.gz --mask out/phantom/mask.nii.gz --out out/case   from a scan to a scene
  mtled brainshift out/phantom/scan.nii.gz --mask out/phantom/mask.nii.gz --electrodes out/phantom/electrodes.csv \
      --frame ras --out out/shift            the scan as it is with the electrodes in place
  mtled warp out/shift --image out/phantom/scan.nii.gz   another image of a solved case
  mtled atlas --quick                        where the numbers are true, doubted or refused
  mtled import liver.stl --unit mm --out my/liver   a scene of any surface, repaired where it must be

Exit codes: 0 done, 1 failed, not converged or interrupted (what there is is kept), 2 bad option, file or scene,
3 found but doubted (identify, verify matrix, --strict).)";

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
  const std::string meant = nearestWord(word, names);
  return "\"" + printable(word) + "\" is not a command" + (meant.empty() ? "" : "; did you mean \"" + meant + "\"?") +
         (meant.empty() ? "; there are " + listed(names, "and") : "");
}

// Each adds one command whose options go to `options`.

CLI::App* addSolve(CLI::App& app, SolveOptions& options) {
  CLI::App* command = app.add_subcommand("solve", "Solve a scene as its [solve] table says");
  command->footer(examplesOf(*command));
  command->add_option("SCENE", options.scene, "Scene file (.toml), or the name of one in assets/scenes")->required();
  command->add_option("--out", options.out, "Folder for the results (out/<scene>)")->type_name("DIR");
  command
      ->add_option("--tool", options.tool_script,
                   "Move the first tool as a script says: a file, or the name of one in assets/tools (the scene's own)")
      ->type_name("SCRIPT");
  command->add_option("--threads", options.threads, "Threads (one per core)")->type_name("N")->check(CLI::Range(1, 64));
  command->add_flag("--resume", options.resume, "Go on from the folder's checkpoint.bin");
  command->add_flag("--strict", options.strict, "Exit code 3 where the result is doubted (column trust of force.csv)");
  options.use_cache = true;
  command->add_flag_callback(
      "--no-cache", [&options] { options.use_cache = false; }, "Make the set-up anew and do not keep it");
  return command;
}

CLI::App* addVerify(CLI::App& app, VerifyOptions& options) {
  std::string names = "Cases:";
  for (const auto& c : verificationCases()) names += std::string("\n  ") + c.name + ": " + c.about;
  CLI::App* command = app.add_subcommand("verify", "Compare the solver with the paper and independent references");
  command->footer(names + "\n\n" + examplesOf(*command));
  command->add_option("CASE", options.cases, "Cases (all)");
  command->add_flag("--quick", options.quick, "The coarse rows only");
  command->add_option("--json", options.json, "Write the results to this file")->type_name("FILE");
  command->add_option("--report", options.report, "Write a page with tables and pictures into this folder")
      ->type_name("DIR");
  command->add_option("--threads", options.threads, "Threads (one per core)")->type_name("N")->check(CLI::Range(1, 64));
  return command;
}

/// `mtled verify matrix`.
CLI::App* addMatrix(CLI::App& verify, MatrixOptions& options) {
  CLI::App* command =
      verify.add_subcommand("matrix", "Scenes drawn by lot beside closed forms and finer clouds: what is trusted?");
  command->footer("Exit code 3 where a trusted force is off by more than a tenth.\n\n" + examplesOf(verify));
  command->add_option("--first", options.first, "The first seed (1)")->type_name("N")->check(CLI::Range(0, 1000000));
  command->add_option("--count", options.count, "How many (300)")->type_name("N")->check(CLI::Range(1, 100000));
  command->add_flag("--quick", options.quick, "Only those with a closed form");
  command->add_flag("--make", options.make,
                    "Only compute the references that tests/reference/matrix.csv lacks, and keep them there");
  command->add_option("--json", options.json, "Write the results and all rows to this file")->type_name("FILE");
  command->add_option("--report", options.report, "Write a page with tables and the cloud of errors into this folder")
      ->type_name("DIR");
  command->add_option("--threads", options.threads, "Threads (one per core)")->type_name("N")->check(CLI::Range(1, 64));
  return command;
}

CLI::App* addBench(CLI::App& app, BenchOptions& options) {
  CLI::App* command = app.add_subcommand("bench", "Time the force kernels beside this machine's ceilings");
  command->footer(examplesOf(*command));
  command->add_flag("--device", options.device,
                    "Instead: simulated haptic devices in simulated hands over liver, gel and a hard inclusion");
  command->add_flag("--quick", options.quick, "Bodies of 1,000 and 5,000 nodes only, under half a minute");
  command->add_option("--json", options.json, "Write the results to this file")->type_name("FILE");
  command->add_option("--plot", options.plot, "Draw the roofline of one core into this PNG")->type_name("FILE");
  command->add_option("--seconds", options.seconds, "Time spent on each figure (0.5; 0.15 with --quick)")
      ->type_name("S")
      ->check(CLI::Range(0.001, 60.0));
  command->add_flag("--check", options.check, "Fail where a promise is missed: for a machine that is otherwise idle");
  return command;
}

CLI::App* addFrontier(CLI::App& app, FrontierOptions& options) {
  CLI::App* command = app.add_subcommand("frontier", "Measure what each setting of a scene costs and how exact it is");
  command->footer(examplesOf(*command));
  command->add_option("SCENE", options.scene, "Scene file (.toml), or the name of one in assets/scenes")->required();
  command->add_option("--out", options.out, "Folder for the results (out/<scene>_frontier)")->type_name("DIR");
  command
      ->add_option("--tool", options.tool_script,
                   "The tool's way: a script, or the name of one in assets/tools (the built-in indentation)")
      ->type_name("SCRIPT");
  command->add_option("--report", options.report, "Write a page with tables and the picture into this folder")
      ->type_name("DIR");
  command->add_flag("--quick", options.quick, "The most telling settings, and a coarser reference");
  command->add_flag("--resume", options.resume, "Keep the settings that the folder has already");
  return command;
}

CLI::App* addFollow(CLI::App& app, FollowOptions& options) {
  CLI::App* command = app.add_subcommand(
      "follow", "Drag the tool over a scene's organ on a cloud that follows it: cost, error, and what swaps do");
  command->footer(examplesOf(*command));
  command->add_option("SCENE", options.scenes, "Scene files (.toml), or names of those in assets/scenes")->required();
  command->add_option("--ways", options.ways, "Drags, at as many places of the organ (1)")
      ->type_name("N")
      ->check(CLI::Range(1, 100));
  command->add_option("--nu", options.nu, "Poisson's ratio of all materials in place of the scene's")
      ->type_name("NU")
      ->check(CLI::Range(0.0, 0.4999));
  command->add_option("--report", options.report, "Write a page and all numbers to this folder")->type_name("DIR");
  command->add_flag("--quick", options.quick, "No other spacings, and a coarser reference");
  return command;
}

CLI::App* addFit(CLI::App& app, FitOptions& options) {
  CLI::App* command =
      app.add_subcommand("fit", "Find the most accurate setting of a scene that holds a rate on this machine");
  command->footer(
      examplesOf(*command) +
      "\n\nExit codes: 0 found and held in the real-time loop, 1 not held (the scene is written all the same, "
      "and\nsays so), or interrupted, 2 bad option, file or scene.");
  command->add_option("SCENE", options.scene, "Scene file (.toml), or the name of one in assets/scenes")->required();
  command->add_option("--rate", options.rate_hz, "Ticks a second (the scene's)")
      ->type_name("HZ")
      ->check(CLI::Range(100.0, 2000.0));
  command->add_option("--cores", options.cores, "Threads for the physics (one per core)")
      ->type_name("N")
      ->check(CLI::Range(1, 64));
  command->add_option("--out", options.out, "Scene file to write (out/<scene>_<rate>hz.toml)")->type_name("FILE");
  command->add_option("--json", options.json, "Write what was found to this file")->type_name("FILE");
  command
      ->add_option("--tool", options.tool_script,
                   "The tool's way: a script, or the name of one in assets/tools (the built-in indentation)")
      ->type_name("SCRIPT");
  command->add_flag("--uniform", options.uniform, "The same spacing everywhere, for a tool that goes anywhere");
  command->add_flag("--resume", options.resume, "Keep what was tried already: FILE.fit.json beside the scene to write");
  return command;
}

CLI::App* addBatch(CLI::App& app, BatchOptions& options) {
  CLI::App* command = app.add_subcommand("batch", "Run many scenes, each on a thread of its own");
  command->footer(
      "A job is a line of JSON: {\"id\": \"soft\", \"scene\": \"liver\", \"set\": {\"material[0].young\": 2000},\n"
      "\"tool\": \"drag_across\", \"seconds\": 2, \"field\": true}. Only the scene is needed.\n\n" +
      examplesOf(*command));
  command->add_option("JOBS", options.jobs, "File with a job in each line (JSON Lines)")->required();
  command->add_option("--out", options.out, "Folder for the results (out/<file>)")->type_name("DIR");
  command->add_option("--jobs", options.workers, "Jobs at once (one per core)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  CLI::Option* shard =
      command->add_option("--shard", options.shard, "Every N-th job from the K-th on: for many machines")
          ->type_name("K/N");
  command->add_option("--merge", options.merge, "Run nothing: make one result of the folders of all shards")
      ->type_name("DIR")
      ->excludes(shard);
  options.use_cache = true;
  command->add_flag_callback(
      "--no-cache", [&options] { options.use_cache = false; }, "Make the set-ups anew and do not keep them");
  return command;
}

CLI::App* addCertify(CLI::App& app, CertifyOptions& options) {
  CLI::App* command =
      app.add_subcommand("certify", "Measure how exact a scene's force is, over depth, against two finer clouds");
  command->footer(
      examplesOf(*command) +
      "\n\nFor each depth the force, the scene's own, and the largest error since the depth before, as a share "
      "of\nthe force. Written beside the scene; palpate shows it where the tool keeps to the certified way, as "
      "long\nas nothing of the scene is changed.");
  command->add_option("SCENE", options.scene, "Scene file (.toml), or the name of one in assets/scenes")->required();
  command->add_option("--tool", options.tool_script, "Tool script, or the name of one in assets/tools")
      ->type_name("SCRIPT");
  command->add_option("--out", options.out, "File for the certificate (SCENE.certificate.json)")->type_name("FILE");
  command->add_option("--threads", options.threads, "Threads (one per core)")->type_name("N")->check(CLI::Range(1, 64));
  command->add_flag_callback(
      "--no-cache", [&options] { options.use_cache = false; }, "Make the set-up anew and do not keep it");
  return command;
}

CLI::App* addIdentify(CLI::App& app, IdentifyOptions& options) {
  CLI::App* command = app.add_subcommand("identify", "Find a material's parameters from a measured force curve");
  command->footer(examplesOf(*command) +
                  "\n\nExit codes: 0 found, 1 not found or not told apart, 2 bad option, file or scene,\n3 found but "
                  "doubted: the scene can't follow the curve, or the curve had not settled.");
  command->add_option("SCENE", options.scene, "Scene file (.toml), or the name of one in assets/scenes")->required();
  command
      ->add_option(
          "--measured", options.measured,
          "CSV with columns depth_m (or depth_mm) and force_N (or force_mN), or a run's force.csv; with --regions "
          "x_m, y_m, z_m of the tip at rest and force_N along the tool's axis, a row for each press")
      ->type_name("FILE")
      ->required();
  command
      ->add_option("--parameter", options.parameters,
                   "One or two of the material's law by their scene keys, such as mu or mu[0] of a list (its first)")
      ->type_name("NAME");
  command->add_option("--material", options.material, "Which material, from 0")
      ->type_name("N")
      ->check(CLI::Range(0, 99));
  command
      ->add_option("--seconds", options.seconds,
                   "Physics time in which the simulated tool is pressed in (the measured time, 2 at most where nothing "
                   "relaxes)")
      ->type_name("S")
      ->check(CLI::Range(0.1, 100.0));
  command
      ->add_flag("--regions", options.regions,
                 "A parameter of all of the scene's materials at once, from presses at rest at many places")
      ->excludes("--material")
      ->excludes("--seconds");
  command->add_option("--threads", options.threads, "Threads (one per core)")->type_name("N")->check(CLI::Range(1, 64));
  command->add_option("--out", options.out, "Folder for the results (out/<scene>_identify)")->type_name("DIR");
  return command;
}

CLI::App* addAtlas(CLI::App& app, AtlasOptions& options) {
  std::string axes = "Axes (AXIS/VALUE for one cell):";
  for (const auto& axis : atlasAxes()) axes += "\n  " + axis.key + ": " + axis.title;
  CLI::App* command = app.add_subcommand(
      "atlas", "Map where the numbers are true: each cell stable, degraded or refused, none silently wrong");
  command->footer(axes + "\n\n" + examplesOf(*command));
  command->add_option("CELL", options.cells, "Cells or whole axes (all)");
  command->add_flag("--quick", options.quick, "A third of the cells, under a minute");
  command->add_option("--out", options.out, "Folder for atlas.json, atlas.csv and atlas.png (out/atlas)")
      ->type_name("DIR");
  command->add_option("--json", options.json, "Write the results to this file, too")->type_name("FILE");
  command->add_option("--report", options.report, "Write a page with the map into this folder")->type_name("DIR");
  command->add_flag("--resume", options.resume, "Keep the cells that the folder has already");
  return command;
}

/// What import and brainshift have in common, for scans only.
void addScanOptions(CLI::App& command, ImportScanOptions& options) {
  command.footer(examplesOf(command));
  command.add_option("--mask", options.mask, "Which voxels are the organ: a NIfTI file of 0 and 1")->type_name("FILE");
  command.add_option("--labels", options.labels, "In place of a mask: a NIfTI file of labels")->type_name("FILE");
  command.add_option("--label", options.label, "The labels that are the organ, such as 2,3,41,42")
      ->delimiter(',')
      ->type_name("N,...");
  command.add_option("--classes", options.classes, "Classes of tissue by intensity (3); 0: one tissue")
      ->type_name("N")
      ->check(CLI::IsMember({0, 2, 3, 4, 5, 6}));
  command.add_option("--fluid", options.fluid, "The class that is fluid: dark (T1, the default), bright (T2) or none")
      ->check(CLI::IsMember({"dark", "bright", "none"}));
  command
      .add_option("--electrodes", options.electrodes,
                  "Where points of the surface went: CSV with x,y,z (and x0,y0,z0 before), .fcsv or .mrk.json")
      ->type_name("FILE");
  command
      .add_option("--frame", options.frame, "Of the electrodes' CSV: ras (right, front, top) or lps (left, back, top)")
      ->check(CLI::IsMember({"ras", "lps"}));
  command.add_flag("--skull", options.skull,
                   "It slides in a rigid skull that lies half a millimetre around it, open over the electrodes");
  command
      .add_option(
          "--open", options.opened,
          "Where the skull is open, too: a ball by its middle and radius in mm, in --frame (or ras); repeatable")
      ->allow_extra_args(false)
      ->type_name("X,Y,Z,R");
  command
      .add_option("--fix", options.fix,
                  "Where the organ is held, such as the brain stem's end: a ball likewise (its lowest twentieth)")
      ->allow_extra_args(false)
      ->type_name("X,Y,Z,R");
  command.add_option("--spacing", options.spacing_mm, "Between nodes, mm (for --nodes)")
      ->type_name("MM")
      ->check(CLI::Range(0.1, 1000.0));
  command.add_option("--nodes", options.nodes, "How many there should be about (3000, which holds 500 Hz)")
      ->type_name("N")
      ->check(CLI::Range(50, 40000));
  command.add_option("--smoothing", options.smoothing_mm, "Of the mask's border, mm (0.35 of the spacing)")
      ->type_name("MM")
      ->check(CLI::Range(0.0, 100.0));
  command.add_flag("--assume-ras", options.assume_ras,
                   "Take the axes of a scan that does not say how it lies as right, front, top");
}

/// A surface, or a scan with all that only a scan has.
CLI::App* addImport(CLI::App& app, ImportOptions& options, ImportScanOptions& scan) {
  CLI::App* command = app.add_subcommand(
      "import", "Make a scene of a surface, repaired where it must be, or of a scan and the organ's mask");
  addScanOptions(*command, scan);
  const std::vector<CLI::Option*> of_scans =
      command->get_options([](const CLI::Option* option) { return option->get_name() != "--help"; });
  command->add_option("FILE", options.file, "Surface: .obj, .stl, .ply, .off or .vtk; scan: .nii or .nii.gz")
      ->required();
  command->add_option("--out", options.out, "Folder for surface, scene, picture and report (out/<file's name>)")
      ->type_name("DIR");
  command
      ->add_option(
          "--unit", options.unit,
          "Of the surface's coordinates (guessed where its size leaves no doubt), or of the electrodes' CSV (mm)")
      ->type_name("mm|cm|m")
      ->check(CLI::IsMember({"mm", "cm", "m"}));
  command->add_flag_callback(
      "--no-cache", [&options] { options.use_cache = false; }, "Do not keep a surface's set-up for the first opening");
  command->parse_complete_callback([&options, &scan, of_scans] {
    if (isScan(options.file)) {
      scan.scan = options.file;
      scan.out = options.out;
      if (!options.unit.empty()) scan.unit = options.unit;
      return;
    }
    for (const CLI::Option* option : of_scans)
      if (option->count() > 0) throw CLI::ValidationError(option->get_name(), "is for scans (.nii, .nii.gz) only");
  });
  return command;
}

CLI::App* addBrainshift(CLI::App& app, ImportScanOptions& options, std::string& like) {
  CLI::App* command = app.add_subcommand(
      "brainshift", "Import a scan, solve it moved by its electrodes, and warp it: the paper's section 5");
  addScanOptions(*command, options);
  command->add_option("SCAN", options.scan, "The scan (.nii, .nii.gz)")->required();
  command->add_option("--unit", options.unit, "Of the electrodes' CSV: mm (the default), cm or m")
      ->check(CLI::IsMember({"mm", "cm", "m"}));
  command->add_option("--out", options.out, "Folder of the case (out/<scan's name>)")->type_name("DIR");
  command->add_option("--like", like, "NIfTI file whose voxels the results have (the scan's)")->type_name("FILE");
  return command;
}

CLI::App* addWarp(CLI::App& app, WarpOptions& options) {
  CLI::App* command = app.add_subcommand("warp", "Warp an image by the solution of a case");
  command->footer(examplesOf(*command));
  command->add_option("CASE", options.folder, "Folder that mtled import wrote and mtled solve solved")->required();
  command->add_option("--image", options.image, "The image (.nii, .nii.gz)")->type_name("FILE");
  command->add_flag("--labels", options.labels, "Its values name things: none is made between two");
  command->add_option("--like", options.like, "NIfTI file whose voxels the results have (the image's)")
      ->type_name("FILE");
  command->add_option("--fill", options.fill, "Value where tissue was and is no more (0)");
  command->add_flag("--assume-ras", options.assume_ras,
                    "Take the axes of an image that does not say how it lies as right, front, top");
  command->add_option("--out", options.out, "Folder for the results (the case's)")->type_name("DIR");
  return command;
}

CLI::App* addPhantom(CLI::App& app, PhantomCommandOptions& options) {
  CLI::App* command = app.add_subcommand("phantom", "Make a brain scan by formula, to try import with");
  command->footer(examplesOf(*command));
  PhantomOptions& p = options.phantom;
  command->add_option("--out", options.out, "Folder (out/phantom)")->type_name("DIR");
  command->add_option("--voxels", p.voxels, "Along the longest side of 192 mm (128)")
      ->type_name("N")
      ->check(CLI::Range(24, 512));
  command->add_option("--noise", p.noise, "Of the white matter's intensity (0.03)")->check(CLI::Range(0.0, 0.5));
  command->add_option("--bias", p.bias, "How much brighter one end is than the other (0.4)")
      ->check(CLI::Range(0.0, 2.0));
  command
      ->add_option_function<double>(
          "--shift", [&options](double shift) { options.phantom.shift = shift * mm; },
          "How far the middle electrode is pushed in, mm (12)")
      ->type_name("MM")
      ->check(CLI::Range(0.0, 40.0));
  command->add_option("--seed", p.seed, "Of the noise (1)");
  return command;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"mtled: meshless total-Lagrangian explicit dynamics in batch."};
  app.footer(examples);
  app.set_version_flag("--version", buildInfo());
  app.require_subcommand(1);
  SolveOptions solve;
  VerifyOptions verify;
  BenchOptions bench;
  FrontierOptions frontier;
  FollowOptions follow;
  MatrixOptions matrix;
  FitOptions fit;
  CertifyOptions certify;
  AtlasOptions atlas;
  BatchOptions batch;
  IdentifyOptions identify;
  ImportOptions import;
  ImportScanOptions scan;
  PhantomCommandOptions phantom;
  ImportScanOptions shift;
  std::string shift_like;
  WarpOptions warp;
  CLI::App* const solve_app = addSolve(app, solve);
  CLI::App* const verify_app = addVerify(app, verify);
  CLI::App* const matrix_app = addMatrix(*verify_app, matrix);
  const std::pair<CLI::App*, std::function<int()>> commands[] = {
      {solve_app, [&] { return solveCommand(solve); }},
      {verify_app, [&] { return *matrix_app ? matrixCommand(matrix) : verifyCommand(verify); }},
      {addBench(app, bench), [&] { return benchCommand(bench); }},
      {addFollow(app, follow), [&] { return followCommand(follow); }},
      {addFrontier(app, frontier), [&] { return frontierCommand(frontier); }},
      {addFit(app, fit), [&] { return fitCommand(fit); }},
      {addCertify(app, certify), [&] { return certifyCommand(certify); }},
      {addAtlas(app, atlas), [&] { return atlasCommand(atlas); }},
      {addBatch(app, batch), [&] { return batchCommand(batch); }},
      {addIdentify(app, identify), [&] { return identifyCommand(identify); }},
      {addImport(app, import, scan), [&] { return isScan(import.file) ? importScan(scan) : importCommand(import); }},
      {addWarp(app, warp), [&] { return warpCommand(warp); }},
      {addBrainshift(app, shift, shift_like), [&] { return brainshiftCommand(shift, shift_like); }},
      {addPhantom(app, phantom), [&] { return phantomCommand(phantom); }}};
  if (const std::string wrong = wrongCommand(app, argc, argv); !wrong.empty()) {
    std::cerr << "mtled: " << wrong << std::endl;
    return unusable_input;
  }
  catchInterrupts();
  try {
    int code = 0;
    try {
      app.parse(argc, argv);
      for (const auto& [command, run] : commands)
        if (*command) code = run();
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
