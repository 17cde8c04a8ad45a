#pragma once

#include <optional>
#include <string>
#include <vector>

namespace palpate::app {

enum class LogLevel { Detail, Info, Warning, Error };  // Detail: for engineers

struct LogLine {
  std::optional<double> run_s;  // of the run; without: the program's own, before or beside it
  LogLevel level = LogLevel::Info;
  std::string text;
};

/// Messages for the Log panel and the terminal. Belongs to the main thread.
class Log {
 public:
  /// Keeps the line and prints it: warnings and errors to stderr, the rest to stdout.
  /// A line equal to the one before is counted instead of repeated.
  void add(LogLevel level, const std::string& text);
  /// The same for what happened in the run at a time, s. @param printed  for the terminal, where it says more
  void add(LogLevel level, double run_s, const std::string& text, const std::string& printed);
  void detail(const std::string& text) { add(LogLevel::Detail, text); }
  void info(const std::string& text) { add(LogLevel::Info, text); }
  void warning(const std::string& text) { add(LogLevel::Warning, text); }
  void error(const std::string& text) { add(LogLevel::Error, text); }

  const std::vector<LogLine>& lines() const { return lines_; }

 private:
  void keep(LogLine line, const std::string& printed);

  std::vector<LogLine> lines_;
  std::string last_text_;
  int repeats_ = 0;
};

}  // namespace palpate::app
