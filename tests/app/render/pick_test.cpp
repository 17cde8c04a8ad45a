#include "app/render/pick.h"

#include <catch2/catch.hpp>

#include "app/render/field.h"
#include "snapshots/hand_made_model.h"

using namespace palpate;
using namespace palpate::app;

TEST_CASE("A ray through a vertex in the picture picks it, nearest side first", "[pick]") {
  const TriangleSurface ball = ellipsoidSurface(Vec3::Constant(0.05), 2);
  std::vector<Vec3f> x;
  for (const Vec3& X : ball.vertices) x.push_back(X.cast<float>());
  const Camera camera{Vec3::Zero(), 0.3, 20, 30, 35};
  int picked = 0;
  for (int v = 0; v < static_cast<int>(x.size()); ++v) {
    const Vec3 p = x[v].cast<double>();
    if (p.normalized().dot((camera.eye() - p).normalized()) < 0.2) continue;  // behind the horizon
    const Vec3 pixel = camera.project(p, 800, 600);
    const auto hit = pickSkin(ball, x, camera.rayThrough(pixel.x() + 0.01, pixel.y(), 800, 600));
    REQUIRE(hit);
    CHECK(hit->vertex == v);
    CHECK((hit->position - p).norm() < 1e-4);
    CHECK(hit->distance == Approx((p - camera.eye()).norm()).epsilon(1e-3));
    ++picked;
  }
  CHECK(picked > 30);
  CHECK_FALSE(pickSkin(ball, x, camera.rayThrough(5, 5, 800, 600)));
  CHECK_FALSE(pickSkin(ball, x, Ray{Vec3::Zero(), Vec3::UnitX()}));  // from inside
  CHECK_FALSE(pickSkin(ball, x, Ray{camera.eye(), -camera.forward()}));
}

TEST_CASE("Picking finds the integration point nearest to the ray where it has moved to", "[pick]") {
  const Model model = handMadeModel(ellipsoidSurface(Vec3::Constant(0.05), 1), 0.02, ToolShape{});
  Snapshot snapshot = restSnapshot(model, Vec3::Zero());
  for (Float4& u : snapshot.u) u.x = 0.5F;
  const Vec3 moved = model.point_X[3] + Vec3(0.5, 0, 0);
  const Ray ray{moved + Vec3(0.001, 0, 1), -Vec3::UnitZ()};
  const int picked = pickPoint(model, snapshot, ray, 0.005);
  REQUIRE(picked >= 0);
  CHECK((model.point_X[picked] - model.point_X[3]).head<2>().norm() < 1e-12);  // it or one straight below
  CHECK(pickPoint(model, snapshot, Ray{ray.origin - Vec3(0.5, 0, 0), ray.direction}, 0.005) == -1);
}

TEST_CASE("The organ is out of view behind the eye, beside the part, too far away, and from inside itself", "[pick]") {
  const TriangleSurface ball = ellipsoidSurface(Vec3::Constant(0.05), 3);
  std::vector<Vec3f> x;
  for (const Vec3& X : ball.vertices) x.push_back(X.cast<float>());
  const Eigen::AlignedBox2d part(Eigen::Vector2d(200, 50), Eigen::Vector2d(600, 550));
  const auto seen = [&](const Camera& camera) { return isSeen(ball, x, camera, part, 800, 600); };
  Camera camera{Vec3::Zero(), 0.3, 20, 30, 35};
  CHECK(seen(camera));
  camera.distance = 0.1;  // so near that it fills the picture
  CHECK(seen(camera));
  camera.distance = 0.02;
  CHECK_FALSE(seen(camera));
  camera.distance = 20;
  CHECK_FALSE(seen(camera));
  camera.distance = 0.3;
  camera.target = 0.14 * camera.right();  // under the left column
  CHECK_FALSE(seen(camera));
  CHECK_FALSE(seen(Camera{Vec3(1, 0, 0), 0.1, 180, 0, 35}));  // the other way
}
