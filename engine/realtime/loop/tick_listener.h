#pragma once

namespace palpate {

/// Told of each tick on the thread that has done it, once its force is out. Real-time where the loop is: no allocation,
/// no lock, no throw.
class TickListener {
 public:
  virtual ~TickListener() = default;
  virtual void afterTick() = 0;
};

}  // namespace palpate
