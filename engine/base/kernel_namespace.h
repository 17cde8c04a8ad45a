#pragma once

// kernel_passes.cpp is compiled once for each instruction set (CMakeLists.txt), the rest of the program for one
// only. An inline function that two of them share would be kept by the linker once, from any of them, and the
// plain kernel might then run AVX-512 instructions. So the inline functions that the kernels use stand in an
// inline namespace named after the instruction set, and call nothing inline outside it, std included.
// The test "kernels share no inline function" looks at the objects.
#ifndef PALPATE_KERNEL
#define PALPATE_KERNEL Host
#endif
