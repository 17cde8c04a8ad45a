#pragma once

#include <cmath>
#include <iosfwd>
#include <string>
#include <vector>

namespace palpate::tools {

/// What a cell of the atlas saw of a body. Times are physics time, s.
struct AtlasMeasure {
  std::string refused;  // the set-up's reason; empty: it ran
  int nodes = 0, points = 0;
  double steps = 0;         // of dt
  double doubt_at = NAN;    // first doubt; NaN: none
  std::string doubt;        // its name (doubtName)
  double doubted_for = 0;   // s, in all
  double lost_at = NAN;     // blown up, not finite or frozen by the watchdog; NaN: not
  std::string loss;         // which
  int restored = 0;         // times that it was lost and went back to an earlier state
  double energy_error = 0;  // largest of StepReport's
  double step_share = 0;    // likewise
  double min_J = 1;
  double growth = 0;          // of the energy while nothing did work on the body, relative
  std::string compared;       // what with what: "force / closed form"; empty: nothing
  double deviation = NAN;     // relative, signed
  double bound = NAN;         // beyond which the numbers are wrong
  bool doubted_then = false;  // doubted while the deviation was measured
};

enum class AtlasOutcome {
  Stable,    // right, or with nothing to doubt
  Degraded,  // doubted, lost after a doubt, or wrong while doubted
  Refused,   // not run, with a reason
  Silent,    // wrong, or lost, with no doubt before: the program has failed
};
const char* outcomeName(AtlasOutcome outcome);

/// Energy that grows by more than this with nothing doubted is silently wrong.
inline constexpr double atlas_growth_bound = 0.1;

AtlasOutcome outcomeOf(const AtlasMeasure& measure);
/// In words: "amber 'squeezed' from 0.31 s; force / closed form +4 % (bound 2 %)".
std::string howMuch(const AtlasMeasure& measure);

/// A cell with what became of it.
struct AtlasRow {
  std::string axis, name, value;  // "nu", "nu/0.49", "0.49"
  AtlasMeasure measure;
  double seconds = 0;  // wall time
};

struct Atlas {
  std::string build, identity;  // what a resumed run must agree in
  std::vector<AtlasRow> rows;

  int count(AtlasOutcome outcome) const;
};

void printAtlas(std::ostream& out, const Atlas& atlas);
std::string csvOf(const Atlas& atlas);
std::string jsonOf(const Atlas& atlas);
/// Throws std::runtime_error where the text is no atlas.
Atlas atlasFromJson(const std::string& text);

}  // namespace palpate::tools
