#include <sched.h>
#include <unistd.h>

#include <atomic>

#include "api/border.h"
#include "api/handles.h"
#include "base/spin_team.h"

using namespace palpate;
using namespace palpate::api;

struct palpate_team {
  explicit palpate_team(int threads) : team(threads) {}
  SpinTeam team;
  int process = getpid();
};

namespace {

constexpr std::int32_t max_simulations = 65535;  // parts of a SpinTeam's job

int allowedCores() {
  cpu_set_t cores;
  return sched_getaffinity(0, sizeof cores, &cores) == 0 ? std::clamp(CPU_COUNT(&cores), 1, max_threads) : 1;
}

/// Throws what is wrong with the entry of that number.
struct Entry {
  std::int32_t k;
  std::int32_t code = PALPATE_BAD_ARGUMENT;
  [[noreturn]] void refuse(const std::string& what) const {
    throw Refusal(code, "simulation " + std::to_string(k) + ": " + what);
  }
};

palpate_state* stateAt(palpate_state* states, std::int32_t k) {  // by the caller's size of one
  char* const first = reinterpret_cast<char*>(states);
  return reinterpret_cast<palpate_state*>(first + static_cast<std::size_t>(k) * states->size);
}

void check(palpate_simulation* const* simulations, std::int32_t count, const double* poses, palpate_state* states) {
  if (states != nullptr && count > 0 && (!isSize(states->size) || states->size % alignof(palpate_state) != 0))
    Entry{0}.refuse("a state whose size is not sizeof it");
  std::vector<std::pair<palpate_simulation*, std::int32_t>> seen;
  for (std::int32_t k = 0; k < count; ++k) {
    palpate_simulation* const simulation = simulations[k];
    if (simulation == nullptr) Entry{k}.refuse("it is NULL");
    if (isInTickCall(*simulation)) Entry{k, PALPATE_REFUSED}.refuse("this is a call of its own tick");
    if (simulation->running) Entry{k, PALPATE_BUSY}.refuse("it runs on its own thread; stop it first");
    if (poses != nullptr && !isPose(poses + 7 * k)) Entry{k}.refuse("its pose is none");
    if (poses != nullptr && simulation->coupling) Entry{k, PALPATE_REFUSED}.refuse("a device has its tool");
    if (states != nullptr && stateAt(states, k)->size != states->size) Entry{k}.refuse("its state has another size");
    seen.emplace_back(simulation, k);
  }
  std::sort(seen.begin(), seen.end());
  for (std::size_t k = 1; k < seen.size(); ++k)
    if (seen[k].first == seen[k - 1].first)
      Entry{seen[k].second}.refuse("it is that of " + std::to_string(seen[k - 1].second) + ", too");
}

}  // namespace

extern "C" {

int32_t palpate_team_create(int32_t threads, palpate_team** team, palpate_error* error) {
  if (team != nullptr) *team = nullptr;
  if (const std::int32_t code = nullAmong(error, {{team, "team"}})) return code;
  if (const std::int32_t code = sayToo(error, outside("threads", threads, 0, max_threads + 1))) return code;
  return guarded(error, [&] {
    *team = new palpate_team(threads > 0 ? threads : allowedCores());
    return PALPATE_OK;
  });
}

void palpate_team_destroy(palpate_team* team) {
  if (team != nullptr && team->process == getpid()) delete team;  // else its threads are the parent's
}

int32_t palpate_step_many(palpate_team* team, palpate_simulation* const* simulations, int32_t count, int64_t n,
                          const double* poses, palpate_state* states, palpate_error* error) {
  if (count < 0 || count > max_simulations || n < 0 || (simulations == nullptr && count > 0))
    return say(error, PALPATE_BAD_ARGUMENT, "simulations is NULL, n negative, or count not in 0 .. 65535");
  return guarded(error, [&] {
    check(simulations, count, poses, states);
    std::atomic<bool> failed{false};
    const auto one = [&](int k) {
      const double* const pose = poses != nullptr ? poses + 7 * k : nullptr;
      if (palpate_step(simulations[k], n, pose, nullptr) != PALPATE_OK) failed = true;
    };
    if (team != nullptr && team->process == getpid())
      shareOut(team->team, count, one);
    else
      for (std::int32_t k = 0; k < count; ++k) one(k);
    for (std::int32_t k = 0; states != nullptr && k < count; ++k) palpate_read(simulations[k], stateAt(states, k));
    return failed ? refuse(PALPATE_FAILED, "a simulation could not be stepped") : PALPATE_OK;
  });
}

}  // extern "C"
