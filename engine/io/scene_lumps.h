#pragma once

#include "io/toml_table.h"
#include "scene/scene.h"

namespace palpate {

/// What `[lumps]` draws from, easiest first: radius, depth of the top below the skin (m), Young's modulus (Pa).
struct LumpLevel {
  double least_radius, most_radius, least_top, most_top, least_young, most_young;
};
const LumpLevel& lumpLevel(int level);  // 1 .. 3

/// Adds a stiffer ball of tissue and a finer spacing around it, as [[material]] and [[discretization.refine]] would.
/// The law is the first material's, its stress multiplied so that Young's modulus at small strain is `young`.
void addLump(const Vec3& centre, double radius, double young, const SourceLocation& place, Scene& scene);

/// Reads [[lump]] and [lumps]; the latter's are placed at random below the organ's skin, by their seed and layout (the
/// next ones of the same stream): where the tool gets to, apart from each other and from what is held. Organ,
/// discretization, materials, boundaries and tool must have been read. Throws InputError where a lump is no stiffer
/// than the tissue, or where they do not fit.
void readLumps(const TomlTable& top, Scene& scene);

}  // namespace palpate
