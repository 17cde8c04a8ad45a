#include "app/run/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "app/run/run_export.h"
#include "base/build_info.h"
#include "base/input_error.h"
#include "base/nearest_word.h"
#include "base/number_text.h"
#include "realtime/device/open_device.h"

namespace palpate::app {

namespace {

constexpr double most_animated_seconds = 60;
constexpr int min_width = 320, min_height = 240;  // below that no panel is readable
constexpr int max_side = 8192;                    // px; what every OpenGL 3.3 driver in use can draw into

const char* const examples = R"(Examples:
  palpate liver                                  press the probe into the liver, in a window
  palpate liver --offscreen --seconds 3          no display: picture, force curve and report in out/liver
  palpate layer_sphere --tool indent_hold_retract --out /tmp/layer         a scripted tool
  palpate --soak 60 liver --offscreen            an hour of presses; tells of memory, drift, deadlines in out/liver-soak
  palpate liver --record session.rec             keep what the tool did ...
  palpate layer_sphere --device udp:7711         a haptic device holds the probe (engine/realtime/device/README.md)
  palpate liver --replay session.rec --offscreen --as-fast-as-possible   ... and repeat it bit for bit

Keys in the window: F1 shows them. Exit codes: 0 done, 1 failed while running, 2 bad option or scene,
3 doubted (--strict), 4 ended frozen, 5 differs (--compare, --expect), 130 interrupted; results are kept.)";

/// Accepts finite numbers in [low, high] and says so otherwise.
CLI::Validator numberWithin(double low, double high, const std::string& unit) {
  std::ostringstream range;
  range << low << " to " << high << ' ' << unit;
  return CLI::Validator(
      [low, high, text = range.str()](std::string& input) -> std::string {
        double value = 0;
        if (!CLI::detail::lexical_cast(input, value) || !std::isfinite(value) || value < low || value > high)
          return "'" + input + "' is not within " + text;
        return {};
      },
      "");
}

/// Reads "1280x800"; false where it is anything else or out of range.
bool readSize(const std::string& text, int& width, int& height) {
  const auto x = text.find('x');
  if (x == std::string::npos) return false;
  const std::string w = text.substr(0, x), h = text.substr(x + 1);
  const auto digits = [](const std::string& s) {
    return !s.empty() && s.size() <= 5 && s.find_first_not_of("0123456789") == std::string::npos;
  };
  if (!digits(w) || !digits(h)) return false;
  width = std::stoi(w);
  height = std::stoi(h);
  return width >= min_width && height >= min_height && width <= max_side && height <= max_side;
}

ParsedOptions refusal(const std::string& problem) { return {{}, "palpate: " + problem + "; see palpate --help", 2}; }

/// Options that are read further when all are known.
struct Texts {
  std::string times, camera, view, field, range;
};

void addPictureOptions(CLI::App& app, Options& o, Texts& texts) {
  app.add_flag("!--no-panels", o.picture.panels,
               "Off-screen: the organ alone, e.g. palpate liver --offscreen --no-panels");
  app.add_flag(
      "--timing", o.picture.timing,
      "Off-screen: with the log, and how fast this machine was, in the picture; without, it is the same again");
  app.add_flag("--close", o.picture.close,
               "Off-screen: look at the probe's tip from nearby, e.g. --close --cut --camera=-60,15,0.1");
  app.add_option("--camera", texts.camera,
                 "Off-screen: look from AZIMUTH,ELEVATION[,DISTANCE], e.g. --camera -60,25,0.4")
      ->type_name("AZ,EL[,M]");
  app.add_option("--view", texts.view, "Off-screen: look from front, back, left, right, top or bottom, e.g. --view top")
      ->type_name("NAME");
  app.add_option("--field", texts.field,
                 "Off-screen: colour by displacement, von_mises, J or, in a task, pressure, e.g. --field von_mises")
      ->type_name("NAME");
  app.add_option("--range", texts.range, "The colours' range in m, Pa or 1, e.g. --field displacement --range 0:0.01")
      ->type_name("LOW:HIGH");
  app.add_option("--show", o.picture.show,
                 "Overlays to show: nodes, points, force, contact, fixed, tool, e.g. --show nodes")
      ->type_name("LIST");
  app.add_option("--hide", o.picture.hide, "Overlays to hide, likewise, e.g. --hide force,fixed")->type_name("LIST");
  app.add_flag("--cut", o.picture.cut,
               "Off-screen: the organ cut open through the probe, e.g. palpate liver --offscreen --cut");
  app.add_flag("--ghost", o.picture.ghost,
               "Off-screen: the skin is seen through, e.g. palpate liver --offscreen --ghost");
  app.add_option("--animation", o.animation,
                 "Off-screen: the run as an animated PNG, in the end with what was hidden, e.g. palpate lump_liver "
                 "--offscreen --seconds 6 --ghost --animation found.png --size 640x400")
      ->type_name("PNG");
  app.add_option("--export", o.export_file,
                 "Off-screen: the run over time for other programs: .gltf or .glb (skin and tools, for viewers and "
                 "films), .pvd (the whole body, for ParaView), e.g. palpate liver --replay session.rec --offscreen "
                 "--fast --export run.glb")
      ->type_name("FILE");
  app.add_flag("--fields", o.dump_fields, "Off-screen: the deformed body beside each picture, as VTU, e.g. --fields");
  app.add_option(
         "--compare", o.compare,
         "Off-screen: exit with code 5 where the last picture differs from PNG, e.g. --compare ref.png; SCENE may "
         "be a picture, too: palpate new.png --compare ref.png")
      ->type_name("PNG");
  app.add_option("--tolerance", o.tolerance,
                 "Of --compare: mean colour difference (delta E) allowed, e.g. --tolerance 1")
      ->type_name("E")
      ->check(numberWithin(0, 100, "delta E"));
  app.add_option(
         "--expect", o.expect,
         "Off-screen: exit with code 5 where report.json differs from this baseline, e.g. --expect baseline.json")
      ->type_name("JSON");
  app.add_flag("--strict", o.strict, "Off-screen: exit with code 3 where a force was doubted, e.g. --strict");
}

/// "0.5,1.5" as ascending times; empty where it is something else.
std::vector<double> timesOf(const std::string& text) {
  std::vector<double> times;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    double time = 0;
    if (!CLI::detail::lexical_cast(part, time) || !std::isfinite(time) || time < 0 || time > 1e6) return {};
    times.push_back(time);
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

/// What is wrong with the options of off-screen pictures; empty: nothing.
std::string readPictureOptions(Options& o, const Texts& texts) {
  if (!texts.times.empty()) {
    o.snapshot_at = timesOf(texts.times);
    if (o.snapshot_at.empty())
      return "--snapshot-at: '" + texts.times + "' is not a time from 0 to 1e6 s, or several with commas";
    if (!o.offscreen) return "--snapshot-at is for off-screen runs; add --offscreen";
    if (o.seconds && o.snapshot_at.back() > *o.seconds) return "--snapshot-at lies after the end that --seconds sets";
  }
  if (o.trainee && (!o.offscreen || o.seconds || !o.tool_script.empty() || !o.replay.empty() || o.soak_minutes))
    return "--trainee moves the tool itself, off-screen, to its end; add --offscreen, and leave out --seconds, --tool, "
           "--replay and --soak";
  if (o.answers && (o.trainee || !o.replay.empty()))
    return "--answers shows lumps without a search; leave out --trainee and --replay";
  const std::string problem = readPictureChoice(texts.camera, texts.view, texts.field, texts.range, o.picture);
  if (!problem.empty()) return problem;
  const bool for_pictures = !texts.camera.empty() || !texts.view.empty() || !texts.field.empty() ||
                            !o.picture.show.empty() || !o.picture.hide.empty() || !o.picture.panels ||
                            o.picture.timing || o.picture.close || o.picture.cut || o.picture.ghost || o.dump_fields ||
                            !o.expect.empty() || o.strict;
  if (for_pictures && !o.offscreen)
    return "--no-panels, --timing, --close, --camera, --view, --field, --show, --hide, --cut, --ghost, --fields, "
           "--expect and --strict are for off-screen runs; add --offscreen";
  if (!o.animation.empty()) {
    if (!o.offscreen || !o.seconds || !o.snapshot_at.empty())
      return "--animation is for off-screen runs of a given length, a replay too, without --snapshot-at; add "
             "--offscreen --seconds 6";
    if (*o.seconds > most_animated_seconds)
      return format("--animation shows at most %.0f s; give a smaller --seconds", most_animated_seconds);
    const int pictures = std::max(2, static_cast<int>(*o.seconds * animation_rate));
    for (int k = 1; k <= pictures; ++k) o.snapshot_at.push_back(k * *o.seconds / pictures);
  }
  if (!o.export_file.empty()) {
    if (!o.offscreen || !o.snapshot_at.empty() || o.soak_minutes)
      return "--export is for off-screen runs, a replay too, without --snapshot-at, --animation and --soak; add "
             "--offscreen";
    if (const std::string wrong = exportProblem(o.export_file); !wrong.empty()) return wrong;
  }
  if (!o.compare.empty() && !o.offscreen && !o.scene.ends_with(".png"))
    return "--compare is for off-screen runs and pictures; add --offscreen";
  return {};
}

/// @param size, no_cache, texts  what the options say of these; they reach `o` later
void addOptions(CLI::App& app, Options& o, std::string& size, bool& no_cache, Texts& texts) {
  app.add_option("SCENE", o.scene, "Scene file (.toml), or the name of one in assets/scenes, e.g. liver");
  app.add_flag("--offscreen", o.offscreen,
               "Run without a display; write snapshot.png, force.csv and report.json, e.g. palpate liver --offscreen");
  app.add_option("--seconds", o.seconds, "End after S seconds of physics time, e.g. --seconds 20")
      ->type_name("S")
      ->check(numberWithin(1e-3, 1e6, "s"));
  app.add_option("--soak", o.soak_minutes,
                 "Press, drag and release at many places for MINUTES of physics time (scene: liver if none is given); "
                 "write soak.txt and soak.json once a minute; fail where memory grows or the state at rest drifts, "
                 "e.g. --soak 60 liver --offscreen --fast")
      ->type_name("MINUTES")
      ->check(numberWithin(0.01, 1e6, "minutes"));
  app.add_flag("--rough", o.rough,
               "With --soak: a rough hand, which pokes to the bottom, jumps, presses and holds, while friction and "
               "materials change, e.g. --soak 10 --rough liver --offscreen --fast");
  app.add_option("--seed", o.seed, "With --soak: another sequence of presses, e.g. --soak 10 --rough --seed 7")
      ->type_name("N");
  app.add_option("--rate", o.rate_hz, "Ticks per second instead of the scene's rate, e.g. --rate 1000")
      ->type_name("HZ")
      ->check(numberWithin(100, 2000, "Hz"));
  app.add_option("--tool", o.tool_script,
                 "Move the tool as a script says: a file, or the name of one in assets/tools, e.g. --tool drag_across")
      ->type_name("SCRIPT");
  app.add_option("--record", o.record, "Keep the tool's motion, tick by tick, e.g. --record session.rec")
      ->type_name("FILE");
  app.add_option("--replay", o.replay, "Repeat a recording; gives the same state_hash, e.g. --replay session.rec")
      ->type_name("FILE");
  app.add_option("--device", o.device,
                 "Let a haptic device hold the probe: udp[:PORT] (a bridge program), simulated, or ws://localhost:PORT "
                 "(a vendor's service), e.g. --device udp:7711")
      ->check([](const std::string& name) { return name.empty() ? "give a device, or leave --device out" : ""; }, "")
      ->type_name("DEVICE");
  app.add_option("--out", o.out,
                 "Folder for picture, force curve and report (off-screen: out/<scene>), e.g. --out /tmp/run")
      ->type_name("DIR");
  app.add_option("--size", size, "Size of the window or picture in pixels, e.g. --size 1600x1000")
      ->type_name("WxH")
      ->default_str("1280x800");
  app.add_flag("--demo", o.demo,
               "Begin as the demo: full screen, a large force; plays by itself while nobody is there, e.g. palpate "
               "liver --demo");
  app.add_option("--idle", o.idle_seconds,
                 "Seconds without a hand at mouse or keys after which the window rests, e.g. --demo --idle 60")
      ->type_name("S")
      ->default_str("30")
      ->check(numberWithin(0.1, 1e6, "s"));
  app.add_option("--snapshot-at", texts.times,
                 "Off-screen: take the picture at S seconds instead of at the end, or several, e.g. --snapshot-at "
                 "0.5,1.5; picture, plots and fields are of that very tick")
      ->type_name("S");
  addPictureOptions(app, o, texts);
  app.add_flag("--trainee", o.trainee,
               "Off-screen: a trainee by rule looks for the scene's lumps; writes score.json, e.g. palpate "
               "lump_liver --trainee --offscreen --fast");
  app.add_option("--trainee-name", o.trainee_name,
                 "Who searches, for the score sheet, e.g. palpate lump_liver --trainee-name \"A. Miller\"")
      ->type_name("NAME");
  app.add_flag("--answers", o.answers,
               "Show the lumps of a task without a search, and score nothing, e.g. palpate lump_liver --answers "
               "--offscreen --ghost");
  app.add_option("--scores", o.scores,
                 "Put all score sheets (JSON) below DIR into one table, DIR/scores.csv, or that of --out, e.g. palpate "
                 "--scores out")
      ->type_name("DIR");
  app.add_flag("--check-lumps", o.check_lumps,
               "Tell how clearly each lump is felt at the working depth; exit with code 5 where one is not, 3 where "
               "that depends "
               "on the nodes, e.g. palpate lump_liver --check-lumps");
  app.add_option("--threads", o.threads, "Physics threads instead of the scene's number, e.g. --threads 2")
      ->type_name("N")
      ->check(numberWithin(1, 64, "threads"));
  app.add_flag("--as-fast-as-possible,--fast", o.as_fast_as_possible,
               "Do not wait for the clock, e.g. palpate liver --replay session.rec --offscreen --as-fast-as-possible");
  app.add_flag("--no-cache", no_cache, "Make the set-up anew and do not keep it, e.g. palpate liver --no-cache");
}

/// What is wrong with --device; empty: nothing.
std::string deviceProblem(const Options& o) {
  if (o.device.empty()) return "";
  try {
    checkDevice(o.device);
  } catch (const std::exception& error) {
    return std::string("--device: ") + error.what();
  }
  if (!o.tool_script.empty() || !o.replay.empty() || o.soak_minutes || o.trainee)
    return "--device holds the probe; leave out --tool, --replay, --soak and --trainee";
  if (o.as_fast_as_possible) return "--device needs the clock; leave out --as-fast-as-possible";
  return "";
}

}  // namespace

ParsedOptions parseOptions(int argc, const char* const* argv) {
  Options o;
  std::string size;
  bool no_cache = false;
  CLI::App app{"Palpate: press a probe into soft tissue, simulated without a mesh at haptic rates."};
  app.footer(examples);
  app.set_version_flag("--version", buildInfo());
  app.get_formatter()->column_width(36);
  Texts texts;
  addOptions(app, o, size, no_cache, texts);

  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    return {{}, app.help(), 0};
  } catch (const CLI::CallForVersion& version) {
    return {{}, version.what(), 0};
  } catch (const CLI::ParseError& error) {
    return refusal(error.what());
  }

  o.use_cache = !no_cache;
  if (o.soak_minutes && o.scene.empty()) o.scene = "liver";
  if (!o.soak_minutes && (o.rough || o.seed))
    return refusal("--rough and --seed are for --soak; say for how many minutes, e.g. --soak 10 --rough");
  if (!o.scores.empty()) {
    if (!o.scene.empty() || o.offscreen)
      return refusal("--scores reads score sheets alone; leave out SCENE and the rest");
    return {o, "", 0};
  }
  if (o.scene.empty())
    return refusal("SCENE is required: a scene file, or the name of one in assets/scenes, e.g. liver");
  if (o.soak_minutes && (o.seconds || !o.tool_script.empty() || !o.replay.empty()))
    return refusal("--soak says how long to run and moves the tool itself; leave out --seconds, --tool and --replay");
  if (o.soak_minutes && !o.record.empty())
    return refusal("--soak repeats itself bit for bit and runs too long for a recording; leave out --record");
  if (!size.empty() && !readSize(size, o.width, o.height))
    return refusal("--size: '" + size + "' is not a size such as 1280x800 (" + std::to_string(min_width) + "x" +
                   std::to_string(min_height) + " to " + std::to_string(max_side) + "x" + std::to_string(max_side) +
                   ")");
  if (o.demo && o.offscreen) return refusal("--demo is for the window; leave out --offscreen");
  if (!o.replay.empty() && !o.tool_script.empty())
    return refusal("--replay and --tool both say where the tool goes; give one of them");
  if (const std::string problem = readPictureOptions(o, texts); !problem.empty()) return refusal(problem);
  if (const std::string problem = deviceProblem(o); !problem.empty()) return refusal(problem);
  for (int k = 0; k < argc; ++k) o.command += (k > 0 ? " " : "") + std::string(argv[k]);
  return {o, "", 0};
}

}  // namespace palpate::app
