#include "realtime/device/device_coupling.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "base/turn.h"
#include "realtime/fakes.h"
#include "support/realtime_guard.h"

using namespace palpate;

namespace {

constexpr std::int64_t ms = 1'000'000;

/// A coupling called each millisecond with a handle and a tool where the test has them, in contact.
struct Hand {
  explicit Hand(const DeviceSettings& device = {}) : settings(device), model(test::smallModel(1000)) {
    tool.tick = 1;
    tool.contact_count = 1;
    tool.tool_pose = model.tools.first().start.pose;
    call();  // the handle's first place is the tool's start
  }

  Vec3 call() {
    now += ms;
    if (follows) tool.wall_ns = now - 2 * ms;
    ++tool.tick;
    pose.sequence += 1;
    pose.felt = felt_ago > 0 && pose.sequence > felt_ago ? pose.sequence - felt_ago : 0;
    const DeviceWrench out = coupling.update(now, sends ? &pose : nullptr, tool, put_backs);
    given -= (pose.pose.position - before).dot(last);
    before = pose.pose.position;
    largest_rise = std::max(largest_rise, out.force.norm() - last.norm());
    largest_change = std::max(largest_change, (out.force - last).norm());
    torque = out.torque;
    return last = out.force;
  }
  Vec3 after(int calls_more) {
    for (int k = 0; k < calls_more; ++k) call();
    return last;
  }
  void moveTool(const Vec3& from_start) {
    tool.tool_pose.position = model.tools.first().start.pose.position + from_start;
  }
  /// There in as many calls; the tool goes a share of that way.
  Vec3 push(const Vec3& to, double share = 0.4, int calls = 200) {
    const Vec3 from = pose.pose.position, tool_from = tool.tool_pose.position;
    for (int k = 1; k <= calls; ++k) {
      const Vec3 way = static_cast<double>(k) / calls * (to - from);
      pose.pose.position = from + way;
      tool.tool_pose.position = tool_from + settings.scale * share * way;
      call();
    }
    return last;
  }

  DeviceSettings settings;
  Model model;
  DeviceCoupling coupling{settings, model};
  std::int64_t now = 1000 * ms;
  DevicePose pose;
  ForceSample tool;
  bool sends = true, follows = true;
  std::uint32_t felt_ago = 1, put_backs = 0;
  Vec3 last = Vec3::Zero(), torque = Vec3::Zero(), before = Vec3::Zero();
  double largest_change = 0, largest_rise = 0;
  double given = 0;  // J, -(F . dx): what the hand has put in
};

}  // namespace

TEST_CASE("At rest the handle feels the coupling's spring, in air nothing", "[device]") {
  Hand hand;
  hand.push(Vec3(0.001, 0, -0.005));
  hand.after(1000);
  CHECK((hand.last - 400 * 0.6 * Vec3(-0.001, 0, 0.005)).norm() < 1e-9);
  CHECK((hand.coupling.target().pose.position - hand.model.tools.first().start.pose.position - hand.pose.pose.position)
            .norm() < 1e-12);
  CHECK(hand.coupling.target().stiffness == Approx(400));
  hand.tool.contact_count = 0;
  CHECK(hand.after(10) == Vec3::Zero());
}

TEST_CASE("A scaled way changes the spring that the tool feels, not the one that the hand does", "[device]") {
  DeviceSettings settings;
  settings.scale = 4;
  Hand hand(settings);
  hand.push(Vec3(0, 0, -0.002));
  hand.after(1000);
  CHECK((hand.last - 400 * 0.6 * Vec3(0, 0, 0.002)).norm() < 1e-9);
  CHECK(hand.coupling.target().stiffness == Approx(100));
  CHECK((hand.coupling.target().pose.position - hand.model.tools.first().start.pose.position - Vec3(0, 0, -0.008))
            .norm() < 1e-12);
}

TEST_CASE("The force's norm is bounded, and how quickly it rises", "[device]") {
  Hand hand;
  hand.push(Vec3(-0.05, 0.05, -0.05), 0, 100);
  hand.after(300);
  CHECK(hand.last.norm() == Approx(3.3));
  CHECK((hand.last.normalized() - Vec3(1, -1, 1).normalized()).norm() < 1e-12);
  CHECK(hand.largest_rise <= 3.3 / 0.01 * 1e-3 * (1 + 1e-9));
  CHECK(hand.largest_rise > 0.3);
}

TEST_CASE("A handle that is put elsewhere at once has not gone there - the spring's end slips, and is told of",
          "[device]") {
  Hand hand;
  hand.push(Vec3(0, 0, -0.004));
  const Vec3 held = hand.after(200);
  CHECK(hand.coupling.report().slipped_m < 1e-6);
  const double paid = hand.coupling.report().energy_J;
  // A glitch: 30 mm aside for 5 ms, 20 times.
  for (int k = 0; k < 20; ++k) {
    hand.pose.pose.position = Vec3(0.03, 0, -0.004);
    hand.pose.pose.orientation = turnedBy(Vec3(0, 1, 0));
    CHECK(hand.call().norm() < 1.2 * held.norm());
    CHECK(hand.coupling.report().slipped_m > 0.02);
    hand.after(4);
    hand.pose.pose.position = Vec3(0, 0, -0.004);
    hand.pose.pose.orientation = Quat::Identity();
    hand.after(20);
  }
  CHECK(hand.coupling.report().energy_J > paid - 1e-5);
  CHECK((hand.after(500) - held).norm() < 0.1 * held.norm());
  // Elsewhere for good, and in air all comes back.
  hand.pose.pose.position = Vec3(0, 0.02, -0.004);
  hand.after(5);
  hand.tool.contact_count = 0;
  hand.after(1000);
  CHECK(hand.coupling.report().slipped_m < 1e-4);
  CHECK((hand.coupling.target().pose.position - hand.model.tools.first().start.pose.position - hand.pose.pose.position)
            .norm() < 1e-4);
}

TEST_CASE("A clock that steps back once takes no force from the hand", "[device]") {
  Hand steady;
  steady.push(Vec3(0, 0, -0.004));
  steady.push(Vec3(0, 0, -0.005));
  for (const std::int64_t back : {20 * ms, 1000 * ms, 5000 * ms, 1'000'000'000 * ms}) {
    Hand hand;
    hand.now += 2'000'000'000 * ms;
    hand.after(1);
    hand.push(Vec3(0, 0, -0.004));
    hand.now -= back;
    hand.push(Vec3(0, 0, -0.005));
    CAPTURE(back);
    CHECK((hand.last - steady.last).norm() < 0.01 * steady.last.norm());
    CHECK(hand.coupling.report().fades == 0);
    CHECK(hand.coupling.report().lowest_energy_J > -1e-5);
  }
}

TEST_CASE("A device that falls silent has no force 60 ms later, and takes the tool again where both are", "[device]") {
  Hand hand;
  hand.push(Vec3(0, 0, -0.004));
  const Vec3 held = hand.after(100);
  hand.sends = false;
  CHECK((hand.after(9) - held).norm() < 1e-9);
  CHECK(hand.coupling.target().engaged);
  const Vec3 fading = hand.after(20);
  CHECK(fading.norm() < 0.7 * held.norm());
  CHECK(fading.norm() > 0);
  CHECK_FALSE(hand.coupling.target().engaged);
  CHECK(hand.after(31) == Vec3::Zero());
  CHECK(hand.coupling.report().silences == 1);

  hand.after(140);
  hand.sends = true;
  hand.pose.pose.position = Vec3(0, 0, -0.008);  // it fell on meanwhile
  CHECK(hand.call().norm() < 1e-9);
  CHECK(hand.after(500).norm() < 1e-9);  // the hand has paid for nothing
  CHECK(hand.push(Vec3(0, 0, -0.010), 0).z() == Approx(0.8).epsilon(0.1));
  hand.push(Vec3(0, 0, -0.004), 0);
  hand.tool.contact_count = 0;
  hand.after(1000);  // in air the tool comes to where it belongs
  CHECK((hand.coupling.target().pose.position - hand.model.tools.first().start.pose.position - hand.pose.pose.position)
            .norm() < 1e-6);
}

TEST_CASE("A short silence leaves the force that is out, and no more", "[device]") {
  Hand hand;
  const Vec3 held = hand.push(Vec3(0, 0, -0.004));
  hand.sends = false;
  hand.after(20);
  hand.sends = true;
  hand.pose.pose.position.z() -= 0.001;
  const Vec3 left = hand.call();
  CHECK(left.norm() < 0.9 * held.norm());
  CHECK(left.norm() > 0.5 * held.norm());
  CHECK((hand.after(500) - left).norm() < 0.02 * held.norm());
}

TEST_CASE("Tissue that was put back, is frozen or late fades the force", "[device]") {
  const auto spoil = GENERATE(0, 1, 2, 3, 4);
  Hand hand;
  hand.push(Vec3(0, 0, -0.004));
  const Vec3 held = hand.after(1000);
  CAPTURE(spoil);
  if (spoil == 0) ++hand.tool.loss_count;
  if (spoil == 1) hand.tool.frozen = true;
  if (spoil == 2) hand.follows = false;             // its force grows old
  if (spoil == 3) hand.moveTool(Vec3(0, 0, 0.05));  // a reset
  if (spoil == 4) ++hand.put_backs;                 // an undo
  hand.largest_change = 0;
  hand.after(60);
  CHECK(hand.coupling.report().fades == 1);
  CHECK(hand.largest_change < 0.03 * held.norm());  // 40 ms of fading: no jump, wherever the tool is now
  CHECK(hand.last.norm() < 1e-9);
  hand.tool.frozen = false;
  hand.follows = true;
  CHECK(hand.call().norm() < 1e-9);
  CHECK(hand.after(1000).norm() < 1e-9);
  CHECK(hand.coupling.report().engaged);
  CHECK(hand.push(Vec3(0, 0, -0.006), 0).z() == Approx(0.8).epsilon(0.1));
}

TEST_CASE("A tool that runs ahead of the hand gives it no energy, in whichever direction", "[device]") {
  const std::uint32_t late = GENERATE(0, 1, 6, 20);
  const double along = GENERATE(0.0, 1.0);
  Hand hand;
  hand.felt_ago = late;
  const Vec3 way = Vec3(along, 0, -1).normalized();
  double s = 0, work = 0, largest = 0;
  std::vector<Vec3> sent;
  for (int k = 0; k < 4000; ++k) {
    const double before = s;
    s = 0.01 * (1 - std::cos(0.02 * k));
    hand.pose.pose.position = s * way;
    // F = 1 N s/m times the velocity: a damper of the wrong sign
    hand.moveTool((s + (s - before) / 1e-3 / 400) * way);
    hand.call();
    sent.push_back(hand.last);
    const std::size_t felt = sent.size() > late + 1 ? sent.size() - 1 - late : 0;
    work += sent[felt].dot((s - before) * way);
    largest = std::max(largest, work);
  }
  CAPTURE(late);
  CHECK(largest < 3e-4);
  if (late <= 1) CHECK(hand.coupling.report().damped_J > 0);  // later ones are soft
}

TEST_CASE("No force pulls the handle against the contact's normal", "[device]") {
  Hand hand;
  hand.tool.contact_normal = Vec3::UnitZ();
  hand.push(Vec3(0, 0, -0.005));
  double lowest = 0;
  for (int k = 0; k < 100; ++k) {
    hand.pose.pose.position.z() += 2e-4;  // away at 0.2 m/s, quicker than the tool
    lowest = std::min(lowest, hand.call().z());
  }
  CHECK(lowest >= 0);
}

TEST_CASE("A device that answers late gets the stiffness that its damping and a light handle allow", "[device]") {
  DeviceSettings settings = DeviceSettings::of(1);
  Hand hand(settings);
  hand.after(2000);
  CHECK(hand.coupling.report().stiffness == Approx(3000));
  hand.felt_ago = 6;  // one period lies between a force and the next pose: 5 ms of way
  hand.after(2000);
  CHECK(hand.coupling.report().delay_s == Approx(0.005).epsilon(0.02));
  CHECK(hand.coupling.report().stiffness == Approx(2 / (0.0005 + 0.005)).epsilon(0.02));
  hand.felt_ago = 21;
  hand.after(2000);
  CHECK(hand.coupling.report().stiffness == Approx(0.02 / (0.0205 * 0.0205)).epsilon(0.03));
  Hand untold(settings);
  untold.felt_ago = 0;
  untold.after(2000);
  CHECK(untold.coupling.report().delay_s == Approx(PortEnergy::assumed_s));
  CHECK(untold.coupling.report().stiffness == Approx(0.02 / (0.0105 * 0.0105)).epsilon(0.03));
}

TEST_CASE("What the hand got in a gap is forgotten a second after it has lifted off", "[device]") {
  Hand hand;
  const auto press = [&] {
    hand.tool.contact_count = 1;
    hand.push(Vec3(0, 0, -0.006));
    return hand.after(100).z();
  };
  const auto lift = [&](int calls) {
    hand.push(Vec3::Zero());
    hand.tool.contact_count = 0;
    hand.moveTool(Vec3::Zero());
    hand.after(calls);
  };
  const double first = press();
  REQUIRE(first > 0.5);
  // Pulled out by 15 mm while 30 poses are missing.
  hand.sends = false;
  hand.after(30);
  hand.sends = true;
  hand.pose.pose.position.z() += 0.015;
  hand.call();
  CHECK(hand.coupling.report().energy_J < -1e-3);
  lift(500);
  CHECK(press() < 0.3 * first);  // at once it is held against the hand
  lift(1500);
  CHECK(press() == Approx(first).epsilon(0.05));
}

TEST_CASE("One pose that tells an old force makes nothing soft, a line that is late does", "[device]") {
  Hand hand;
  const Vec3 held = hand.push(Vec3(0, 0, -0.004));
  hand.after(200);
  hand.felt_ago = 60;
  hand.call();
  hand.felt_ago = 1;
  CHECK(hand.after(100).z() == Approx(held.z()).epsilon(0.03));
  CHECK(hand.coupling.report().delay_s < 1e-3);
  for (int k = 0; k < 100; ++k) {  // every third pose comes late
    hand.felt_ago = k % 3 == 0 ? 11 : 1;
    hand.call();
  }
  CHECK(hand.coupling.report().delay_s == Approx(0.010).epsilon(0.1));
}

TEST_CASE("A device that is slow feels what a quick one does, but softer - below 50 Hz it is silent", "[device]") {
  const int period = GENERATE(2, 5, 10, 15, 20, 33);
  Hand hand;
  const auto slowly = [&](int calls, const Vec3& way) {
    for (int k = 1; k <= calls; ++k) {
      hand.pose.pose.position += way / calls;
      hand.tool.tool_pose.position += 0.4 * way / calls;
      hand.sends = k % period == 0;
      hand.call();
    }
    return hand.last.z();
  };
  slowly(1200, Vec3::Zero());
  const std::int64_t at_first = hand.coupling.report().silences;
  slowly(600, Vec3(0, 0, -0.006));
  const double held = slowly(600, Vec3::Zero()), later = slowly(2400, Vec3::Zero());
  CAPTURE(period, hand.coupling.report().stiffness);
  if (period > 20) {
    CHECK(hand.coupling.report().silences > at_first + 50);
    return;
  }
  CHECK(held > 0.05);
  CHECK(later == Approx(held).epsilon(0.05));
  CHECK(hand.coupling.report().silences == at_first);
}

TEST_CASE("A turned handle feels an angular spring with a bound, or the orientation is locked", "[device]") {
  DeviceSettings settings;
  const bool locked = GENERATE(false, true);
  settings.locked = locked;
  Hand hand(settings);
  const auto turn = [&](double from, double to, double tool) {
    for (int k = 1; k <= 300; ++k) {
      hand.pose.pose.orientation = turnedBy((from + k / 300.0 * (to - from)) * Vec3::UnitY());
      if (!locked) hand.tool.tool_pose.orientation = turnedBy(k / 300.0 * tool * Vec3::UnitY());
      hand.call();
    }
    hand.after(300);
  };
  turn(0, 0.2, 0.05);
  const double spring = 400 * 0.02 * 0.02;  // N m/rad
  if (locked) {
    CHECK(hand.torque == Vec3::Zero());
    CHECK(hand.coupling.target().pose.orientation.coeffs() == hand.model.tools.first().start.pose.orientation.coeffs());
    CHECK(hand.coupling.target().turning_stiffness == 0);
    return;
  }
  CHECK((hand.torque + 0.15 * spring * Vec3::UnitY()).norm() < 1e-9);
  CHECK(hand.coupling.target().turning_stiffness == Approx(spring));
  CHECK(turnBetween(hand.coupling.target().pose.orientation, hand.pose.pose.orientation).norm() < 1e-9);
  turn(0.2, 1.5, 0.05);
  CHECK(hand.torque.norm() == Approx(3.3 * 0.02));
  CHECK(hand.coupling.report().peak_torque == Approx(3.3 * 0.02));
}

TEST_CASE("A call of the coupling takes no memory and no lock", "[device]") {
  Hand hand;
  hand.pose.pose.position = Vec3(0, 0, -0.004);
  test::startGuard();
  hand.after(100);
  hand.sends = false;
  hand.after(100);
  hand.sends = true;
  hand.felt_ago = 0;
  hand.after(100);
  const test::GuardCounts counts = test::stopGuard();
  CHECK(counts.total() == 0);
  CHECK(hand.coupling.report().poses > 100);
}
