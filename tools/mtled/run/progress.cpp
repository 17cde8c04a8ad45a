#include "mtled/run/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "base/number_text.h"
#include "base/printable_text.h"

namespace palpate::tools {
namespace {

std::string timeText(double seconds) {
  return seconds < 90 ? format("%.0f s", seconds) : format("%.0f min", seconds / 60);
}

}  // namespace

ProgressLine::ProgressLine(std::string task) : task_(std::move(task)), terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressLine::~ProgressLine() {
  if (terminal_) std::fprintf(stderr, "\r\033[K");
}

void ProgressLine::show(double fraction, const std::string& detail) {
  fraction = std::clamp(fraction, 0.0, 1.0);
  const auto now = Clock::now();
  const int tenth = static_cast<int>(fraction * 10);
  if (terminal_ ? now - shown_ < std::chrono::milliseconds(200) : tenth == tenth_) return;
  shown_ = now;
  tenth_ = tenth;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  // An estimate from less than a second or a hundredth of the work would only jump about.
  const std::string left =
      elapsed > 1 && fraction > 0.01 ? ", " + timeText(elapsed * (1 - fraction) / fraction) + " left" : "";
  if (terminal_) {
    std::string bar(20, '.');
    std::fill_n(bar.begin(), static_cast<int>(fraction * 20), '#');
    std::fprintf(stderr, "\r\033[K%s [%s] %3.0f %%  %s%s", task_.c_str(), bar.c_str(), fraction * 100, detail.c_str(),
                 left.c_str());
    std::fflush(stderr);
  } else {
    std::fprintf(stderr, "%s: %3.0f %%, %s%s\n", task_.c_str(), fraction * 100, detail.c_str(), left.c_str());
  }
}

void warn(const std::string& line) {
  std::fprintf(stderr, "%smtled: warning: %s\n", isatty(STDERR_FILENO) != 0 ? "\r\033[K" : "", printable(line).c_str());
}

}  // namespace palpate::tools
