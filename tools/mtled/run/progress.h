#pragma once

#include <chrono>
#include <string>

namespace palpate::tools {

/// One line on stderr that says how far a long task is and how long it will still take. Rewritten in place on a
/// terminal, at most five times a second; elsewhere a new line at each tenth.
class ProgressLine {
 public:
  explicit ProgressLine(std::string task);
  ~ProgressLine();

  /// @param fraction  0 .. 1 of the task; @param detail  what is being done, short
  void show(double fraction, const std::string& detail);

 private:
  using Clock = std::chrono::steady_clock;
  std::string task_;
  bool terminal_;
  Clock::time_point start_ = Clock::now(), shown_{};
  int tenth_ = -1;
};

/// A line on stderr with what went otherwise than meant, over a progress line.
void warn(const std::string& line);

}  // namespace palpate::tools
