// What nearly every test includes, read by the compiler once. Files still include what they use.
#include <catch2/catch.hpp>

#include "base/precompiled.h"
