#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdint>
#include <thread>
#include <vector>

#include "realtime/channels/snapshot_buffer.h"
#include "realtime/channels/spsc_ring.h"
#include "realtime/channels/triple_buffer.h"

using namespace palpate;

TEST_CASE("A triple buffer's reader gets the newest value, and keeps it", "[triple_buffer]") {
  TripleBuffer<int> buffer(0);
  CHECK_FALSE(buffer.hasNews());
  CHECK(buffer.latest() == 0);
  buffer.back() = 1;
  buffer.publish();
  buffer.back() = 2;
  buffer.publish();
  CHECK(buffer.hasNews());
  const int& held = buffer.latest();
  CHECK(held == 2);
  CHECK_FALSE(buffer.hasNews());
  for (int k = 3; k < 10; ++k) {  // the writer goes on and never touches the slot held
    buffer.back() = k;
    buffer.publish();
    REQUIRE(held == 2);
  }
  CHECK(buffer.latest() == 9);
  CHECK(buffer.latest() == 9);
}

TEST_CASE("Across two threads, values are whole and never go back", "[triple_buffer]") {
  using Block = std::array<std::int64_t, 64>;
  TripleBuffer<Block> buffer(Block{});
  std::atomic<bool> enough{false};
  std::thread writer([&] {
    for (std::int64_t k = 1; !enough; ++k) {
      buffer.back().fill(k);
      buffer.publish();
      if (k % 1024 == 0) std::this_thread::yield();
    }
  });
  std::int64_t before = 0, torn = 0, backwards = 0, seen = 0;
  while (seen < 5000) {
    const Block& block = buffer.latest();
    for (const std::int64_t value : block) torn += value != block[0];
    backwards += block[0] < before;
    if (block[0] == before) {
      std::this_thread::yield();
    } else {
      ++seen;
    }
    before = block[0];
  }
  enough = true;
  writer.join();
  CHECK(torn == 0);
  CHECK(backwards == 0);
}

TEST_CASE("A snapshot buffer has memory in all of its slots", "[snapshot_buffer]") {
  SnapshotBuffer buffer(makeSnapshot(7, 5));
  for (int k = 0; k < 4; ++k) {
    REQUIRE(buffer.back().u.size() == 7);
    REQUIRE(buffer.back().contact_vertex.size() == 5);
    REQUIRE(buffer.back().contact_force.size() == 5);
    buffer.publish();
  }
  CHECK(buffer.latest().u.size() == 7);
}

TEST_CASE("A ring is first in, first out, and says when it is full or empty", "[spsc_ring]") {
  SpscRing<int> ring(5);
  CHECK(ring.capacity() == 8);
  int value = 0;
  for (int round = 0; round < 20; ++round) {
    CHECK_FALSE(ring.pop(value));
    for (int i = 0; i < 8; ++i) REQUIRE(ring.push(100 * round + i));
    CHECK_FALSE(ring.push(-1));
    CHECK(ring.size() == 8);
    for (int i = 0; i < 8; ++i) {
      REQUIRE(ring.pop(value));
      REQUIRE(value == 100 * round + i);
    }
  }
}

TEST_CASE("Across two threads, a ring loses, doubles and reorders nothing", "[spsc_ring]") {
  struct Entry {
    std::int64_t number = 0, twice = 0;
  };
  SpscRing<Entry> ring(64);
  constexpr std::int64_t count = 200'000;
  std::thread producer([&] {
    for (std::int64_t k = 0; k < count;) {
      if (ring.push({k, 2 * k})) {
        ++k;
      } else {
        std::this_thread::yield();
      }
    }
  });
  std::int64_t wrong = 0;
  Entry entry;
  for (std::int64_t k = 0; k < count;) {
    if (!ring.pop(entry)) {
      std::this_thread::yield();
      continue;
    }
    wrong += entry.number != k || entry.twice != 2 * k;
    ++k;
  }
  producer.join();
  CHECK(wrong == 0);
  CHECK(ring.size() == 0);
}
