#include "app/run/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/build_info.h"
#include "base/input_error.h"
#include "base/nearest_word.h"

namespace palpate::app {

namespace {

constexpr int min_width = 320, min_height = 240;  // below that no panel is readable
constexpr int max_side = 8192;                    // px; what every OpenGL 3.3 driver in use can draw into

const char* const examples = R"(Examples:
  palpate liver                                  press the probe into the liver, in a window
  palpate liver --offscreen --seconds 3          no display: picture, force curve and report in out/liver
  palpate layer_sphere --tool indent_hold_retract --out /tmp/layer         a scripted tool
  palpate --soak 60 liver --offscreen            an hour of presses; tells of memory, drift, deadlines in out/liver-soak
  palpate liver --record session.rec             keep what the tool did ...
  palpate liver --replay session.rec --offscreen --as-fast-as-possible   ... and repeat it bit for bit

Keys in the window: F1 shows them. Exit codes: 0 done, 1 failed while running, 2 bad option or scene.)";

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

/// @param size, no_cache  what the options say of these; they reach `o` later
void addOptions(CLI::App& app, Options& o, std::string& size, bool& no_cache) {
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
  app.add_option("--out", o.out,
                 "Folder for picture, force curve and report (off-screen: out/<scene>), e.g. --out /tmp/run")
      ->type_name("DIR");
  app.add_option("--size", size, "Size of the window or picture in pixels, e.g. --size 1600x1000")
      ->type_name("WxH")
      ->default_str("1280x800");
  app.add_option("--snapshot-at", o.snapshot_at,
                 "Off-screen: take the picture at S seconds instead of at the end, e.g. --snapshot-at 1.5")
      ->type_name("S")
      ->check(numberWithin(0, 1e6, "s"));
  app.add_option("--threads", o.threads, "Physics threads instead of the scene's number, e.g. --threads 2")
      ->type_name("N")
      ->check(numberWithin(1, 64, "threads"));
  app.add_flag("--as-fast-as-possible,--fast", o.as_fast_as_possible,
               "Do not wait for the clock, e.g. palpate liver --replay session.rec --offscreen --as-fast-as-possible");
  app.add_flag("--no-cache", no_cache, "Make the set-up anew and do not keep it, e.g. palpate liver --no-cache");
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
  addOptions(app, o, size, no_cache);

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
  if (!o.replay.empty() && !o.tool_script.empty())
    return refusal("--replay and --tool both say where the tool goes; give one of them");
  if (!o.replay.empty() && o.replay == o.record)
    return refusal("--record would overwrite the recording that --replay reads; name another file");
  if (o.snapshot_at && !o.offscreen) return refusal("--snapshot-at is for off-screen runs; add --offscreen");
  if (o.snapshot_at && o.seconds && *o.snapshot_at > *o.seconds)
    return refusal("--snapshot-at lies after the end that --seconds sets");
  return {o, "", 0};
}

}  // namespace palpate::app
