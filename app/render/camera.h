#pragma once

#include <Eigen/Core>

#include "base/types.h"
#include "model/model.h"

namespace palpate::app {

/// A half line in the world, m; the direction has unit length.
struct Ray {
  Vec3 origin = Vec3::Zero();
  Vec3 direction = -Vec3::UnitZ();
};

/// Orbit camera: looks at a target from a distance, with +z up.
/// Pixels are framebuffer pixels with (0, 0) in the upper left corner.
struct Camera {
  Vec3 target = Vec3::Zero();  // m
  double distance = 0.5;       // m
  double azimuth_deg = -60;    // of the eye around +z, from +x
  double elevation_deg = 25;   // of the eye above the horizon
  double fov_deg = 35;         // vertical

  /// The scene's; where its file says neither where it looks nor from how far, it sees the whole organ.
  static Camera of(const Model& model);

  Vec3 forward() const;  // unit, from the eye to the target
  Vec3 right() const;    // unit, to the right of the picture
  Vec3 up() const;       // unit, to the top of the picture
  Vec3 eye() const;      // m

  /// Camera coordinates (x right, y up, -z ahead) from world coordinates.
  Eigen::Matrix4d view() const;

  /// OpenGL clip coordinates from camera coordinates. The near and far planes
  /// follow the distance, so that depth stays precise at any zoom.
  Eigen::Matrix4d projection(int width, int height) const;

  /// The half line from the eye through a pixel's position.
  Ray rayThrough(double pixel_x, double pixel_y, int width, int height) const;

  /// Where a world point stands in the picture: pixel x, pixel y and distance
  /// ahead of the eye in m (negative: behind it, then x and y mean nothing).
  Vec3 project(const Vec3& world, int width, int height) const;

  /// World size of one pixel at a world point, m.
  double pixelSize(const Vec3& world, int height) const;

  /// Turns around the target as if a ball of the picture's height were rolled
  /// by the drag: half a turn per picture height. Elevation stays within +-89 degrees.
  void orbit(double pixels_x, double pixels_y, int height);

  /// Moves the target so that what stands there follows the pointer.
  void pan(double pixels_x, double pixels_y, int height);

  /// One step of a mouse wheel brings the eye a tenth nearer (> 0) or further (< 0).
  void zoom(double steps);

  /// Shows a whole sphere, keeping the angles.
  void frame(const Vec3& centre, double radius, int width, int height);
};

}  // namespace palpate::app
