#include "app/run/session_loader.h"

#include <stdexcept>
#include <utility>

namespace palpate::app {

SessionLoader::SessionLoader(Log& log) : log_(log), thread_([this] { work(); }) {}

SessionLoader::~SessionLoader() {
  cancel();
  {
    const std::lock_guard lock(mutex_);
    end_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void SessionLoader::begin(const Options& options, const Scene& scene) {
  cancelled_ = false;
  {
    const std::lock_guard lock(mutex_);
    options_ = options;
    scene_ = scene;
    progress_ = {};
    error_ = nullptr;
    busy_ = true;
  }
  changed_.notify_all();
}

SessionLoader::Progress SessionLoader::progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
}

bool SessionLoader::busy() const {
  const std::lock_guard lock(mutex_);
  return busy_;
}

std::unique_ptr<Session> SessionLoader::take() {
  const std::lock_guard lock(mutex_);
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
  return std::move(session_);
}

void SessionLoader::work() {
  for (;;) {
    std::optional<Options> options;
    std::optional<Scene> scene;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return end_ || options_; });
      if (end_) return;
      options = std::exchange(options_, {});
      scene = std::exchange(scene_, {});
    }
    std::unique_ptr<Session> session;
    std::exception_ptr error;
    try {
      session = std::make_unique<Session>(*options, *scene, log_, [this](const std::string& stage, double fraction) {
        if (cancelled_) throw std::runtime_error("given up while the model was made");
        const std::lock_guard lock(mutex_);
        progress_ = {stage, fraction};
      });
      session->start();
    } catch (...) {
      error = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    session_ = std::move(session);
    error_ = error;
    busy_ = false;
  }
}

}  // namespace palpate::app
