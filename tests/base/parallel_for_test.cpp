#include "base/parallel_for.h"

#include <catch2/catch.hpp>
#include <numeric>
#include <stdexcept>

using namespace palpate;

TEST_CASE("A watched set-up ends when the look throws, and is watched no longer than it wants", "[parallel_for]") {
  struct Ended {};
  for (const int threads : {1, 3}) {
    INFO(threads << " threads");
    setup_threads = threads;
    std::vector<std::atomic<int>> visits(80000);
    const int count = static_cast<int>(visits.size());
    const auto visited = [&] {
      for (auto& v : visits) v = 0;
      parallelFor(count, [&](int first, int last) {
        for (int k = first; k < last; ++k) ++visits[k];
      });
      return std::accumulate(visits.begin(), visits.end(), 0);
    };
    int looks = 0, looks_left = -1;  // before it throws; -1: never
    {
      const SetupWatch watch([&] {
        ++looks;
        if (looks_left-- == 0) throw Ended();
      });
      CHECK(visited() == count);
      CHECK(looks >= 1);
      looks_left = 0;
      CHECK_THROWS_AS(visited(), Ended);
      CHECK(visited() == count);  // one look that throws spoils nothing that comes after
    }
    const int before = looks;
    CHECK(visited() == count);
    CHECK(looks == before);
    setup_threads = 0;
  }
}

TEST_CASE("Once the look has thrown no other part is begun", "[parallel_for]") {
  setup_threads = 1;
  int looks = 0, done = 0;
  const SetupWatch watch([&] {
    if (++looks == 4) throw std::runtime_error("enough");
  });
  CHECK_THROWS_WITH(parallelFor(8000, [&](int first, int last) { done += last - first; }), "enough");
  CHECK(done == 3000);  // three of the eight parts that a thread's work is cut into
  setup_threads = 0;
}
