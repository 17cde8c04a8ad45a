#include "mtled/import/import_unit.h"

#include <vector>

#include "base/input_error.h"
#include "base/number_text.h"

namespace palpate::tools {
namespace {

struct Unit {
  const char* name;
  double length;  // m
};
constexpr Unit units[] = {{"mm", 0.001}, {"cm", 0.01}, {"m", 1.0}};

constexpr double shortest_organ = 0.005, longest_organ = 0.6;    // m
constexpr double shortest_body = 0.001, longest_body = 5;        // m, even where --unit says so
constexpr double shortest_number = 1e-9, longest_number = 1e12;  // beyond, no unit helps

std::string lengthText(double metres) {
  if (metres < 0.0995) return format("%.3g mm", 1e3 * metres);
  return metres < 0.9995 ? format("%.3g cm", 1e2 * metres) : format("%.4g m", metres);
}

}  // namespace

SurfaceUnit surfaceUnit(const std::string& file, const std::string& asked, double length) {
  std::vector<SurfaceUnit> likely;
  std::string lengths, absurd;
  for (const Unit& unit : units) {
    const std::string text = lengthText(length * unit.length);
    if (asked == unit.name) {
      if (length * unit.length >= shortest_body && length * unit.length <= longest_body)
        return {unit.name, unit.length, "as --unit says; it is " + text + " long then"};
      absurd = text;
      continue;
    }
    lengths += (lengths.empty() ? "" : ", ") + text + " with --unit " + unit.name;
    if (length * unit.length >= shortest_organ && length * unit.length <= longest_organ)
      likely.push_back({unit.name, unit.length,
                        "guessed: it is " + text +
                            " long then, and no size for an organ in any other unit; --unit sets "
                            "another"});
  }
  if (!(length > shortest_number && length < longest_number))
    throw InputError({file}, format("%.3g long, which is no organ in mm, cm or m", length),
                     "the file is damaged, or no surface of an organ: export it again");
  if (!absurd.empty())
    throw InputError({file}, "in " + asked + " this would be " + absurd + " long", "it would be " + lengths);
  if (!asked.empty()) throw InputError({}, inQuotes(asked) + " is not a unit", "give --unit mm, cm or m");
  // A file of centimetres is rare: one of that size may as well have no unit at all.
  if (likely.size() == 1 && likely.front().name != "cm") return likely.front();
  throw InputError({file}, format("%.4g long, and the file does not say in which unit", length),
                   "say it: the organ is " + lengths);
}

}  // namespace palpate::tools
