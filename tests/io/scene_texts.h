#pragma once

#include <string>

namespace palpate {

/// Every key but [solve]. Line numbers in the tests count here.
inline const std::string full_scene =
    R"(name = "Everything"
[organ]
solid = "cylinder"
radius = 0.015
height = 0.017
colour = [0.1, 0.2, 0.3]
[discretization]
spacing = 0.004
seed = 9
points_per_cell = 1
basis = "linear"
support_factor = 2
mu = 0.05
[[discretization.refine]]
centre = [0, 0, 0.017]
radius = 0.003
spacing = 0.001
blend = 0.004
[[material]]
model = "neo-hookean"
young = 1000
poisson = 0.45
[[material]]
model = "ogden"
mu = [600, 43.6]
alpha = [-1.1, 2]
D1 = 1.2598e-4
density = 970
region = { shape = "sphere", centre = [0, 0, 0.01], radius = 0.005 }
[[fixed]]
shape = "near-plane"
point = [0, 0, 0]
normal = [0, 0, 2]
distance = 1e-5
[[prescribed]]
shape = "box"
min = [-0.01, -0.01, 0.016]
max = [0.01, 0.01, 0.018]
components = ["z"]
surface_only = true
translation = [0, 0, -0.002]
duration = 0.5
[dynamics]
rate = 1000
time_step = 0.0005
step_safety = 0.5
damping = 10
threads = 2
[tool]
shape = "cylinder"
radius = 0.005
length = 0.03
edge_radius = 0.0005
position = [0, 0, 0.03]
direction = [0, 3, -4]
max_speed = 0.5
friction = 0.2
[force]
cutoff = 40
rate_limit = 100
[camera]
target = [0, 0, 0.01]
distance = 0.2
azimuth = 30
elevation = 10
fov = 40
)";

/// All keys of solutions without a window. Line numbers in the tests count here.
inline const std::string solved_scene =
    R"([organ]
solid = "cylinder"
radius = 0.015
height = 0.017
[discretization]
spacing = 0.004
points_per_cell = 5
quadrature_accuracy = 0.01
quadrature_division = 2
quadrature_depth = 6
boundary_method = "ebciem"
[[material]]
model = "neo-hookean"
young = 1000
poisson = 0.45
[[material]]
model = "neo-hookean"
young = 5000
poisson = 0.45
region = { shape = "shell", distance = 0.002 }
[[fixed]]
name = "base"
shape = "near-plane"
point = [0, 0, 0]
normal = [0, 0, 1]
distance = 1e-5
[[fixed]]
shape = "shell"
distance = 0
[[prescribed]]
shape = "cylinder"
point = [0, 0, 0.016]
normal = [0, 0, 2]
radius = 0.005
height = 0.002
translation = [0, 0, -0.002]
axis_point = [0.001, 0, 0]
axis = [0, 0, -4]
angle = 90
duration = 0.5
curve = "linear"
[[prescribed]]
name = "ear"
shape = "sphere"
centre = [0, 0, 0.01]
radius = 0.001
axis_point = [0, 0, 0]
axis = [1, 0, 0]
angle = -30
components = ["y", "z"]
curve_table = [[0, 0], [0.1, 1.0],
               [0.4, -0.5]]
[[prescribed]]
shape = "sphere"
centre = [0, 0, 0.012]
radius = 0.001
translation = [0, 0.001, 0]
duration = 2
[solve]
mode = "transient"
end_time = 0.75
frames = 25
probes = "points/probes.csv"
)";

inline const std::string minimal_scene =
    "[organ]\nsolid = \"box\"\nsize = [0.1, 0.1, 0.05]\n"
    "[discretization]\nspacing = 0.01\n"
    "[[material]]\nmodel = \"neo-hookean\"\nyoung = 3000\npoisson = 0.49\n"
    "[[fixed]]\nshape = \"half-space\"\npoint = [0, 0, 0.001]\nnormal = [0, 0, 1]\n";

}  // namespace palpate
