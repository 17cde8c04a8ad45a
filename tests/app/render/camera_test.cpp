#include "app/render/camera.h"

#include <catch2/catch.hpp>

using namespace palpate;
using namespace palpate::app;

namespace {

constexpr int width = 1280, height = 800;

Camera someCamera() { return {Vec3(0.02, -0.01, 0.05), 0.4, -60, 25, 35}; }

}  // namespace

TEST_CASE("The camera looks at its target from its distance", "[camera]") {
  const Camera camera = someCamera();
  CHECK((camera.eye() - camera.target).norm() == Approx(0.4));
  // Azimuth -60 degrees, elevation 25: closed form.
  CHECK((camera.eye() - camera.target - 0.4 * Vec3(0.453154, -0.784886, 0.422618)).norm() < 1e-6);

  const Eigen::Vector4d seen = camera.view() * camera.target.homogeneous();
  CHECK((seen.head<3>() - Vec3(0, 0, -0.4)).norm() < 1e-12);

  const Mat3 turn = camera.view().topLeftCorner<3, 3>();
  CHECK((turn * turn.transpose() - Mat3::Identity()).norm() < 1e-12);
  CHECK(turn.determinant() == Approx(1.0));
}

TEST_CASE("Projection, matrix and ray agree about where a point stands", "[camera]") {
  const Camera camera = someCamera();
  const Vec3 point = camera.target + Vec3(0.03, 0.02, -0.01);
  const Vec3 pixel = camera.project(point, width, height);

  const Eigen::Vector4d clip = camera.projection(width, height) * camera.view() * point.homogeneous();
  CHECK(pixel.x() == Approx(width * (0.5 + 0.5 * clip.x() / clip.w())));
  CHECK(pixel.y() == Approx(height * (0.5 - 0.5 * clip.y() / clip.w())));
  CHECK(pixel.z() == Approx(clip.w()));
  CHECK(std::abs(clip.z()) < clip.w());  // between near and far plane

  const Ray ray = camera.rayThrough(pixel.x(), pixel.y(), width, height);
  CHECK((point - ray.origin).cross(ray.direction).norm() < 1e-12);
  CHECK(ray.direction.norm() == Approx(1.0));

  const Vec3 behind = camera.eye() - 0.1 * camera.forward();
  CHECK(camera.project(behind, width, height).z() < 0);
}

TEST_CASE("The picture is right side up and not mirrored", "[camera]") {
  const Camera camera{Vec3::Zero(), 1, -90, 0, 35};  // from -y, x to the right
  CHECK(camera.project(Vec3(0.1, 0, 0), width, height).x() > width / 2);
  CHECK(camera.project(Vec3(0, 0, 0.1), width, height).y() < height / 2);
}

TEST_CASE("Panning moves what stands at the target with the pointer", "[camera]") {
  Camera camera = someCamera();
  const Vec3 held = camera.target;
  camera.pan(37, -21, height);
  const Vec3 pixel = camera.project(held, width, height);
  CHECK(pixel.x() == Approx(width / 2 + 37));
  CHECK(pixel.y() == Approx(height / 2 - 21));
  CHECK(camera.distance == 0.4);
}

TEST_CASE("Orbiting keeps target and distance, and stops short of the poles", "[camera]") {
  Camera camera = someCamera();
  camera.orbit(height, 0, height);  // half a turn
  CHECK(camera.azimuth_deg == Approx(120));
  CHECK((camera.eye() - camera.target).norm() == Approx(0.4));
  camera.orbit(0, 100 * height, height);
  CHECK(camera.elevation_deg == 89);
  CHECK(camera.up().allFinite());
  CHECK(camera.up().z() > 0);

  // Dragging to the right turns the front of the object to the right.
  Camera turned = someCamera();
  const Vec3 front = turned.target - 0.05 * turned.forward();
  turned.orbit(10, 0, height);
  CHECK(turned.project(front, width, height).x() > width / 2);
}

TEST_CASE("Zooming in and out again comes back", "[camera]") {
  Camera camera = someCamera();
  camera.zoom(5);
  CHECK(camera.distance == Approx(0.4 * std::pow(0.9, 5)));
  camera.zoom(-5);
  CHECK(camera.distance == Approx(0.4));
  camera.zoom(1e6);
  CHECK(camera.distance > 0);
}

TEST_CASE("Framing shows a whole sphere and fills the picture with it", "[camera]") {
  for (const auto& [w, h] : {std::pair{1280, 800}, std::pair{300, 900}}) {
    Camera camera = someCamera();
    const Vec3 centre(0.1, 0.2, 0.3);
    camera.frame(centre, 0.12, w, h);
    double reach = 0;  // of the silhouette, in half pictures
    for (int i = 0; i < 2000; ++i) {
      const double z = -1 + (2.0 * i + 1) / 2000, a = 2.4 * i, r = std::sqrt(1 - z * z);
      const Vec3 p = camera.project(centre + 0.12 * Vec3(r * std::cos(a), r * std::sin(a), z), w, h);
      REQUIRE(p.z() > 0);
      reach = std::max({reach, std::abs(2 * p.x() / w - 1), std::abs(2 * p.y() / h - 1)});
    }
    CHECK(reach < 1);
    CHECK(reach > 0.85);
  }
}
