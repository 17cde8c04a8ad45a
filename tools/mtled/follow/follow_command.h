#pragma once

#include <string>
#include <vector>

namespace palpate::tools {

struct FollowOptions {
  std::vector<std::string> scenes;  // files, or names of those in assets/scenes
  std::string report;               // folder for a page and all numbers; "": none
  int ways = 1;                     // drags, at as many places of the organ
  double nu = 0;                    // Poisson's ratio of all materials; 0: the scene's
  bool quick = false;               // a uniform cloud and the following one only, a coarser reference, no second one
};

/// Judges a cloud that follows the tool (setup/place.h): drags the first tool half a radius deep over the organ,
/// on one thread, on uniform clouds and on a following one, each beside a reference that is fine
/// along the whole way. Prints nodes, processor time of a tick, error of the force, and what the swaps did to it.
/// @return 0 done, 1 interrupted or a run was lost
/// Throws InputError for unusable input, std::runtime_error where a file can't be written.
int followCommand(const FollowOptions& options);

}  // namespace palpate::tools
