#include "io/scene_keys.h"

#include <algorithm>
#include <cctype>
#include <deque>
#include <string_view>
#include <utility>
#include <vector>

#include "contact/tool.h"
#include "mechanics/materials/material_law.h"

namespace palpate {

namespace {

using T = KeySpec::Type;
constexpr const char* required = KeySpec::required;
constexpr const char* depends = KeySpec::depends;
constexpr auto never = KeySpec::SetUp::Never, with_mass_scaling = KeySpec::SetUp::WithMassScaling;

// clang-format off
// All but those of the material laws and of the tools.
constexpr KeySpec scene_keys[] = {
    {"", "name", T::Text, "", "", {}, "",
     "Shown in the window's title and in reports; the file's name where absent.", never},
    {"", "organ", T::Table, "", required, {}, "",
     "What is touched; `[[organ]]`: several, which touch one another as they touch tools."},
    {"", "discretization", T::Table, "", "", {}, "", "How it is cut into nodes and integration points."},
    {"", "material", T::Tables, "", required, {}, "", "What it is made of."},
    {"", "fixed", T::Tables, "", depends, {}, "",
     "Where it is held. Required, but where `[[prescribed]]` regions leave the organ no motion as a whole, or where "
     "there is a `[[rigid]]` body (or `[skull]`) for it to lie on."},
    {"", "prescribed", T::Tables, "", "", {}, "", "Where it is moved."},
    {"", "rigid", T::Tables, "", "", {}, "", "What it lies on, or what presses it: up to eight bodies.", never},
    {"", "load", T::Tables, "", "", {}, "", "What presses or pulls on its skin.", never},
    {"", "skull", T::Table, "", "", {}, "", "What encloses it.", never},
    {"", "dynamics", T::Table, "", "", {}, "", "Loop rate, time step, damping."},
    {"", "solve", T::Table, "", "", {}, "", "How far and how finely `mtled solve` computes."},
    {"", "tool", T::Table, "", "", {}, "", "What touches it; `[[tool]]`: up to four."},
    {"", "force", T::Table, "", "", {}, "", "How the force is smoothed for display and devices."},
    {"", "device", T::Table, "", "", {}, "", "How a haptic device is coupled to the tool."},
    {"", "camera", T::Table, "", "", {}, "", "The first view."},
    {"", "lump", T::Tables, "", "", {}, "", "Stiff balls to be found by touch."},
    {"", "lumps", T::Table, "", "", {}, "", "The same, at random places."},

    {"organ", "name", T::Text, "", "", {}, "",
     "By which materials and regions say whose they are; `organ 1`, `organ 2`, ... where absent.", never},
    {"organ", "position", T::Vector, "m", "[0, 0, 0]", {}, "", "Where its own origin lies."},
    {"organ", "friction", T::Number, "", "0", between(0, 2), "",
     "Coulomb coefficient where it touches other organs; of two the larger counts.", never},
    {"organ", "axis", T::Vector, "", depends, {}, "",
     "Axis through its own origin about which it is turned before it is moved; with `angle`."},
    {"organ", "angle", T::Number, "degrees", depends, between(-360, 360), "",
     "By how much, right-handed about `axis`."},
    {"organ", "surface", T::Text, "", depends, {}, "",
     "File of a closed surface (.obj, .stl, .ply, .off, .vtk), relative to the scene file. Either this or `solid`.",
     never},
    {"organ", "unit", T::Text, "", depends, {}, "mm|cm|m",
     "Unit of the file's coordinates; with `surface` give this or `scale`. An organ shorter than 1 mm or "
     "longer than 3 m is warned of."},
    {"organ", "scale", T::Number, "m", depends, above(0), "",
     "Length of the file's unit; with `surface` give this or `unit`."},
    {"organ", "repair", T::Boolean, "", "false", {}, "",
     "Repair the surface as `mtled import` does, each time that it is read: holes, doubled and turned faces, faces "
     "that pierce others, sheets inside. `mtled import FILE` does it once, and says what it found."},
    {"organ", "solid", T::Text, "", depends, {}, "box|cylinder|ellipsoid",
     "An analytic solid. Either this or `surface`."},
    {"organ", "size", T::Vector, "m", depends, aboveUpTo(0, 10), "",
     "Box: edge lengths. Its base is centred at the origin, z goes from 0 up."},
    {"organ", "radius", T::Number, "m", depends, aboveUpTo(0, 10), "",
     "Cylinder: its axis is z, its base is centred at the origin."},
    {"organ", "height", T::Number, "m", depends, aboveUpTo(0, 10), "", "Cylinder: z goes from 0 to here."},
    {"organ", "semi_axes", T::Vector, "m", depends, aboveUpTo(0, 10), "",
     "Ellipsoid: along x, y, z; centred at the origin."},
    {"organ", "upper_half", T::Boolean, "", "false", {}, "", "Ellipsoid: only the part z >= 0, with a flat base."},
    {"organ", "colour", T::Vector, "", "[0.62, 0.21, 0.17]", between(0, 1), "",
     "Red, green, blue of the tissue, as linear-light albedo.", never},

    {"discretization", "spacing", T::Number, "m", depends, aboveUpTo(0, 1), "",
     "Distance wanted between neighbouring nodes. Halving it makes eight times the nodes and half the time "
     "step. Without it the cloud follows the tool (`follow`); with it, if it is to follow all the same, nodes are so "
     "far apart near the tool, and elsewhere as much wider or closer than by its radius."},
    {"discretization", "follow", T::Boolean, "", depends, {}, "",
     "The cloud follows the tool: nodes are dense in a ball around each tool and wide apart elsewhere, both by the "
     "tool's radius or by `spacing`, and change while it moves; tissue in a ball that is thinner than two of its "
     "spacings has nodes up to twice as dense. So it is where no `spacing` is given. Solutions (`mtled solve`) and "
     "fits of material have the cloud for where the tool ends."},
    {"discretization", "seed", T::Integer, "", "1", between(0, 4294967295.0), "",
     "Another seed, another irregular node cloud; the same seed, the same bits."},
    {"discretization", "points_per_cell", T::Integer, "", "1", {}, "1|4|5",
     "Integration points per background cell, or per part of a cell that the adaptive quadrature divides. 1, "
     "4 and 5 integrate linear, quadratic and cubic polynomials exactly; 5 has a negative weight and is "
     "mostly worse than 4."},
    {"discretization", "cells_per_point", T::Number, "", "1", between(1, 2), "",
     "Above 1 neighbouring cells share an integration point in pairs, until there are so many cells to a "
     "point, or (at about 1.8) none is left to pair: 1.3 has three quarters of the points and of the time a "
     "step. Where the cloud follows the tool, and nothing is said, 1.6. Neither with more than one point per "
     "cell nor with `quadrature_accuracy`."},
    {"discretization", "quadrature_accuracy", T::Number, "", "0", between(0, 1), "",
     "Tolerance tau of the adaptive quadrature (paper section 2.5): a cell is divided while the integral over "
     "it of the least smooth integrand (eq. 30) differs by more than this share from the sum over its parts. "
     "0: not adaptive. 0.1 is coarse, 0.01 fine."},
    {"discretization", "quadrature_division", T::Integer, "", "8", {}, "2|4|8",
     "Into how many parts the adaptive quadrature divides a cell."},
    {"discretization", "quadrature_depth", T::Integer, "", "4", between(0, 8), "",
     "How often the adaptive quadrature may divide a cell and its parts."},
    {"discretization", "basis", T::Text, "", "\"quadratic\"", {}, "linear|quadratic",
     "Polynomial basis of the shape functions (paper eqs. 1-7)."},
    {"discretization", "support_factor", T::Number, "", "1.8", between(1.4, 4), "",
     "Support radius over local node spacing."},
    {"discretization", "mu", T::Number, "", "0.2", above(0), "",
     "Weight of the constraints on second-degree coefficients (paper eq. 4), dimensionless: the basis is "
     "scaled by the support radius."},
    {"discretization", "scheme", T::Text, "", "\"standard\"", {}, "standard|paper",
     "How forces follow from displacements. `standard`: what is known to be right, for every scene; what a scene does "
     "not need costs it nothing. Gradients satisfy the divergence theorem; volume is averaged over node patches, "
     "against locking; under pressure the background cells hold it; supports end at the borders between materials; a "
     "floor keeps points from collapsing. `paper`: the paper's own equations alone, to be compared with."},
    {"discretization", "boundary_method", T::Text, "", "\"sebciem\"", {}, "sebciem|ebciem",
     "How the forces act that impose displacements: lumped at the nodes (paper eqs. 18-20), or distributed "
     "over the boundary's faces (paper eqs. 14-17), which is more accurate with a `support_factor` above 2. "
     "Both are exact at the nodes."},
    {"discretization", "refine", T::Tables, "", "", {}, "", "Spheres of finer spacing."},

    {"discretization.refine", "centre", T::Vector, "m", required, {}, "", "Centre of the sphere."},
    {"discretization.refine", "radius", T::Number, "m", required, above(0), "", "Its radius."},
    {"discretization.refine", "spacing", T::Number, "m", required, above(0), "",
     "Spacing inside; smaller than the global one."},
    {"discretization.refine", "blend", T::Number, "m", "0", atLeast(0), "",
     "Width over which the spacing grows back to the global one; 0: three times the difference of the two."},

    {"material", "name", T::Text, "", "", {}, "", "Its name in the window, e.g. \"capsule\".", never},
    {"material", "region", T::Table, "", depends, {}, "",
     "Where this material is (a [region](#region)). The first material is everywhere and has none; each later "
     "one needs one, or `organ`, or both, and replaces what was there."},
    {"material", "organ", T::Text, "", "", {}, "", "The name of the organ that it is of; absent: of any."},

    {"material", "membership", T::Text, "", depends, {}, "",
     "In place of a region: NIfTI file (.nii, .nii.gz), relative to the scene file, of how much of each voxel is this "
     "material, 0 to 1; the rest is the first material. Shear and bulk modulus of each integration point are the "
     "geometric mean of both by the mean share in its cell (in the paper's scheme, and densities, the arithmetic one): "
     "too stiff or too soft where the image's borders run through cells, which the error to expect has. World "
     "coordinates of the image in mm are the organ's in m times 1000; it holds nine tenths of the organ or more. Both "
     "materials are neo-Hookean; one material of a scene may have it.", never},
    {"material", "mask", T::Text, "", "", {}, "",
     "With `membership`: NIfTI file on the same voxels; those where it is not above 0.5 are left out of the mean.",
     never},

    {"region", "shape", T::Text, "", required, {}, "half-space|box|sphere|near-plane|cylinder|shell", "Its shape."},
    {"region", "point", T::Vector, "m", depends, {}, "",
     "Half-space, near-plane: a point of the plane. Cylinder: the middle of its base."},
    {"region", "normal", T::Vector, "", depends, {}, "",
     "Half-space: points out of it, inside is the other side. Near-plane: the plane's normal. Cylinder: its "
     "axis, from the base to the top. Any length."},
    {"region", "min", T::Vector, "m", depends, {}, "", "Box: lower corner."},
    {"region", "max", T::Vector, "m", depends, {}, "", "Box: upper corner."},
    {"region", "centre", T::Vector, "m", depends, {}, "", "Sphere: its centre."},
    {"region", "radius", T::Number, "m", depends, above(0), "", "Sphere, cylinder: its radius."},
    {"region", "height", T::Number, "m", depends, above(0), "", "Cylinder: from its base to its top."},
    {"region", "distance", T::Number, "m", depends, atLeast(0), "",
     "Near-plane: points up to this far from the plane, on both sides. Shell: points of the organ up to this "
     "far from its surface."},

    {"boundary", "name", T::Text, "", "", {}, "",
     "Its name in results, unlike all others. Where absent `fixed 1`, `fixed 2`, ... and `prescribed 1`, ..., "
     "by its place among those of its kind.", never},
    {"boundary", "organ", T::Text, "", "", {}, "", "The name of the organ that it is of; absent: of any."},
    {"boundary", "components", T::Axes, "", "[\"x\", \"y\", \"z\"]", {}, "",
     "The directions of displacement that are imposed; the others stay free."},
    {"boundary", "surface_only", T::Boolean, "", "false", {}, "", "Choose only nodes on the organ's surface."},

    {"prescribed", "points", T::Text, "", "", {}, "",
     "In place of a region and a motion: measured points that go where they were measured, each imposed exactly at its "
     "place on the surface. A CSV file, relative to the scene file, with the columns x, y, z and, where it was "
     "measured, x0, y0, z0: where each is, and was before (else the nearest point of the surface); or a file of 3D "
     "Slicer (.fcsv, .mrk.json). Points nearer to each other than half the spacing are joined; more than 40 mm from "
     "the surface are refused.", never},
    {"prescribed", "unit", T::Text, "", depends, {}, "mm|cm|m", "Of the points' coordinates. Slicer's files say it.",
     never},
    {"prescribed", "frame", T::Text, "", depends, {}, "ras|lps",
     "Of the points' coordinates: +x, +y, +z to the patient's right, front and top (as the organ's, where it comes "
     "from a scan), or left, back and top. Slicer's files say it.", never},
    {"prescribed", "spread", T::Text, "", "\"points\"", {}, "points|sheet",
     "What the skin between measured points does: it is free, or moves as a smooth sheet (a thin plate through the "
     "points, which stay exact) out to half their distance beyond the outermost.", never},
    {"prescribed", "translation", T::Vector, "m", depends, {}, "",
     "Where the region's nodes go. This, a rotation or both; with both the nodes are rotated first."},
    {"prescribed", "axis_point", T::Vector, "m", depends, {}, "", "Rotation: a point of its axis."},
    {"prescribed", "axis", T::Vector, "", depends, {}, "", "Rotation: the direction of its axis. Any length."},
    {"prescribed", "angle", T::Number, "degrees", depends, between(-3600, 3600), "",
     "Rotation: how far, counter-clockwise seen against the axis (right-handed). Each node goes along an arc."},
    {"prescribed", "duration", T::Number, "s", depends, above(0), "",
     "In which time. With `curve_table` it may be left out: the table's last time."},
    {"prescribed", "curve", T::Text, "", "\"smooth\"", {}, "smooth|linear",
     "How: along 10 t^3 - 15 t^4 + 6 t^5, which starts and stops gently, or at constant speed."},
    {"prescribed", "curve_table", T::Curve, "s", "", {}, "",
     "Instead of `curve`: rows of time and share of the whole motion, like `[[0.0, 0.0], [0.5, 1.0], [1.0, "
     "0.25]]`; straight in between, constant after the last. Times ascend from 0, the first share is 0."},

    {"rigid", "name", T::Text, "", "", {}, "",
     "Its name in results, unlike all others. Where absent `rigid 1`, `rigid 2`, ...", never},
    {"rigid", "region", T::Table, "", depends, {}, "",
     "The solid that the skin can't enter: a [region](#region) that is a half-space, box, sphere or cylinder. Either "
     "this or `surface`."},
    {"rigid", "surface", T::Text, "", depends, {}, "",
     "File of a closed surface (.obj, .stl, .ply, .off, .vtk), relative to the scene file.", never},
    {"rigid", "unit", T::Text, "", depends, {}, "mm|cm|m", "Unit of the file's coordinates.", never},
    {"rigid", "side", T::Text, "", "\"outside\"", {}, "outside|inside",
     "Where the organ is: outside of the surface, or enclosed in it, as in a skull, which tools pass.", never},
    {"rigid", "clearance", T::Number, "m", "0", between(0, 0.05), "",
     "Between the surface and what the skin touches: room inside, a thicker body outside.", never},
    {"rigid", "open", T::Tables, "", "", {}, "",
     "[Regions](#region) without surface: `open = [{ shape = \"sphere\", ... }]`.", never},
    {"rigid", "friction", T::Number, "", "0", between(0, 10), "",
     "Coulomb coefficient between body and skin; 0: frictionless.", never},
    {"rigid", "translation", T::Vector, "m", depends, {}, "",
     "Where it goes, with what is on it. As the keys below as in [`[[prescribed]]`](#prescribed); none of them: it "
     "stands still.", never},
    {"rigid", "axis_point", T::Vector, "m", depends, {}, "", "Rotation: a point of its axis.", never},
    {"rigid", "axis", T::Vector, "", depends, {}, "", "Rotation: the direction of its axis. Any length.", never},
    {"rigid", "angle", T::Number, "degrees", depends, between(-3600, 3600), "", "Rotation: how far, right-handed.",
     never},
    {"rigid", "duration", T::Number, "s", depends, above(0), "", "In which time.", never},
    {"rigid", "curve", T::Text, "", "\"smooth\"", {}, "smooth|linear", "How: gently, or at constant speed.", never},
    {"rigid", "curve_table", T::Curve, "s", "", {}, "", "Instead of `curve`: rows of time and share of the motion.",
     never},
    {"load", "name", T::Text, "", "", {}, "",
     "Its name in results, unlike all others. Where absent `load 1`, `load 2`, ...", never},
    {"load", "region", T::Table, "", "", {}, "",
     "Where it is: the part of the skin that lies in a [region](#region), whose border cuts faces. To choose a flat "
     "side alone take a near-plane with `distance = 1e-6`. Absent: all of the skin.", never},
    {"load", "pressure", T::Number, "Pa", depends, {}, "",
     "Inwards; negative: suction. Either this or `traction`.", never},
    {"load", "kind", T::Text, "", "\"follower\"", {}, "follower|dead",
     "Of a pressure: along the normal and on the area that the skin has now, as gas and fluids press; or those "
     "at rest (such a push, as that of a traction, lets soft tissue give way aside from about its shear modulus on).",
     never},
    {"load", "traction", T::Vector, "Pa", depends, {}, "",
     "Force per area of the skin at rest, in a fixed direction.", never},
    {"load", "duration", T::Number, "s", depends, above(0), "",
     "In which time it comes. With `curve_table` it may be left out: the table's last time.", never},
    {"load", "curve", T::Text, "", "\"smooth\"", {}, "smooth|linear",
     "How: along 10 t^3 - 15 t^4 + 6 t^5, or evenly.", never},
    {"load", "curve_table", T::Curve, "s", "", {}, "",
     "Instead of `curve`: rows of time and share of the whole load, as those of `[[prescribed]]`.", never},

    {"skull", "from", T::Text, "", required, {}, "",
     "`\"organ\"`: the organ's own surface at rest; or the file of a closed surface that encloses it (.obj, .stl, "
     ".ply, .off, .vtk), relative to the scene file.", never},
    {"skull", "unit", T::Text, "", depends, {}, "mm|cm|m", "Unit of the file's coordinates.", never},
    {"skull", "clearance", T::Number, "m", "0", between(0, 0.05), "",
     "Between that surface and the shell outside it that the skin touches.", never},
    {"skull", "open", T::Tables, "", "", {}, "",
     "[Regions](#region) without shell: where a skull is opened, `open = [{ shape = \"sphere\", ... }]`.", never},

    {"dynamics", "rate", T::Number, "Hz", "500", between(100, 2000), "",
     "Rate of the real-time loop; one tick is 1/rate.", with_mass_scaling},
    {"dynamics", "catch_up", T::Integer, "", "16", between(0, 100), "",
     "After a stall (the computer did something else) the loop makes so many late ticks good, one at once after "
     "the other, and simulated time is real time again; it skips those beyond, and all where the computer is too "
     "slow for the rate. 0: skips all. The result of a recorded run does not depend on it.", never},
    {"dynamics", "time_step", T::Number, "s", "0", atLeast(0), "",
     "Fixed time step, a whole division of a tick; refused above the critical one. 0: the largest whole "
     "division below `step_safety` times the critical step in which the tool, at its top speed, goes no "
     "further than 1 mm or half its radius.", with_mass_scaling},
    {"dynamics", "step_safety", T::Number, "", "0.6", aboveUpTo(0, 1), "",
     "Share of the critical step used when `time_step` is 0. Tissue stiffens under compression; where 0.9 of its "
     "stable step is passed, mass is added to it, which slows fast deep presses: 0.2 .. 0.3 spares them that.",
     with_mass_scaling},
    {"dynamics", "mass_scaling", T::Number, "", "0", between(0, 10), "",
     "Share of the body's mass that may be added to the nodes that limit the step, if a tick needs fewer "
     "steps then (or, with `time_step`, if that one becomes stable). Forces at rest stay the same; motion "
     "becomes slower by about half that share. The mass added is reported. Where the cloud follows the tool, and "
     "neither this nor `time_step` is given, 0.05."},
    {"dynamics", "damping", T::Number, "1/s", "20", between(0, 1000), "",
     "Mass-proportional damping c in M u'' + c M u' + f(u) = 0, with the tissue's own mass.", never},
    {"dynamics", "gravity", T::Vector, "m/s^2", "[0.0, 0.0, 0.0]", {}, "",
     "Acceleration that pulls at the tissue: [0.0, 0.0, -9.81] with z up. The shape at rest is that without it.",
     never},
    {"dynamics", "threads", T::Integer, "", "1", between(1, 64), "",
     "Threads that compute the physics; the result does not depend on it. Where nothing is said, palpate's runs in "
     "real time have two on a machine with three cores or more.",
     never},
    {"dynamics", "gradient_precision", T::Text, "", "\"float32\"", {}, "float32|int16",
     "How the real-time loop stores the shape functions' gradients. int16 takes half the memory, which is "
     "faster where the gradients do not fit the processor's caches, and changes forces by about 2e-5; the "
     "strains of rigid motion and uniform deformation stay as exact as with float32. Where the cloud follows the "
     "tool, and nothing is said, int16. `mtled solve` computes in double either way.", never},

    {"solve", "mode", T::Text, "", "\"static\"", {}, "static|transient",
     "Equilibria by dynamic relaxation (paper section 2.3), where the time of the prescribed motions is only "
     "a measure of the load; or the motion in time.", never},
    {"solve", "tolerance", T::Number, "", "0.0001", aboveUpTo(0, 0.1), "",
     "Static: estimated error of the displacements at which relaxation stops, as a share of the largest "
     "displacement.", never},
    {"solve", "load_steps", T::Integer, "", "10", between(1, 10000), "",
     "Static: equilibria on the way to the end, evenly spaced in time.", never},
    {"solve", "end_time", T::Number, "s", "0", atLeast(0), "",
     "Where it ends; 0: with the last of the prescribed motions.", never},
    {"solve", "frames", T::Integer, "", "10", between(1, 10000), "",
     "Results written for ParaView, evenly spaced in time.", never},
    {"solve", "probes", T::Text, "", "", {}, "",
     "CSV file of the points at which displacements are wanted, relative to the scene file: a header with the "
     "columns X, Y, Z (m, at rest); other columns are ignored.", never},

    {"tool", "shape", T::Text, "", required, {}, "", "Which of the tools below.", never},  // choices: allKeys()
    {"tool", "radius", T::Number, "m", required, aboveUpTo(0, 1), "", "Its radius."},
    {"tool", "length", T::Number, "m", "0.06", aboveUpTo(0, 1), "", "From tip to end. A sphere ignores it.",
     never},
    {"tool", "position", T::Vector, "m", required, {}, "", "Where the tip, the tool's foremost point, starts.", never},
    {"tool", "direction", T::Vector, "", "[0.0, 0.0, -1.0]", {}, "",
     "The way the tip points and the tool advances; any length.", never},
    {"tool", "max_speed", T::Number, "m/s", "1", aboveUpTo(0, 10), "",
     "A faster command is followed at this speed. Where nothing is said, no more than 400 radii a second.",
     with_mass_scaling},
    {"tool", "max_force", T::Number, "N", "0", atLeast(0), "",
     "What the hand that holds the tool would push at most. Where the tissue would push harder the tool gives way "
     "within the step: it stays behind the mouse, device or script, and reports say by how much. (`mtled solve` "
     "imposes the tool's way, and says where that takes more.) 0: forty shear moduli of the stiffest material on the "
     "tool's cross-section.", never},
    {"tool", "friction", T::Number, "", "0", between(0, 2), "",
     "Coulomb coefficient between tool and tissue; 0: frictionless.", never},
    {"tool", "opening", T::Number, "m", depends, between(0, 1), "",
     "Makes it jaws: two fingers of this shape side by side, this far apart at the start. `position` is the middle "
     "between their tips, and they close along the tool's x axis (the world's, where it points down). Without "
     "`friction` they hold nothing. Absent: no jaws.", never},
    {"tool", "grip_force", T::Number, "N", "0", atLeast(0), "",
     "What jaws pinch with at most, each finger along the closing axis: there they stop, however much narrower hand or "
     "script wants them. 0: twice the tissue's mean shear modulus on the finger's cross-section.", never},
    {"tool", "input", T::Text, "", "", {}, "",
     "What moves it. `\"hand\"`, or absent: mouse, device or program; where there is none it stands still, but the "
     "first tool is pressed in by off-screen runs. `\"script:FILE\"`: a [tool script](../tools/README.md), relative to "
     "the scene file, until a hand takes the tool over; the first tool follows it in off-screen runs.", never},

    {"force", "cutoff", T::Number, "Hz", "30", aboveUpTo(0, 1000), "",
     "Corner frequency of the first-order low-pass of the filtered force.", never},
    {"force", "rate_limit", T::Number, "N/s", "0", atLeast(0), "",
     "The filtered force, which is the one that is shown, changes no faster than this; 0: as fast as it does. For "
     "programs that hand it to a device without a coupling.", never},

    {"device", "class", T::Text, "", "\"light\"", {}, "light|medium|strong",
     "What the keys without a value are chosen for: devices of 3.3 N that hold 400 N/m, of 8 N and 3,000 N/m, of 12 N "
     "and 5,000 N/m.", never},
    {"device", "stiffness", T::Number, "N/m", depends, between(10, 20000), "",
     "Of the coupling, at most; by `class`. The hand feels it in series with the tissue. A device that answers late "
     "gets what `own_damping` allows.", never},
    {"device", "damping", T::Number, "N s/m", depends, between(0, 50), "", "Of the coupling; by `class`.", never},
    {"device", "max_force", T::Number, "N", depends, aboveUpTo(0, 100), "",
     "The longest force vector that the device is given; by `class`.", never},
    {"device", "rise_time", T::Number, "s", "0.01", between(0.001, 1), "",
     "The quickest time from no force to the largest.", never},
    {"device", "scale", T::Number, "", "1", between(0.01, 100), "",
     "Way of the tool over way of the device. Forces are not scaled, so that tissue feels `scale` times as stiff.",
     never},
    {"device", "own_damping", T::Number, "N s/m", depends, between(0.05, 50), "",
     "Of the device and the lightest hand that will hold it; by `class` 2, 2 and 3. It bounds the coupling's stiffness "
     "K by K (T/2 + delay) <= own_damping (T: time from pose to pose).", never},
    {"device", "orientation", T::Text, "", "\"free\"", {}, "free|locked",
     "`\"free\"`: the tool turns with the handle, on an angular spring whose torque the device is given. "
     "`\"locked\"`: it keeps the orientation that it starts with.",
     never},
    {"device", "lever", T::Number, "m", "0.02", between(0.001, 0.5), "",
     "What turning is measured by: the angular spring is `stiffness` lever^2, its damper `damping` lever^2, the torque "
     "at most `max_force` lever.",
     never},

    {"camera", "target", T::Vector, "m", depends, {}, "",
     "The point in the middle of the view: [0.0, 0.0, 0.0] where only `distance` is given. With neither the first view "
     "shows the whole organ.",
     never},
    {"camera", "distance", T::Number, "m", depends, above(0), "",
     "From there to the eye: 0.5 where only `target` is given.", never},
    {"camera", "azimuth", T::Number, "degrees", "-60", between(-360, 360), "",
     "Direction of the eye around +z, from +x.", never},
    {"camera", "elevation", T::Number, "degrees", "25", between(-90, 90), "",
     "Height of the eye above the horizon.", never},
    {"camera", "fov", T::Number, "degrees", "35", between(5, 120), "", "Vertical field of view.", never},

    {"lump", "centre", T::Vector, "m", required, {}, "", "Its middle, in the organ at rest."},
    {"lump", "radius", T::Number, "m", required, aboveUpTo(0, 0.1), "", "Its radius."},
    {"lump", "young", T::Number, "Pa", required, above(0), "",
     "Young's modulus at small strain, above the tissue's; the law is the first material's."},
    {"lumps", "count", T::Integer, "", required, between(1, 20), "", "How many are placed below the skin."},
    {"lumps", "level", T::Integer, "", "1", {}, "1|2|3",
     "How hard they are to find: 16 to 20 mm large, 3 to 5 mm deep and 40 to 50 kPa; 12 to 16 mm, 3 to 4.5 mm and 40 "
     "to 50 kPa; 10 to 12 mm, 2.5 to 3 mm and 45 to 50 kPa. A scene with a lump that the tool can't feel is refused."},
    {"lumps", "seed", T::Integer, "", "1", between(0, 4294967295.0), "", "Another seed, other places."},
    {"lumps", "layout", T::Integer, "", depends, between(1, 1000), "",
     "Which of the seed's layouts, one after the other. Where it is not given `palpate` takes the first of twelve in "
     "which all lumps can be felt, and says which; other programs take the first."},
};
// clang-format on

/// Keeps a text for as long as the program runs.
const char* kept(std::string text) {
  static std::deque<std::string> texts;
  return texts.emplace_back(std::move(text)).c_str();
}

KeySpec materialKey(const Parameter& parameter, const char* fallback, const std::string& meaning) {
  KeySpec key = keySpec("material", parameter);
  key.fallback = fallback;
  key.meaning = kept(meaning);
  return key;
}

/// The keys that choose and describe a material law: `model`, each law's parameters, those that all laws have.
std::vector<KeySpec> materialKeys() {
  std::string names, titles;
  std::vector<KeySpec> keys(1);  // `model`, below
  for (const MaterialLaw& law : materialLaws()) {
    if (!names.empty()) names += '|', titles += " or ";
    names += law.name;
    titles += law.title;
    if (*law.reference != '\0') titles.append(" (").append(law.reference).append(")");
    std::string title = law.title;
    title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
    for (const Parameter& parameter : law.parameters) {
      std::string meaning = std::string(title).append(": ").append(parameter.text);
      if (!parameter.isRequired()) meaning.append(" `").append(parameter.fallback).append("` where it is not given.");
      const auto same = std::find_if(keys.begin() + 1, keys.end(),
                                     [&](const KeySpec& key) { return std::string_view(key.name) == parameter.name; });
      if (same != keys.end())
        same->meaning = kept(std::string(same->meaning).append(" ").append(meaning));
      else
        keys.push_back(materialKey(parameter, depends, meaning));
    }
  }
  keys[0] = {"material",
             "model",
             T::Text,
             "",
             required,
             {},
             kept(names),
             kept(std::string("Strain energy: ").append(titles).append(", each with bulk energy K/2 (J - 1)^2."))};
  for (const CommonMaterialParameter& common : commonMaterialParameters())
    if (common.is_key) keys.push_back(materialKey(common.parameter, common.parameter.fallback, common.parameter.text));
  keys.push_back(materialKey(relaxationParameter(), "", relaxationParameter().text));
  return keys;
}

/// The keys above, those of the material laws where their table begins, and those of the tools, each tool's in a group
/// of its own.
std::vector<KeySpec> allKeys() {
  static std::string shapes;
  static std::deque<std::string> groups;  // KeySpec points to its texts
  for (const ToolType* tool : toolTypes()) {
    if (!shapes.empty()) shapes += '|';
    shapes += tool->name;
    groups.push_back(toolKeyGroup(*tool));
  }
  std::vector<KeySpec> all(std::begin(scene_keys), std::end(scene_keys));
  const auto material = std::find_if(all.begin(), all.end(),
                                     [](const KeySpec& key) { return std::string_view(key.table) == "material"; });
  const std::vector<KeySpec> added = materialKeys();
  all.insert(material, added.begin(), added.end());
  for (KeySpec& key : all)
    if (std::string_view(key.table) == "tool" && std::string_view(key.name) == "shape") key.choices = shapes.c_str();
  for (std::size_t k = 0; k < toolTypes().size(); ++k)
    for (const Parameter& parameter : toolTypes()[k]->parameters) {
      all.push_back(keySpec(groups[k].c_str(), parameter));
      // The skin is made for radius and tip alone.
      if (std::string_view(parameter.name) != "tip_radius") all.back().set_up = never;
    }
  return all;
}

}  // namespace

std::string toolKeyGroup(const ToolType& tool) { return std::string("tool (") + tool.name + ")"; }

std::span<const KeySpec> sceneKeys() {
  static const std::vector<KeySpec> all = allKeys();
  return all;
}

}  // namespace palpate
