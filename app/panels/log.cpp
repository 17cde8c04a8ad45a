#include "app/panels/log.h"

#include <iostream>
#include <utility>

#include "base/printable_text.h"

namespace palpate::app {

namespace {
constexpr std::size_t max_lines = 500;  // the panel shows the newest; the terminal has them all
}  // namespace

void Log::add(LogLevel level, const std::string& text) {
  if (!lines_.empty() && lines_.back().level == level && last_text_ == text) {
    ++repeats_;
    lines_.back().text = text + " (" + std::to_string(repeats_ + 1) + " times)";
    return;
  }
  last_text_ = text;
  keep({{}, level, text}, text);
}

void Log::add(LogLevel level, double run_s, const std::string& text, const std::string& printed) {
  last_text_.clear();
  keep({run_s, level, text}, printed);
}

void Log::keep(LogLine line, const std::string& printed) {
  repeats_ = 0;
  const LogLevel level = line.level;
  if (lines_.size() >= max_lines) lines_.erase(lines_.begin(), lines_.begin() + max_lines / 2);
  lines_.push_back(std::move(line));
  std::ostream& out = level <= LogLevel::Info ? std::cout : std::cerr;
  out << (level == LogLevel::Error     ? "error: "
          : level == LogLevel::Warning ? "warning: "
                                       : "")
      << printable(printed, LineEnds::Keep) << std::endl;
}

}  // namespace palpate::app
