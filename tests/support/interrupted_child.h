#pragma once

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>

#include "base/interrupt.h"
#include "support/realtime_guard.h"

namespace palpate::test {

/// The exit code of `action` in a child that is interrupted (SIGINT) once `file` exists; 99 where it throws.
/// In a child, because the flag that a signal sets is never taken back.
template <class Action>
int codeWhenInterrupted(const std::string& file, Action&& action) {
  return exitCodeOfChild([&] {
    catchInterrupts();
    std::thread([file] {
      while (!std::filesystem::exists(file)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      std::raise(SIGINT);
    }).detach();
    try {
      return action();
    } catch (...) {
      return 99;
    }
  });
}

}  // namespace palpate::test
