#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/panels/tool_choice.h"
#include "app/run/picture_choice.h"

namespace palpate::app {

/// What the command line of `palpate` asks for. Values are checked as far as that
/// needs neither the scene nor the file system.
struct Options {
  std::string scene;  // as typed: a file, or the name of a scene in assets/scenes
  bool offscreen = false;
  std::optional<double> seconds;          // s of physics time, then end
  std::optional<double> soak_minutes;     // min of physics time under a tool that never stops, then end
  bool rough = false;                     // that tool is a rough hand's
  std::optional<unsigned> seed;           // of the soak's tool
  std::optional<double> rate_hz;          // instead of the scene's
  std::optional<int> threads;             // instead of the scene's
  std::vector<double> snapshot_at;        // s, ascending; off-screen pictures; empty: the end of the run
  PictureChoice picture;                  // of these
  bool dump_fields = false;               // beside each picture, for ParaView
  std::string animation;                  // file of the run as an animated PNG; empty: none
  std::string export_file;                // of the run for other programs (RunExport); empty: none
  std::string compare, expect;            // a reference picture, a baseline of the report; empty: none
  double tolerance = 0.5;                 // of compare: mean delta E
  bool trainee = false;                   // a trainee by rule looks for the lumps
  bool check_lumps = false;               // whether they can be felt
  bool answers = false;                   // they may be seen, and nobody searches
  int answers_seen = 0;                   // of this scene in this program before
  std::string trainee_name;               // for the score sheet
  std::string scores;                     // folder whose score sheets are put into one table; empty: none
  bool strict = false;                    // a doubted run is a failed one
  std::string command;                    // as typed
  std::optional<ToolChoice> tool_choice;  // chosen in the window, instead of the scene's
  std::string tool_script;                // as typed: a file, or the name of a script in assets/tools; empty: none
  std::string record;                     // empty: none
  std::string replay;                     // empty: none
  std::string device;                     // haptic device that holds the tool (openDevice); empty: none
  std::string out;                 // empty: out/<scene> off-screen, out/<scene>-soak in a soak, nothing in the window
  int width = 1280, height = 800;  // px
  bool as_fast_as_possible = false;
  bool use_cache = false;    // keep the set-up for the next start
  bool demo = false;         // the window begins as the demo
  double idle_seconds = 30;  // without a hand at mouse or keys: then the window rests, and the demo plays by itself
};

inline constexpr double animation_rate = 10;  // pictures a second

/// The outcome of reading a command line: options to run with, or a text to print
/// and an exit code (0: help or version was asked for; 2: the line can't be used).
struct ParsedOptions {
  std::optional<Options> options;
  std::string message;
  int exit_code = 0;
};

/// Reads the command line. Never prints or exits itself.
ParsedOptions parseOptions(int argc, const char* const* argv);

}  // namespace palpate::app
