#pragma once

#include <algorithm>
#include <exception>
#include <thread>
#include <vector>

namespace palpate {

/// Runs body(begin, end) over [0, count) in equal contiguous parts on all cores.
/// Set-up only. An exception of a part is rethrown here; of several, that of the
/// lowest part, so that the message does not depend on timing.
template <class Body>
void parallelFor(int count, Body&& body) {
  const int hardware = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int parts = std::max(1, std::min(hardware, count / 64));
  std::vector<std::exception_ptr> errors(parts);
  auto part = [&](int p) {
    try {
      body(static_cast<int>(static_cast<long long>(count) * p / parts),
           static_cast<int>(static_cast<long long>(count) * (p + 1) / parts));
    } catch (...) {
      errors[p] = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  for (int p = 1; p < parts; ++p) threads.emplace_back(part, p);
  part(0);
  for (auto& t : threads) t.join();
  for (auto& e : errors)
    if (e) std::rethrow_exception(e);
}

}  // namespace palpate
