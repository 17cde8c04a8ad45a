#include "realtime/timing/resource_use.h"

#include <fstream>
#include <sstream>
#include <string>

namespace palpate {
namespace {

constexpr std::int64_t kBytesPerKb = 1024;

/// The number after `key` in a file of lines "key: number", 0 where there is none.
std::int64_t valueOf(const std::string& file, const std::string& key) {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(key)) continue;
    std::int64_t value = 0;
    std::istringstream(line.substr(key.size())) >> value;
    return value;
  }
  return 0;
}

}  // namespace

ThreadCounters ThreadCounters::operator-(const ThreadCounters& before) const {
  return {minor_faults - before.minor_faults, major_faults - before.major_faults,
          voluntary_switches - before.voluntary_switches, involuntary_switches - before.involuntary_switches};
}

ThreadCounters readThreadCounters(int thread_id) {
  const std::string folder = "/proc/self/task/" + std::to_string(thread_id);
  ThreadCounters counters;
  std::ifstream stat(folder + "/stat");
  std::string text;
  if (!std::getline(stat, text)) return counters;
  // The name, in parentheses, may hold anything: the fields begin after its last one. proc(5): minflt is
  // field 10 and majflt 12; the first after the name is 3.
  std::istringstream fields(text.substr(text.rfind(')') + 1));
  std::string skipped;
  for (int field = 3; field < 10; ++field) fields >> skipped;
  fields >> counters.minor_faults >> skipped >> counters.major_faults;
  counters.voluntary_switches = valueOf(folder + "/status", "voluntary_ctxt_switches:");
  counters.involuntary_switches = valueOf(folder + "/status", "nonvoluntary_ctxt_switches:");
  return counters;
}

MemoryUse readMemoryUse() {
  const std::string file = "/proc/self/smaps_rollup";
  return {kBytesPerKb * valueOf(file, "Rss:"), kBytesPerKb * valueOf(file, "Anonymous:")};
}

}  // namespace palpate
