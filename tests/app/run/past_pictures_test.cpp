#include "app/run/past_pictures.h"

#include <catch2/catch.hpp>

#include "app/run/kept_changes.h"

using namespace palpate;
using namespace palpate::app;

namespace {

Snapshot snapshotAt(double time_s) {
  Snapshot snapshot;
  snapshot.force.time_s = time_s;
  snapshot.u.resize(10);
  snapshot.contact_vertex.resize(500);
  snapshot.contact_force.resize(500);
  snapshot.contact_entries = 3;
  return snapshot;
}

}  // namespace

TEST_CASE("The last minute is kept, some pictures a second, and found by its time", "[past_pictures]") {
  PastPictures past;
  for (int k = 0; k <= 5000; ++k) past.add(snapshotAt(0.02 * k));
  CHECK(past.size() <= 1 + static_cast<std::size_t>(PastPictures::seconds / PastPictures::apart));
  CHECK(past.size() > 0.7 * PastPictures::seconds / PastPictures::apart);
  CHECK(past.begin_s() >= 100 - PastPictures::seconds - PastPictures::apart);
  CHECK(past.at(80).force.time_s == Approx(80).margin(1.1 * PastPictures::apart));
  CHECK(past.at(80).force.time_s <= 80);
  CHECK(past.at(0).force.time_s == past.begin_s());
  CHECK(past.at(80).contact_vertex.size() == 3);  // without the room that is not used
  past.add(snapshotAt(1));                        // begun anew
  CHECK(past.size() == 1);
}

TEST_CASE("What is kept of a run's input comes back in its order, up to a tick", "[kept_changes]") {
  KeptChanges kept;
  const auto toX = [](std::int64_t tick, double x) {
    return TimedRequest{tick, Request::moveTool({Vec3(x, 0, 0), Quat::Identity()})};
  };
  kept.add({0, Request::setFriction(0.3)});
  kept.add(toX(0, 1));
  kept.add(toX(1, 2));
  kept.add({1, Request::simple(Request::Kind::Reset)});
  kept.add(toX(1, 3));
  kept.add(toX(5, 4));
  kept.add({6, Request::simple(Request::Kind::ReleasePull)});
  const std::vector<TimedRequest> all = kept.before(100);
  REQUIRE(all.size() == 7);
  CHECK(all[0].request.kind == Request::Kind::SetFriction);
  CHECK(all[0].request.value == 0.3);
  CHECK(all[2].request.pose.position.x() == 2);
  CHECK(all[3].request.kind == Request::Kind::Reset);
  CHECK(all[4].request.pose.position.x() == 3);
  CHECK(all[6].request.kind == Request::Kind::ReleasePull);
  CHECK(kept.before(5).size() == 5);
  kept.add({6, Request::simple(Request::Kind::Submit)});
  CHECK(kept.before(6).size() == 7);  // all but the release: what is said in a pause is of its last tick
  CHECK(kept.before(6).back().request.kind == Request::Kind::Submit);
  CHECK_FALSE(kept.overflowed());
}
