#include "app/panels/log.h"

#include <chrono>
#include <iostream>

#include "base/printable_text.h"

namespace palpate::app {

namespace {
const auto program_start = std::chrono::steady_clock::now();
constexpr std::size_t max_lines = 500;  // the panel shows the newest; the terminal has them all
}  // namespace

void Log::add(LogLevel level, const std::string& text) {
  const double now = std::chrono::duration<double>(std::chrono::steady_clock::now() - program_start).count();
  if (!lines_.empty() && lines_.back().level == level && last_text_ == text) {
    ++repeats_;
    lines_.back().text = text + " (" + std::to_string(repeats_ + 1) + " times)";
    lines_.back().wall_s = now;
    return;
  }
  repeats_ = 0;
  last_text_ = text;
  if (lines_.size() >= max_lines) lines_.erase(lines_.begin(), lines_.begin() + max_lines / 2);
  lines_.push_back({now, level, text});
  std::ostream& out = level == LogLevel::Info ? std::cout : std::cerr;
  out << (level == LogLevel::Error     ? "error: "
          : level == LogLevel::Warning ? "warning: "
                                       : "")
      << printable(text, LineEnds::Keep) << std::endl;
}

}  // namespace palpate::app
