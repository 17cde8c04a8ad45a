#pragma once

#include <cstdint>
#include <string>

namespace palpate::tools {

/// Counts the user-space instructions that the calling thread retires, by Linux's perf_event_open: the same number
/// on every run.
class InstructionCounter {
 public:
  InstructionCounter();
  ~InstructionCounter();
  InstructionCounter(const InstructionCounter&) = delete;
  InstructionCounter& operator=(const InstructionCounter&) = delete;

  bool available() const { return file_ >= 0; }
  /// Why it is not: virtual machines seldom have the counter. "" where it is.
  const std::string& reason() const { return reason_; }
  /// Instructions so far; 0 where it is not available.
  std::int64_t count() const;

 private:
  int file_ = -1;
  std::string reason_;
};

}  // namespace palpate::tools
