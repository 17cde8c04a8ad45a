#pragma once

#include <string>

namespace palpate::test {

/// The text of a scene: a block of 60 x 60 x 30 mm on a fixed base.
inline const std::string block_text =
    R"(name = "block"
[organ]
solid = "box"
size = [0.06, 0.06, 0.03]
[discretization]
spacing = 0.012
[[material]]
model = "neo-hookean"
young = 3000
poisson = 0.45
[[fixed]]
name = "base"
shape = "near-plane"
point = [0, 0, 0]
normal = [0, 0, 1]
distance = 1e-6
)";

/// The same under a sphere of 10 mm.
inline const std::string touched_block_text = block_text + R"([tool]
shape = "sphere"
radius = 0.01
position = [0, 0, 0.035]
)";

/// The same with a lump that can be felt, which a slow machine computes in time.
inline const std::string lump_block_text = block_text + R"([tool]
shape = "sphere"
radius = 0.008
position = [0, 0, 0.045]
[[lump]]
centre = [0.0, 0, 0.018]
radius = 0.009
young = 30000
[dynamics]
rate = 100
threads = 1
)";

}  // namespace palpate::test
