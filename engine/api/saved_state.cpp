#include <algorithm>

#include "api/border.h"
#include "api/handles.h"
#include "base/build_info.h"
#include "base/key.h"
#include "model/live_parameters.h"
#include "model/model_hash.h"

using namespace palpate;
using namespace palpate::api;

namespace {

struct Header {
  char magic[8] = {'P', 'A', 'L', 'P', 'S', 'A', 'V', '1'};
  std::uint64_t build = 0;  // hash of sources and compiler: the bytes are those of its structs
  std::uint64_t model = 0;  // modelHash
  std::uint64_t size = 0;   // of all bytes
  std::uint64_t sum = 0;    // of those after the header
};

/// What of the state changes but for the live settings, in the order of the bytes. What each tick makes anew is
/// left out.
template <class SomeState, class Call>
void forEachPart(SomeState& s, Call call) {
  const auto one = [&call](auto& value) { call(&value, sizeof value); };
  const auto list = [&call](auto& values) { call(values.data(), values.size() * sizeof values[0]); };
  one(s.tick), one(s.step);
  list(s.u), list(s.du), list(s.u_low);
  const auto contact = [&](auto& c) {
    one(c.count), list(c.vertex), list(c.force), list(c.normal), list(c.side);
    one(c.overflow), one(c.max_penetration), one(c.contact_count);
    auto& f = c.samples;
    one(f.count), list(f.id), list(f.force), list(f.normal), list(f.side), list(f.point), list(f.area), list(f.lift);
    one(f.longest_edge), one(f.largest_stretch);
  };
  list(s.tool);
  for (auto& body : s.contact) contact(body);
  one(s.skins.count), list(s.skins.vertex), list(s.skins.face), list(s.skins.clearance), list(s.skins.force);
  one(s.skins.calm), one(s.skins.travel), one(s.skins.since_calm), list(s.skins.moved), list(s.skins.unseen);
  list(s.rigid.force), list(s.rigid.normal);
  list(s.relaxation.Z);
  list(s.local_mass.factor), one(s.local_mass.active), one(s.local_mass.momentum), one(s.local_mass.force);
  one(s.energy);
  one(s.live.friction), one(s.live.loads), one(s.region_shift);
}

std::size_t sizeOf(const palpate_simulation& simulation) {
  std::size_t size =
      sizeof(Header) + sizeof(RunMemory) + simulation.materials.size() * sizeof(Material) + sizeof(std::uint64_t);
  const State& state = simulation.physics.state();
  forEachPart(state, [&](const void*, std::size_t bytes) { size += bytes; });
  if (simulation.following) {  // the same at all places: with room for all nodes, and what any points remember
    const std::size_t of_node = 3 * sizeof(Float4) + sizeof(float);  // u, du, u_low; added mass
    const Places& places = simulation.following->places();
    const auto nodes = static_cast<std::size_t>(places.nodeCount());
    size += sizeof(PlaceIndex) + (nodes - state.u.size()) * of_node +
            (places.mostRemembered(state) - state.relaxation.Z.size()) * sizeof(float);
  }
  return size;
}

std::uint64_t buildHash() { return fnv1a(sourceIdentity() + buildInfo()); }

std::uint64_t sumOf(const char* bytes, std::size_t size) {
  return fnv1a({bytes + sizeof(Header), size - sizeof(Header)});
}

/// Plain data, though Eigen's vectors do not say so.
template <class T>
void take(const char*& from, T& value) {
  std::memcpy(static_cast<void*>(&value), from, sizeof value);
  from += sizeof value;
}

/// Where the saved bytes say, and waits for it. Throws Refusal where that can't be.
void goToPlace(palpate_simulation& simulation, const char*& at) {
  PlaceIndex place;
  take(at, place);
  if (place == simulation.physics.place()->place.index) return;
  const std::int32_t code = send(simulation, Request::goToPlace(place));
  if (code != PALPATE_OK || simulation.physics.place()->place.index != place)
    throw Refusal(PALPATE_REFUSED, "the nodes for where the tool was can't be made again");
}

}  // namespace

extern "C" {

size_t palpate_save_size(const palpate_simulation* simulation) {
  return simulation != nullptr ? sizeOf(*simulation) : 0;
}

int32_t palpate_save(const palpate_simulation* simulation, void* bytes, size_t size) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}, {bytes, "bytes"}})) return code;
  if (const std::size_t needed = palpate_save_size(simulation); size != needed)
    return refuse(PALPATE_BAD_ARGUMENT, "size is %zu, and palpate_save_size() %zu", size, needed);
  if (!simulation->standsStill()) return simulation->busy();
  return guarded(nullptr, [&] {
    char* const begin = static_cast<char*>(bytes);
    char* at = begin + sizeof(Header);
    const auto put = [&at](const void* part, std::size_t length) {
      if (length > 0) std::memcpy(at, part, length);
      at += length;
    };
    const RunMemory memory = simulation->loop.memory();
    put(&memory, sizeof memory);
    put(&simulation->step_sequence, sizeof simulation->step_sequence);
    const State& state = simulation->physics.state();
    if (simulation->following) put(&state.place, sizeof state.place);
    put(state.live.kernel.materials.data(), state.live.kernel.materials.size() * sizeof(Material));
    forEachPart(state, put);
    std::fill(at, begin + size, '\0');
    Header header;
    header.build = buildHash();
    header.model = modelHash(*simulation->model);
    header.size = size;
    header.sum = sumOf(begin, size);
    std::memcpy(begin, &header, sizeof header);
    return PALPATE_OK;
  });
}

int32_t palpate_restore(palpate_simulation* simulation, const void* bytes, size_t size, palpate_error* error) {
  if (const std::int32_t code = nullAmong(error, {{simulation, "simulation"}, {bytes, "bytes"}})) return code;
  if (const int32_t code = simulation->whyNot()) return say(error, code, palpate_last_error());
  return guarded(error, [&] {
    const char* at = static_cast<const char*>(bytes);
    Header header;
    const Header right;
    if (size >= sizeof header) std::memcpy(static_cast<void*>(&header), bytes, sizeof header);
    if (size < sizeof header || std::memcmp(header.magic, right.magic, sizeof right.magic) != 0)
      throw Refusal(PALPATE_BAD_INPUT, "these are no bytes of palpate_save");
    if (header.build != buildHash())
      throw Refusal(PALPATE_BAD_INPUT, "the state was saved by another build of the library; run it anew");
    if (header.model != modelHash(*simulation->model))
      throw Refusal(PALPATE_BAD_INPUT,
                    "the state was saved of another model: load its scene, with the same rate and settings");
    if (header.size != size)
      throw Refusal(PALPATE_BAD_INPUT, "the saved state is damaged: it had " + std::to_string(header.size) +
                                           " bytes, and these are " + std::to_string(size));
    if (size != sizeOf(*simulation) || header.sum != sumOf(at, size))
      throw Refusal(PALPATE_BAD_INPUT, "the saved state is damaged");

    if (simulation->recorder)
      throw Refusal(PALPATE_REFUSED, "a recording can't go on from a saved state; palpate_record_stop first");
    at += sizeof header;
    RunMemory memory;
    take(at, memory);
    std::uint64_t step_sequence = 0;
    take(at, step_sequence);
    if (simulation->following) goToPlace(*simulation, at);
    State state = simulation->physics.state();  // before anything changes: there may be no memory for it
    simulation->step_sequence = step_sequence;
    for (std::size_t m = 0; m < simulation->materials.size(); ++m) {
      take(at, simulation->materials[m]);
      setMaterial(simulation->present(), static_cast<int>(m), simulation->materials[m], state);
    }
    forEachPart(state, [&at](void* part, std::size_t length) {
      if (length > 0) std::memcpy(part, at, length);
      at += length;
    });
    state.rigid.lookAgain();
    simulation->loads = state.live.loads;
    simulation->physics.putIn(state);
    simulation->loop.recall(memory);
    return PALPATE_OK;
  });
}

int32_t palpate_hash(const palpate_simulation* simulation, uint64_t* hash) {
  if (const int32_t code = nullAmong({{simulation, "simulation"}, {hash, "hash"}})) return code;
  if (!simulation->standsStill()) return simulation->busy();
  return guarded(nullptr, [&] {
    *hash = simulation->physics.stateHash();
    return PALPATE_OK;
  });
}

}  // extern "C"
