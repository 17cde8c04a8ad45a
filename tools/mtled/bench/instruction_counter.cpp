#include "mtled/bench/instruction_counter.h"

#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace palpate::tools {

InstructionCounter::InstructionCounter() {
  perf_event_attr attr{};
  attr.size = sizeof attr;
  attr.type = PERF_TYPE_HARDWARE;
  attr.config = PERF_COUNT_HW_INSTRUCTIONS;
  attr.exclude_kernel = attr.exclude_hv = 1;
  file_ = static_cast<int>(syscall(SYS_perf_event_open, &attr, 0, -1, -1, 0));
  if (file_ < 0) reason_ = std::strerror(errno);
}

InstructionCounter::~InstructionCounter() {
  if (file_ >= 0) close(file_);
}

std::int64_t InstructionCounter::count() const {
  std::int64_t value = 0;
  return file_ >= 0 && read(file_, &value, sizeof value) == sizeof value ? value : 0;
}

}  // namespace palpate::tools
