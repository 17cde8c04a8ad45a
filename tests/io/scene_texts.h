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

inline const std::string minimal_scene =
    "[organ]\nsolid = \"box\"\nsize = [0.1, 0.1, 0.05]\n"
    "[discretization]\nspacing = 0.01\n"
    "[[material]]\nmodel = \"neo-hookean\"\nyoung = 3000\npoisson = 0.49\n"
    "[[fixed]]\nshape = \"half-space\"\npoint = [0, 0, 0.001]\nnormal = [0, 0, 1]\n";

}  // namespace palpate
