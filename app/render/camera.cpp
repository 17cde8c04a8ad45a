#include "app/render/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::app {
namespace {

constexpr double degree = std::numbers::pi / 180;

// The near plane in distances to the target, and the far one: a ratio of 5000 leaves a
// 24-bit depth buffer 3e-6 of the distance at the target. A larger near clips what the eye comes close to.
constexpr double near_in_distances = 0.02;
constexpr double far_in_distances = 100;

constexpr double max_elevation_deg = 89;  // at the pole, "up" would lose its meaning
constexpr double zoom_per_step = 0.9;
constexpr double min_distance = 1e-4, max_distance = 1e3;  // m, so that wheel spinning stays finite
constexpr double frame_margin = 1.08;
constexpr double room_for_tool = 1.3;  // around the organ in the first view

/// World size at distance 1 of half the picture's height.
double halfHeight(const Camera& camera) { return std::tan(0.5 * camera.fov_deg * degree); }

}  // namespace

Camera Camera::of(const Model& model) {
  const Scene& scene = model.scene;
  Camera camera{scene.camera.target, scene.camera.distance, scene.camera.azimuth_deg, scene.camera.elevation_deg,
                scene.camera.fov_deg};
  const bool placed = scene.places.contains("camera.target") || scene.places.contains("camera.distance");
  if (placed || scene.place.file.empty()) return camera;
  Eigen::AlignedBox3d box;
  for (const Vec3& X : model.skin.surface.vertices) box.extend(X);
  if (!box.isEmpty()) camera.frame(box.center(), room_for_tool * 0.5 * box.diagonal().norm(), 1, 1);
  return camera;
}

Vec3 Camera::forward() const {
  const double a = azimuth_deg * degree, e = elevation_deg * degree;
  return -Vec3(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
}

Vec3 Camera::right() const {
  const double a = azimuth_deg * degree;
  return {-std::sin(a), std::cos(a), 0};
}

Vec3 Camera::up() const { return right().cross(forward()); }

Vec3 Camera::eye() const { return target - distance * forward(); }

Eigen::Matrix4d Camera::view() const {
  Mat3 camera_from_world;
  camera_from_world << right().transpose(), up().transpose(), -forward().transpose();
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = camera_from_world;
  m.topRightCorner<3, 1>() = -camera_from_world * eye();
  return m;
}

Eigen::Matrix4d Camera::projection(int width, int height) const {
  const double near = near_in_distances * distance, far = far_in_distances * distance;
  const double y_scale = 1 / halfHeight(*this);
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m(0, 0) = y_scale * height / width;
  m(1, 1) = y_scale;
  m(2, 2) = -(far + near) / (far - near);
  m(2, 3) = -2 * far * near / (far - near);
  m(3, 2) = -1;
  return m;
}

Ray Camera::rayThrough(double pixel_x, double pixel_y, int width, int height) const {
  const double per_pixel = 2 * halfHeight(*this) / height;
  const Vec3 direction =
      forward() + per_pixel * (pixel_x - 0.5 * width) * right() + per_pixel * (0.5 * height - pixel_y) * up();
  return {eye(), direction.normalized()};
}

Vec3 Camera::project(const Vec3& world, int width, int height) const {
  const Vec3 d = world - eye();
  const double ahead = d.dot(forward());
  const double pixels = 0.5 * height / (halfHeight(*this) * ahead);
  return {0.5 * width + pixels * d.dot(right()), 0.5 * height - pixels * d.dot(up()), ahead};
}

double Camera::pixelSize(const Vec3& world, int height) const {
  return 2 * halfHeight(*this) * (world - eye()).dot(forward()) / height;
}

void Camera::orbit(double pixels_x, double pixels_y, int height) {
  azimuth_deg = std::remainder(azimuth_deg - 180 * pixels_x / height, 360.0);
  elevation_deg = std::clamp(elevation_deg + 180 * pixels_y / height, -max_elevation_deg, max_elevation_deg);
}

void Camera::pan(double pixels_x, double pixels_y, int height) {
  target += pixelSize(target, height) * (-pixels_x * right() + pixels_y * up());
}

void Camera::zoom(double steps) {
  distance = std::clamp(distance * std::pow(zoom_per_step, steps), min_distance, max_distance);
}

void Camera::frame(const Vec3& centre, double radius, int width, int height) {
  target = centre;
  const double narrow = std::min(1.0, static_cast<double>(width) / height);
  const double half_angle = std::atan(halfHeight(*this) * narrow);
  distance = std::clamp(frame_margin * radius / std::sin(half_angle), min_distance, max_distance);
}

}  // namespace palpate::app
