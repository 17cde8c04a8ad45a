#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "app/run/session.h"

namespace palpate::app {

/// Makes sessions on a thread of its own, so that a window can show how far the set-up is. The loops' threads are made
/// there, too: make the loader before the main thread takes its low priority, which threads inherit.
/// All functions belong to the main thread. While a session is being made the log is the loader's.
class SessionLoader {
 public:
  explicit SessionLoader(Log& log);
  ~SessionLoader();  // gives up what is under way
  SessionLoader(const SessionLoader&) = delete;
  SessionLoader& operator=(const SessionLoader&) = delete;

  /// Begins a session, which then runs, paused. Not while another is under way.
  void begin(const Options& options, const Scene& scene);

  struct Progress {
    std::string stage;
    double fraction = 0;
  };
  Progress progress() const;
  bool busy() const;

  /// The session that was begun, once busy() is false; throws what its making threw.
  std::unique_ptr<Session> take();

  /// Asks for an end; take() then throws.
  void cancel() { cancelled_ = true; }

 private:
  void work();

  Log& log_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool end_ = false, busy_ = false;
  std::atomic<bool> cancelled_{false};
  std::optional<Options> options_;
  std::optional<Scene> scene_;
  Progress progress_;
  std::unique_ptr<Session> session_;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace palpate::app
