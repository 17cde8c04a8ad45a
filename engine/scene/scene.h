#pragma once

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/input_error.h"
#include "base/types.h"
#include "contact/tool.h"
#include "mechanics/essential_nodes.h"
#include "mechanics/gradient_precision.h"
#include "mechanics/load_curve.h"
#include "mechanics/materials/material.h"
#include "scene/device_settings.h"
#include "scene/formulation.h"

namespace palpate {

/// A part of space, used to choose nodes (fixed, prescribed) or points (material).
struct Region {
  enum class Kind { HalfSpace, Box, Sphere, NearPlane, Cylinder, Shell, Point };
  Kind kind = Kind::HalfSpace;
  Vec3 point = Vec3::Zero();    // m; HalfSpace, NearPlane: a point of the plane; Sphere: its centre;
                                // Cylinder: the middle of its base; Point: itself, which holds no node
  Vec3 normal = Vec3::UnitZ();  // unit; HalfSpace: inside is where (x - point) . normal <= 0;
                                // Cylinder: its axis, from the base up
  Vec3 min = Vec3::Zero();      // Box, m
  Vec3 max = Vec3::Zero();      // Box, m
  double radius = 0;            // Sphere, Cylinder, m
  double height = 0;            // Cylinder, m
  double distance = 0;          // m; NearPlane: |(x - point) . normal| <= distance; Shell: no further from
                                // the organ's surface than this
  SourceLocation place;         // where the scene file says so

  /// True where x (m, reference configuration) lies inside or within `tolerance` of it.
  /// @param surface_distance  of x from the organ's surface, m; only a Shell needs it
  bool contains(const Vec3& x, double tolerance = 1e-9,
                double surface_distance = std::numeric_limits<double>::infinity()) const;
};

struct Membership;
struct TriangleSurface;

/// Measured points that go from one place to another, in the organ's coordinates.
struct PointLoad {
  std::string file;
  std::vector<int> line;            // (point_count) of the file, or empty
  std::vector<Vec3> before, after;  // (point_count) m; `before` empty: not measured
  bool sheet = false;               // the skin between them moves as a smooth sheet
};

/// Of shares of tissue that mixes by an image (setup/mixtures.h).
inline constexpr int mixture_steps = 255;

/// A material and where it is.
struct MaterialSpec {
  std::string name;  // as shown; "" where the scene gives none
  Material material = Material::neoHookean(3000, 0.49, 1000);
  bool everywhere = true;  // otherwise only inside `region` (later entries win)
  int organ = -1;          // only of this one (Scene::organs); -1: of any
  Region region;
  /// Not null: there is as much of it as an image says, and the rest is the first material (mixtures.h).
  std::shared_ptr<const Membership> membership;
  SourceLocation place;
};

/// Nodes whose displacement is imposed: zero, or a translation after a rotation, both in the measure of `curve`.
struct BoundarySpec {
  std::string name;  // in results; "fixed 1", "prescribed 2" where the scene gives none
  Region region;
  int organ = -1;                          // only of this one (Scene::organs); -1: of any
  bool component[3] = {true, true, true};  // which of x, y, z are imposed
  Vec3 translation = Vec3::Zero();         // m
  Vec3 axis_point = Vec3::Zero();          // m, a point of the axis of rotation
  Vec3 axis = Vec3::UnitZ();               // unit
  double angle = 0;                        // rad, right-handed about axis
  double duration = 0;                     // s; 0 for a fixed region
  LoadCurve curve;
  bool surface_only = false;  // choose surface nodes only
  /// Not null: in place of region and motion, points that go where they were measured (point_boundaries.h).
  std::shared_ptr<const PointLoad> points;
  SourceLocation place;
};

/// A pressure or a traction on the skin, in the measure of `curve`.
struct LoadSpec {
  enum class Kind { FollowerPressure, DeadPressure, Traction };
  std::string name;   // in results; "load 1" where the scene gives none
  bool whole = true;  // all of the skin; else what lies in `region`
  Region region;
  Kind kind = Kind::FollowerPressure;
  double pressure = 0;           // Pa, inwards; FollowerPressure: along the normal and on the area that the skin has
                                 // now, DeadPressure: those at rest
  Vec3 traction = Vec3::Zero();  // Pa, of the area at rest
  double duration = 0;           // s
  LoadCurve curve;
  SourceLocation place;

  /// Time from which on it stays as it is, s.
  double end() const { return curve.time.empty() ? duration : std::max(duration, curve.time.back()); }
};

/// Quadrature of the background cells, paper section 2.5.
struct QuadratureSpec {
  int points_per_cell = 1;     // 1, 4 or 5
  double cells_per_point = 1;  // 1 .. 2: so many cells share a point, in pairs (cell_pairs.h)
  double accuracy = 0;         // tau of the adaptive quadrature; 0: not adaptive
  int division = 8;            // a cell that fails is divided into 2, 4 or 8
  int max_depth = 4;           // divisions of a cell after one another
};

/// A rigid body that the organ's skin can't enter: a region, or one side of a surface that is closed but for openings.
struct RigidSpec {
  std::string name;                                // in results
  Region region;                                   // a half-space, box, sphere or cylinder
  std::shared_ptr<const TriangleSurface> surface;  // closed, m; not null: in place of the region
  bool of_organ = false;                           // the surface is the organ's own at rest
  bool encloses = false;                           // the organ lies inside the surface, and tools pass it
  double clearance = 0;                            // m, from the surface to what the skin touches
  std::vector<Region> open;                        // where there is no surface
  double friction = 0;                             // Coulomb
  BoundaryMotion motion;
  SourceLocation place;
};

/// What `mtled solve` does with the scene.
struct SolveSpec {
  enum class Mode { Static, Transient };
  Mode mode = Mode::Static;  // Static: dynamic relaxation (paper section 2.3); the time of load curves is then
                             // a measure of the load only
  double tolerance = 1e-4;   // Static: estimated error of the displacements, as a share of the largest
  int load_steps = 10;       // Static: equilibria on the way, written to force.csv
  double end_time = 0;       // s; 0: the longest duration of the prescribed motions
  int frames = 10;           // results written for ParaView
  std::string probes_file;   // CSV with columns X,Y,Z (m); "" for none
  SourceLocation place;
};

/// A finer spacing inside a sphere, blending linearly to the global one over `blend`.
struct RefineSpec {
  Vec3 centre = Vec3::Zero();  // m
  double radius = 0;           // m
  double spacing = 0;          // m
  double blend = 0;            // m; 0: chosen as three times the difference of the spacings
  SourceLocation place;
};

/// A tool, as the scene says it.
struct ToolSpec {
  ToolShape shape;
  Vec3 position = Vec3(0, 0, 0.1);  // m, tip
  Vec3 direction = -Vec3::UnitZ();  // unit, the way the tip points
  double max_speed = 1;             // m/s; a faster command is followed at this speed
  double max_force = 0;             // N; 0: from the tissue (maxToolForce)
  double grip_force = 0;            // N, of jaws; 0: from the tissue (gripForce)
  double friction = 0;              // Coulomb coefficient
  double opening = -1;              // m, jaws: the gap at the start between two fingers of that shape; < 0: no jaws
  std::string script;  // file of a tool script that it follows where no hand leads it (without one the first tool is
                       // pressed in, others stay); "": none
  SourceLocation place;

  bool jaws() const { return opening >= 0; }
};

/// What lumps at random were drawn from ([lumps]): whoever knows it knows where they lie.
struct LumpDraw {
  int level = 1;
  unsigned seed = 1;
  int layout = 1;  // the first, second ... of the seed
};

/// An organ, as the scene says it: a closed surface from a file, or an analytic solid.
struct OrganSpec {
  enum class Solid { Surface, Box, Cylinder, Ellipsoid };
  std::string name;  // "organ 1" where the scene gives none
  SourceLocation place;
  Solid solid = Solid::Surface;
  std::string surface_file;       // absolute or relative to the working directory; see surfaceFormats()
  double surface_scale = 1.0;     // m per file unit
  bool repair_surface = false;    // the file's surface is repaired (repairSurface) instead of refused
  Vec3 size = Vec3::Zero();       // Box: edge lengths, m; base centred at the origin, z from 0
  double radius = 0, height = 0;  // Cylinder: m; axis z, base centred at the origin
  Vec3 semi_axes = Vec3::Zero();  // Ellipsoid: m, centred at the origin
  bool upper_half = false;        // Ellipsoid: only z >= 0
  // Where it lies: turned about an axis through the origin, then moved.
  Vec3 axis = Vec3::UnitZ();             // unit
  double angle = 0;                      // rad, right-handed
  Vec3 position = Vec3::Zero();          // m
  double friction = 0;                   // Coulomb coefficient at other organs; of two the larger counts
  Vec3 colour = Vec3(0.62, 0.21, 0.17);  // linear-light albedo, 0..1
};

/// How the organs are cut into nodes and integration points.
struct DiscretizationSpec {
  double spacing = 0.01;  // m, target distance of neighbouring nodes
  bool follow = false;    // the cloud follows the tool (place.h): spacing is then what it has far from it,
  double at_tools = 0;    // m, and this what it has near the tools; 0: by their size
  unsigned seed = 1;
  QuadratureSpec quadrature;
  int basis_degree = 2;         // 1 or 2
  double support_factor = 1.8;  // R / h, h the local mean edge length
  double mmls_weight = 0.2;     // dimensionless weight of the MMLS constraints
  Formulation formulation;
  enum class BoundaryMethod { Sebciem, Ebciem };
  BoundaryMethod boundary_method = BoundaryMethod::Sebciem;  // paper eqs. 18-20 or 14-17
  std::vector<RefineSpec> refine;
};

/// How they move in real time.
struct DynamicsSpec {
  double rate_hz = 500;         // 100 .. 2000; one tick is 1/rate
  int catch_up = 16;            // late ticks that the loop makes good
  double time_step = 0;         // s; 0: the largest whole division of a tick below safety * critical
  double step_safety = 0.6;     // of the critical step
  double mass_scaling = 0;      // share of the body's mass that may be added to spare steps of a tick
  double damping = 20;          // 1/s, mass-proportional: M u'' + c M u'
  Vec3 gravity = Vec3::Zero();  // m/s^2, of the tissue; it bears its weight from the start
  int threads = 1;              // physics threads
  GradientPrecision gradient_precision = GradientPrecision::Float32;  // of the real-time kernel
};

/// How the force is smoothed for display and devices.
struct ForceSpec {
  double cutoff_hz = 30;  // first-order low-pass
  double rate_limit = 0;  // N/s; 0: none
};

/// The first view.
struct CameraSpec {
  Vec3 target = Vec3::Zero();  // m
  double distance = 0.5;       // m
  double azimuth_deg = -60;    // around +z, from +x
  double elevation_deg = 25;
  double fov_deg = 35;  // vertical
};

/// Everything a scene file says, validated as far as that needs no geometry.
/// Plain data; `io/scene_file.h` reads it, `setup/build_model.h` turns it into a Model.
struct Scene {
  std::string name;
  SourceLocation place;                          // the file itself
  std::vector<std::string> files;                // that it names: surfaces, images, points, scripts
  std::map<std::string, SourceLocation> places;  // where a key stands ("dynamics.time_step"), for errors
  /// The values that the reader accepted of all keys that a Preparation depends on (KeySpec::SetUp), one a line: what a
  /// cache goes by. Empty: made or changed by a program, and then nothing is kept.
  std::string set_up_values;

  std::vector<OrganSpec> organs = std::vector<OrganSpec>(1);  // at least one, at most max_organs
  DiscretizationSpec discretization;
  std::vector<MaterialSpec> materials;   // at least one, the first applies everywhere
  std::optional<LumpDraw> lump_draw;     // of the later ones that are lumps at random
  std::vector<BoundarySpec> boundaries;  // at least one, or a rigid body
  std::vector<RigidSpec> rigid;
  std::vector<LoadSpec> loads;
  DynamicsSpec dynamics;
  SolveSpec solve;
  std::vector<ToolSpec> tools = std::vector<ToolSpec>(1);  // at least one, at most max_tools
  ForceSpec force;
  DeviceSettings device;
  CameraSpec camera;
};

/// Time from which on no boundary and no rigid body moves and no load changes, s; 0: they never do.
double motionEnd(const Scene& scene);

/// The radius that the skin is made for, m, and the top speed that the time step is, m/s: of all tools, and of what is
/// round or moves of the rigid bodies, the smallest and the largest.
double smallestToolRadius(const Scene& scene);
double largestToolSpeed(const Scene& scene);

}  // namespace palpate
