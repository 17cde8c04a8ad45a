#pragma once

#include <string>

namespace palpate::tools {

struct FollowOptions {
  std::string scene;   // file, or the name of one in assets/scenes
  std::string json;    // file for all numbers; "": none
  int ways = 1;        // drags, at as many places of the organ
  bool quick = false;  // the scene as it is and the following cloud only, a coarser reference, no second one
};

/// Judges a cloud that follows the tool (simulation/place.h): drags the first tool half a radius deep over the organ,
/// on one thread, on the scene as it is, on uniform clouds and on a following one, each beside a reference that is fine
/// along the whole way. Prints nodes, processor time of a tick, error of the force, and what the swaps did to it.
/// @return 0 done, 1 interrupted or a run was lost
/// Throws InputError for unusable input, std::runtime_error where a file can't be written.
int followCommand(const FollowOptions& options);

}  // namespace palpate::tools
