#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <exception>
#include <initializer_list>
#include <stdexcept>
#include <string>

#include "api/palpate.h"
#include "base/input_error.h"
#include "base/printable_text.h"
#include "base/types.h"
#include "model/report.h"
#include "realtime/channels/command_queue.h"

namespace palpate::api {

/// Why a call is not done.
struct Refusal : std::runtime_error {
  Refusal(std::int32_t why, const std::string& text) : std::runtime_error(text), code(why) {}
  std::int32_t code;
};

/// Keeps why a call of this thread is not done, for palpate_last_error(). Allocates at most the first time in a thread,
/// where the system gives it its memory. @return code
std::int32_t refuse(std::int32_t code, const char* why, ...) __attribute__((format(printf, 2, 3)));

// What is wrong with an argument, kept likewise; PALPATE_OK: nothing.

struct Needed {
  const void* pointer;
  const char* name;
};
inline std::int32_t nullAmong(std::initializer_list<Needed> all) {
  for (const Needed& needed : all)
    if (needed.pointer == nullptr) return refuse(PALPATE_BAD_ARGUMENT, "%s is NULL", needed.name);
  return PALPATE_OK;
}
/// @param least, end  what it must be, `end` excluded
inline std::int32_t outside(const char* name, std::int32_t value, std::int32_t least, std::int32_t end) {
  if (value >= least && value < end) return PALPATE_OK;
  return refuse(PALPATE_BAD_ARGUMENT, "%s is %d, not in %d .. %d", name, value, least, end - 1);
}
inline std::int32_t otherThan(const char* name, std::int32_t value, std::size_t there) {
  if (value >= 0 && static_cast<std::size_t>(value) == there) return PALPATE_OK;
  return refuse(PALPATE_BAD_ARGUMENT, "%s is %d, and there are %zu", name, value, there);
}
std::int32_t placeProblem(const double* x, const char* what);
std::int32_t poseProblem(const double* pose, const char* what);

constexpr int max_threads = 64;  // of a simulation, or of a team

/// The number that callers know a doubt by.
inline std::int32_t numberOf(Doubt doubt) {
  if (doubt == Doubt::None) return PALPATE_DOUBT_NONE;
  if (doubt == Doubt::Resolution) return PALPATE_DOUBT_RESOLUTION;  // came last, and is the least
  return static_cast<std::int32_t>(doubt) - static_cast<std::int32_t>(Doubt::Volume) + PALPATE_DOUBT_VOLUME;
}

/// Whether a struct's size can be meant: one that was never set is 0 or anything.
inline bool isSize(std::uint32_t size) { return size >= 8 && size <= 4096; }
inline std::int32_t badSize(std::uint32_t size) {
  return refuse(PALPATE_BAD_ARGUMENT, "a struct's size is %u; set it to sizeof the struct", size);
}

/// Writes what the caller's struct has room for. Its first member is its size.
template <class T>
std::int32_t fill(T* out, T value) {
  if (const std::int32_t code = nullAmong({{out, "the struct for the answer"}})) return code;
  if (!isSize(out->size)) return badSize(out->size);
  const std::uint32_t size = out->size;
  if (size > sizeof(T)) std::memset(out, 0, size);
  value.size = size;
  std::memcpy(out, &value, std::min<std::size_t>(size, sizeof(T)));
  return PALPATE_OK;
}

inline std::int32_t say(palpate_error* error, std::int32_t code, const char* text) {
  if (code != PALPATE_OK && text != palpate_last_error()) refuse(code, "%s", text);  // else it is kept already
  if (error == nullptr) return code;
  palpate_error whole{};
  whole.code = code;
  cutText(text, sizeof whole.text - 1).copy(whole.text, sizeof whole.text - 1);
  fill(error, whole);
  return code;
}
/// What is refused already, with its sentence, is said to `error`, too.
inline std::int32_t sayToo(palpate_error* error, std::int32_t code) {
  return code == PALPATE_OK ? code : say(error, code, palpate_last_error());
}
inline std::int32_t nullAmong(palpate_error* error, std::initializer_list<Needed> all) {
  return sayToo(error, nullAmong(all));
}

/// Calls `action`, which returns a code; what it throws becomes one.
template <class Action>
std::int32_t guarded(palpate_error* error, Action action) noexcept {
  try {
    const std::int32_t code = action();
    return say(error, code, code == PALPATE_OK ? "" : palpate_last_error());
  } catch (const Refusal& refusal) {
    return say(error, refusal.code, refusal.what());
  } catch (const InputError& input) {
    return say(error, PALPATE_BAD_INPUT, input.what());
  } catch (const std::exception& failure) {
    return say(error, PALPATE_FAILED, failure.what());
  } catch (...) {
    return say(error, PALPATE_FAILED, "something unknown was thrown");
  }
}

/// The caller's struct as far as it goes; the rest is 0.
template <class T>
T given(const T* in) {
  T value{};
  if (in != nullptr && !isSize(in->size)) throw Refusal(PALPATE_BAD_ARGUMENT, "a struct whose size is not sizeof it");
  if (in != nullptr) std::memcpy(&value, in, std::min<std::size_t>(in->size, sizeof(T)));
  return value;
}

/// Three numbers, each finite and no larger than Request::farthest.
inline bool isPlace(const double* x) {
  return x != nullptr && std::all_of(x, x + 3, [](double v) { return std::abs(v) <= Request::farthest; });
}

inline bool isPose(const double* p) {
  if (!isPlace(p) || !std::all_of(p + 3, p + 7, [](double v) { return std::isfinite(v); })) return false;
  const double size = p[3] * p[3] + p[4] * p[4] + p[5] * p[5] + p[6] * p[6];
  return size > 0.25 && size < 4;
}

/// @pre isPose(p). A quaternion that is a unit one but for rounding keeps its bits.
inline Pose poseFrom(const double* p) {
  constexpr double rounding = 1e-12;
  Pose pose;
  pose.position = {p[0], p[1], p[2]};
  pose.orientation.coeffs() << p[3], p[4], p[5], p[6];
  if (std::abs(pose.orientation.squaredNorm() - 1) > rounding) pose.orientation.normalize();
  return pose;
}

inline void put(const Vec3& v, double* out) { std::copy_n(v.data(), 3, out); }
inline void put(const Pose& pose, double* out) {
  put(pose.position, out);
  std::copy_n(pose.orientation.coeffs().data(), 4, out + 3);
}

}  // namespace palpate::api
