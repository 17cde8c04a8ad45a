#include "mtled/bench/machine_ceilings.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <memory>

#include "base/number_text.h"
#include "base/parallel_for.h"
#include "base/spin_team.h"
#include "base/types.h"
#include "mtled/bench/timing.h"

namespace palpate::tools {
namespace {

// Twelve chains cover the latency of two multiply-add units (2 x 4 or 5 cycles) and fit into 16 registers.
constexpr int chains = 12;

/// v = v x + y in all lanes of all chains, so many times. Inlined into a function of each instruction set.
template <int bytes, bool fused>
[[gnu::always_inline]] inline void multiplyAdd(long rounds) {
  typedef float Vector __attribute__((vector_size(bytes)));      // NOLINT: `using` drops the attribute here
  Vector x = Vector{} + 0.75F, y = Vector{} + 0.25F, v[chains];  // tends to 1: no overflow, no denormals
  asm volatile("" : "+m"(x), "+m"(y));                           // not constants to the compiler
  for (int k = 0; k < chains; ++k) v[k] = Vector{} + static_cast<float>(k);
  for (long i = 0; i < rounds; ++i) {
#pragma GCC unroll 12
    for (int k = 0; k < chains; ++k) {
      Vector product = v[k] * x;
#if defined(__x86_64__)
      if constexpr (!fused) asm("" : "+x"(product));  // the compiler may not fuse what it can't see through
#endif
      v[k] = product + y;
    }
  }
  for (const Vector& chain : v) asm volatile("" : : "m"(chain));  // used, as far as the compiler knows
}

/// Sums `count` floats, a multiple of 128, front to back, asking for what is 2 KB ahead as the hot kernel does.
template <int bytes>
[[gnu::always_inline]] inline void readForward(const float* a, std::size_t count) {
  typedef float Vector __attribute__((vector_size(bytes)));  // NOLINT
  constexpr int lanes = bytes / 4, streams = 8;
  Vector sum[streams] = {};
  for (std::size_t i = 0; i < count; i += streams * lanes) {
#pragma GCC unroll 8
    for (int k = 0; k < streams; ++k) {
      if (k * lanes % 16 == 0) __builtin_prefetch(a + i + k * lanes + 512);
      Vector v;
      std::memcpy(&v, __builtin_assume_aligned(a + i + k * lanes, bytes), sizeof v);
      sum[k] += v;
    }
  }
  for (const Vector& stream : sum) asm volatile("" : : "m"(stream));
}

void multiplyAddPlain(long rounds) { multiplyAdd<16, false>(rounds); }
void readPlain(const float* a, std::size_t count) { readForward<16>(a, count); }
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] void multiplyAddAvx2(long rounds) { multiplyAdd<32, true>(rounds); }
[[gnu::target("avx512f")]] void multiplyAddAvx512(long rounds) { multiplyAdd<64, true>(rounds); }
[[gnu::target("avx2,fma")]] void readAvx2(const float* a, std::size_t count) { readForward<32>(a, count); }
[[gnu::target("avx512f")]] void readAvx512(const float* a, std::size_t count) { readForward<64>(a, count); }
#endif

struct Loops {
  void (*multiply_add)(long);
  void (*read)(const float*, std::size_t);
  int lanes;
};

Loops loopsOf(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::Avx512) return {multiplyAddAvx512, readAvx512, 16};
  if (set == InstructionSet::Avx2) return {multiplyAddAvx2, readAvx2, 8};
#endif
  return {multiplyAddPlain, readPlain, 4};
}

constexpr long fma_rounds = 100000;          // 0.1 to 1 ms
constexpr std::size_t floats_at_once = 128;  // what readForward takes in one turn at the widest

/// What one thread reads in one pass, and how often it does so in one timed round.
struct Reading {
  std::size_t floats = 0;
  int passes = 1;
};

Reading readingOf(std::size_t bytes, int threads) {
  Reading r;
  r.floats = std::max<std::size_t>(1, bytes / sizeof(float) / threads / floats_at_once) * floats_at_once;
  constexpr std::size_t round_bytes = 16 << 20;  // about a millisecond from a cache
  r.passes = static_cast<int>(std::max<std::size_t>(1, round_bytes / threads / (r.floats * sizeof(float))));
  return r;
}

struct LevelPlan {
  MemoryLevel level;
  Reading reading;
};

/// Working sets that lie well inside each level and well outside the one before it.
std::vector<LevelPlan> planLevels(const Machine& machine, int threads) {
  constexpr std::size_t assumed_cache = 32 << 20;  // where no size is known
  const std::size_t l2 = machine.l2_bytes * threads, l3 = machine.l3_bytes;
  std::vector<LevelPlan> plan;
  if (l2 > 0) plan.push_back({{"L2", l2, 0}, readingOf(l2 / 2, threads)});
  if (l3 > 2 * l2) plan.push_back({{"L3", l3, 0}, readingOf(std::min(std::max(l3 / 4, 2 * l2), l3 / 4 * 3), threads)});
  plan.push_back({{"DRAM", 0, 0}, readingOf(4 * std::max({l2, l3, assumed_cache / 2}), threads)});
  return plan;
}

/// Runs each(member) on all threads at once.
template <class Each>
void onAll(SpinTeam& team, Each& each) {
  team.run([](void* context, int member, int) { (*static_cast<Each*>(context))(member); }, &each);
}

}  // namespace

InstructionSet compiledInstructionSet() {
#if defined(__AVX512F__)
  return InstructionSet::Avx512;
#elif defined(__AVX2__)
  return InstructionSet::Avx2;
#else
  return InstructionSet::Plain;
#endif
}

Machine thisMachine() {
  Machine machine;
  machine.processor = "unknown";
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos) {
      machine.processor = line.substr(line.find(": ") + 2);
      break;
    }
  cpu_set_t allowed;
  machine.cores = sched_getaffinity(0, sizeof allowed, &allowed) == 0 ? CPU_COUNT(&allowed) : threadsOr(0);
  for (int k = 0; k < 8; ++k) {
    const std::string folder = format("/sys/devices/system/cpu/cpu0/cache/index%d/", k);
    int level = 0;
    std::size_t kib = 0;  // the kernel always writes "1024K"
    if (!(std::ifstream(folder + "level") >> level) || !(std::ifstream(folder + "size") >> kib)) continue;
    if (level == 2) machine.l2_bytes = kib << 10;
    if (level == 3) machine.l3_bytes = kib << 10;
  }
  const auto orAsked = [](std::size_t& bytes, int name) {
    if (bytes == 0) bytes = static_cast<std::size_t>(std::max(0L, sysconf(name)));
  };
  orAsked(machine.l2_bytes, _SC_LEVEL2_CACHE_SIZE);
  orAsked(machine.l3_bytes, _SC_LEVEL3_CACHE_SIZE);
  return machine;
}

double Ceilings::mostGflops() const { return *std::max_element(fma_gflops.begin(), fma_gflops.end()); }

const MemoryLevel& Ceilings::levelOf(double bytes) const {
  for (const MemoryLevel& level : levels)
    if (level.capacity == 0 || bytes <= static_cast<double>(level.capacity)) return level;
  return levels.back();
}

std::vector<Ceilings> measureCeilings(const Machine& machine, const std::vector<int>& thread_counts, double seconds) {
  const auto sets = supportedInstructionSets();
  const Loops widest = loopsOf(sets.back());
  std::vector<std::vector<LevelPlan>> plans;
  std::size_t max_floats = 0;
  for (const int threads : thread_counts) {
    plans.push_back(planLevels(machine, threads));
    for (const auto& plan : plans.back()) max_floats = std::max(max_floats, plan.reading.floats * threads);
  }
  const AlignedVector<float> memory(max_floats, 1.0F);

  // One row per figure, in the order in which they are read back below.
  std::vector<std::unique_ptr<SpinTeam>> teams;
  std::vector<TimedCall> calls;
  for (std::size_t t = 0; t < thread_counts.size(); ++t) {
    teams.push_back(std::make_unique<SpinTeam>(thread_counts[t]));
    SpinTeam* team = teams.back().get();
    for (const InstructionSet set : sets)
      calls.push_back({team, [team, loop = loopsOf(set).multiply_add] {
                         auto each = [loop](int) { loop(fma_rounds); };
                         onAll(*team, each);
                       }});
    for (const LevelPlan& plan : plans[t])
      calls.push_back({team, [team, reading = plan.reading, read = widest.read, from = memory.data()] {
                         auto each = [&](int member) {
                           for (int pass = 0; pass < reading.passes; ++pass)
                             read(from + reading.floats * member, reading.floats);
                         };
                         onAll(*team, each);
                       }});
  }
  timeInTurns(calls, seconds);

  std::vector<Ceilings> all;
  std::size_t row = 0;
  for (std::size_t t = 0; t < thread_counts.size(); ++t) {
    const double threads = thread_counts[t];
    Ceilings c;
    c.threads = thread_counts[t];
    c.fma_gflops.assign(static_cast<std::size_t>(InstructionSet::Avx512) + 1, 0);
    for (const InstructionSet set : sets) {
      const double flops = 2.0 * fma_rounds * chains * loopsOf(set).lanes * threads;
      c.fma_gflops[static_cast<std::size_t>(set)] = flops / calls[row++].best() * 1e-9;
    }
    for (const LevelPlan& plan : plans[t]) {
      const double bytes = static_cast<double>(plan.reading.floats) * sizeof(float) * plan.reading.passes * threads;
      c.levels.push_back(plan.level);
      c.levels.back().gb_per_s = bytes / calls[row++].best() * 1e-9;
    }
    all.push_back(std::move(c));
  }
  return all;
}

}  // namespace palpate::tools
