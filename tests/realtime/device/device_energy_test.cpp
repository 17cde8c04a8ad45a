// The energy that a handle gets, counted at the handle and not by the coupling's own observer: handles, hands, delays
// and tissues drawn by lot, with a Hertz contact for the tissue, so that many runs are cheap. On a body of MTLED:
// tests/tools/device_bench_test.cpp.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <deque>

#include "realtime/device/coupled_tool.h"
#include "realtime/device/device_coupling.h"
#include "realtime/device/hand_model.h"
#include "realtime/fakes.h"

using namespace palpate;

namespace {

struct Trial {
  double mass = 0.08, stiffness = 5, damping = 0.2;  // of the handle; of the hand, N/m, N s/m
  double delay = 0.005, jitter = 0.001;              // s, each way
  bool told = true;                                  // which force it has
  double encoder = 0;                                // m
  double young = 50e3;                               // Pa
  int motion = 0;                                    // of the hand: hold, 1 Hz, pokes, a throw
  double push = 0.3;                                 // N, that the hand means to hold
  double rate_hz = 1000;                             // of the loop
  int device_class = 0;
  int dropouts = 0, stalls = 0;  // one each half second
  double lasting = 0.02;         // s
  bool dead_line = false;        // forces are lost in a dropout, too
  std::uint64_t seed = 1;
};

struct Outcome {
  double given_J = 0, dropout_J = 0;  // the most in all; in half a second around a dropout
  double pull = 0;                    // N, towards the tissue
  double force = 0, tissue = 0;       // N, in the fifth second: at the handle, on the tool
  double sway = 0;                    // m, of the handle in the last
};

double rise(double t, double from, double to) {
  const double s = std::clamp((t - from) / (to - from), 0.0, 1.0);
  return s * s * s * (10 + s * (6 * s - 15));
}

template <class T>
struct Late {
  struct Message {
    double arrives;
    T what;
  };
  std::deque<Message> under_way;

  /// The highest sequence that has come; false: nothing new has.
  bool take(double now, T& newest) {
    bool news = false;
    for (Message& m : under_way) {
      if (m.arrives > now) continue;
      if (m.what.sequence > newest.sequence) newest = m.what, news = true;
      m.arrives = -1;
    }
    std::erase_if(under_way, [](const Message& m) { return m.arrives < 0; });
    return news;
  }
};

constexpr double begins_above = 0.005;  // m

Model modelOf(const Trial& c) {
  Model model = test::smallModel(c.rate_hz);
  model.scene.device = DeviceSettings::of(c.device_class);
  model.scene.tools[0].shape.radius = 0.005;
  model.scene.tools[0].max_speed = 1;
  model.scene.tools[0].friction = 0;
  model.tools.first().start.pose.position = Vec3(0, 0, begins_above);
  Material& m = model.materials[0];
  m.density = 1000;
  m.shear_modulus = c.young / (2 * 1.45);
  m.bulk_modulus = c.young / (3 * 0.1);
  return model;
}

/// Hertz 1882, nu = 0.45.
Vec3 tissueForce(const Vec3& tool, double young) {
  const double depth = std::max(0.0, -tool.z());
  return {0, 0, 4.0 / 3 * young / (1 - 0.45 * 0.45) * std::sqrt(0.005) * std::pow(depth, 1.5)};
}

Outcome run(const Trial& c) {
  constexpr double h = 5e-5, seconds = 6;
  const Model model = modelOf(c);
  DeviceCoupling coupling(model.scene.device, model);
  CoupledTool tool(model);
  SteadyRandom random(c.seed);
  const auto way = [&] { return c.delay + c.jitter * random.next(); };
  Late<DevicePose> poses;
  Late<DeviceWrench> wrenches;
  DevicePose pose, read;
  DeviceWrench motors;
  State state;
  state.tool[0].pose = model.tools.first().start.pose;
  StepReport last;
  ForceSample pending, ready;
  Outcome out;
  const double depth = c.stiffness > 0 ? std::min(0.15, c.push / c.stiffness) + begins_above : 0;
  double x = 0, v = c.motion == 3 ? -0.3 : 0, work = 0, before = 0, done = 1e9, low = 1, high = -1;
  std::uint32_t sequence = 0;
  double heard = 0;  // s, the last force
  const int per_tick = static_cast<int>(std::lround(1 / (c.rate_hz * h)));
  for (int k = 0; k * h < seconds; ++k) {
    const double t = k * h, since = std::fmod(t, 0.5);
    const auto gap = [&](int count) { return t >= 1.5 && t < 1.5 + 0.5 * count && since < c.lasting; };
    if (wrenches.take(t, motors)) heard = t;
    if (t > heard + 0.02) motors.force.setZero();  // what is asked of a bridge
    double wanted = -begins_above, weight = 0;
    if (c.motion == 0) wanted = -depth * rise(t, 0.1, 0.6), weight = -c.push * rise(t, 0.1, 0.3);
    if (c.motion == 1) wanted = -depth * 0.5 * (1 - std::cos(6.283 * t)), weight = -c.push * std::sin(6.283 * t);
    if (c.motion == 2) {
      const double s = std::fmod(t, 2.0);
      wanted = -depth * (rise(s, 0.1, 0.5) - rise(s, 1.4, 1.8));
      weight = -c.push * (rise(s, 0.1, 0.3) - 2 * rise(s, 1.0, 1.1) + rise(s, 1.8, 1.9));
    }
    const double hand = c.stiffness > 0 ? c.stiffness * (wanted - x) : weight;
    v += h / c.mass * (motors.force.z() + hand - c.damping * v);
    x += h * v;
    work += h * motors.force.z() * v;
    out.given_J = std::max(out.given_J, work);
    if (since < h / 2) before = work;
    if (t >= 1.5 && t < 1.5 + 0.5 * std::max(c.dropouts, c.stalls))
      out.dropout_J = std::max(out.dropout_J, work - before);
    if (t > seconds - 1) low = std::min(low, x), high = std::max(high, x);
    if (k % 20 != 0) continue;

    pose.sequence = ++sequence;
    pose.felt = c.told ? motors.sequence : 0;
    pose.sent_ns = std::llround(1e9 * t);
    pose.pose.position.z() = c.encoder > 0 ? c.encoder * std::round(x / c.encoder) : x;
    if (!gap(c.dropouts)) poses.under_way.push_back({t + way(), pose});
    const std::int64_t now = 1'000'000'000 + pose.sent_ns;
    const bool news = poses.take(t, read);
    const DeviceWrench wrench = coupling.update(now, news ? &read : nullptr, ready, tool.putBacks());
    tool.targets().back() = coupling.target();
    tool.targets().publish();
    if (!(c.dead_line && gap(c.dropouts))) wrenches.under_way.push_back({t + way(), wrench});
    out.pull = std::max(out.pull, -wrench.force.z());
    if (k % per_tick == 0 && !gap(c.stalls)) {
      if (pending.tick > 0) ready = pending;
      state.tool[0].pose = tool.next(state, last);
      last.tool_force = tissueForce(state.tool[0].pose.position, c.young);
      const bool touches = !last.tool_force.isZero(0);
      last.contact_normal = touches ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::Zero());
      ++pending.tick;
      pending.wall_ns = now;
      pending.tool_pose = state.tool[0].pose;
      pending.force_raw = last.tool_force;
      pending.contact_normal = last.contact_normal;
      pending.contact_count = touches ? 3 : 0;
      done = t + 0.8 / c.rate_hz;
    }
    if (t >= done - 1e-9) ready = pending;
    if (t >= 4 && t < 5) out.force += 1e-3 * motors.force.z(), out.tissue += 1e-3 * last.tool_force.z();
  }
  out.sway = high - low;
  return out;
}

Trial drawn(std::uint64_t seed) {
  SteadyRandom random(seed);
  const auto between = [&](double least, double most) { return least + (most - least) * random.next(); };
  const auto scaled = [&](double least, double most) { return least * std::pow(most / least, random.next()); };
  Trial c;
  c.seed = seed;
  c.mass = scaled(0.02, 0.5);
  c.stiffness = random.next() < 0.2 ? 0 : between(2, 50);
  c.damping = random.next() < 0.3 ? 0 : between(0, 1);
  c.delay = random.next() < 0.2 ? 0 : between(0, 0.02);
  c.jitter = between(0, 0.004);
  c.told = random.next() < 0.8;
  if (!c.told) c.delay = std::min(c.delay, 0.01);
  c.encoder = random.next() < 0.5 ? 0 : 5e-5;
  c.young = scaled(1e3, 1e5);
  c.motion = static_cast<int>(4 * random.next());
  c.push = between(0.1, 0.5);
  c.rate_hz = random.next() < 0.5 ? 500 : 1000;
  c.device_class = static_cast<int>(3 * random.next());
  c.dropouts = random.next() < 0.3 ? 8 : 0;
  c.lasting = between(0.005, 0.2);
  c.dead_line = random.next() < 0.5;
  c.stalls = random.next() < 0.2 ? 8 : 0;
  return c;
}

}  // namespace

TEST_CASE("A loose hand behind a delay gets no energy from the tissue, and is not pulled", "[device][energy]") {
  Trial trial;
  const Outcome told = run(trial);
  CHECK(told.given_J < 1e-4);  // it was 0.9 J
  CHECK(told.pull == 0);       // it was 1.5 N
  CHECK(told.sway < 1e-3);     // it was 186 mm
  CHECK(told.force == Approx(0.3).epsilon(0.1));
  CHECK(told.force == Approx(told.tissue).epsilon(0.01));
  trial.told = false;
  const Outcome untold = run(trial);
  CHECK(untold.given_J < 1e-4);
  CHECK(untold.pull == 0);
  CHECK(untold.sway < 1e-3);
}

TEST_CASE("Neither a dropout nor a late loop gives the handle energy", "[device][energy]") {
  Trial trial;
  trial.delay = trial.jitter = 0;
  trial.stiffness = 100;
  trial.damping = 2;
  const bool stalls = GENERATE(false, true);
  trial.dead_line = GENERATE(false, true);
  trial.lasting = GENERATE(0.02, 0.06, 0.2);
  (stalls ? trial.stalls : trial.dropouts) = GENERATE(1, 8);
  const Outcome outcome = run(trial);
  CAPTURE(stalls, trial.lasting, trial.dead_line);
  CHECK(outcome.given_J < 1e-4);    // it was up to 1.5 mJ
  CHECK(outcome.dropout_J < 1e-4);  // it was 0.15 to 0.27 mJ each
}

TEST_CASE("Handles, hands, delays and tissues drawn by lot: no handle gets half a millijoule",
          "[device][energy][whole]") {
  double given = 0, pull = 0;
  std::uint64_t worst = 0;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    const Outcome outcome = run(drawn(seed));
    if (outcome.given_J > given) given = outcome.given_J, worst = seed;
    pull = std::max(pull, outcome.pull);
  }
  CAPTURE(worst);
  CHECK(given < 5e-4);
  CHECK(pull < 1e-9);
}

TEST_CASE("A steady hand without delay feels coupling and tissue in series, as if nothing watched",
          "[device][energy]") {
  Trial trial;
  trial.delay = trial.jitter = 0;
  trial.stiffness = 300;
  trial.damping = 3;
  trial.mass = 0.05;
  trial.encoder = 5e-5;
  trial.device_class = GENERATE(0, 1, 2);
  trial.young = GENERATE(3e3, 50e3, 100e3);
  trial.push = 1;
  const Outcome outcome = run(trial);
  // A stiff spring shows the encoder's steps: each is up to 0.25 N.
  CHECK(outcome.force == Approx(outcome.tissue).epsilon(0.01).margin(0.01));
  // Where hand, coupling and tissue balance.
  const double wanted = 1.0 / 300 + begins_above, Kc = DeviceSettings::of(trial.device_class).stiffness;
  double low = 0, high = 1;
  for (int k = 0; k < 60; ++k) {
    const double f = 0.5 * (low + high), handle = wanted - f / 300 - begins_above, tool = handle - f / Kc;
    (tissueForce(Vec3(0, 0, -tool), trial.young).z() > f ? low : high) = f;
  }
  CHECK(outcome.force == Approx(low).epsilon(0.02).margin(0.01));
}
