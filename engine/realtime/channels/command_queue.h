#pragma once

#include <cstdint>

#include "base/types.h"
#include "mechanics/materials/material.h"
#include "model/place_index.h"
#include "realtime/channels/spsc_ring.h"

namespace palpate {

/// One thing that a viewer, script or recording asks of the loop. Fixed size; build
/// it with the functions below.
struct Request {
  enum class Kind : std::uint8_t {
    MoveTool,      // pose: where the tool should go; value: s that it takes there, evenly
    ThenMoveTool,  // the same, once it has come where it was sent before
    Steer,  // pose.position: m/s, point: rad/s, both in the world, the turn about the tip; value: s that this holds
    Pull,   // index, point: spring from a skin vertex to a world position, m
    ReleasePull,
    Pause,
    Resume,
    SingleStep,   // one tick, while paused
    Reset,        // back to the freshly loaded state; leaves a freeze
    Restart,      // the same, where a script or replay begins again with it: the tool then need not come gently
    Undo,         // half a second to a second back; leaves a freeze; not while a script or replay lasts
    SetFriction,  // index: tool; value: Coulomb coefficient
    SetMaterial,  // index: into Model::materials; material
    SetGravity,   // point: m/s^2, of the tissue
    SetForce,     // index: skin vertex, -1: all; point: N, 0 ends it
    Pin,          // index: skin vertex; point: m, where it is held
    Unpin,        // index: skin vertex, -1: all
    MoveRegion,   // index: boundary, -1: all; point: m, beside the scene's own motion
    Quit,
    MoveHand,    // index: tool, from 1; pose: where it should go, at once
    SetOpening,  // index: tool, from 0; value: m, the gap between the fingers of its jaws
    Mark,        // a place that is said to be hard: point: m; index: how hard, 1 .. 3
    Unmark,      // the last of these is taken back
    Submit,      // they are all
    GoToPlace,   // place: that a cloud which follows the tool went to here; of recordings
  };
  Kind kind = Kind::Pause;
  // Pull, SetForce, Pin, Unpin: skin vertex; MoveRegion: boundary; SetMaterial: material; MoveHand, SetOpening: tool;
  // Mark: how hard
  int index = -1;
  double value = 0;             // SetFriction; seconds of the tool's motions; SetOpening, m
  Vec3 point = Vec3::Zero();    // Pull, Pin, MoveRegion, Mark, m; SetGravity, SetForce
  Pose pose;                    // MoveTool
  Material material;            // SetMaterial
  PlaceIndex place = no_place;  // GoToPlace

  // What programs may ask for, and recordings hold.
  static constexpr double farthest = 1e6;       // m or N, of a component: beyond, steps are lost to rounding
  static constexpr double most_gravity = 1000;  // m/s^2, of a component: a hundred times the earth's
  static constexpr double most_friction = 2;    // as scenes

  /// What is said while the tool moves: recorded at its tick, and nothing that the tissue feels.
  bool isSaid() const { return kind == Kind::Mark || kind == Kind::Unmark || kind == Kind::Submit; }

  /// @param seconds  for the way, which is gone evenly; 0: as fast as the hand is followed (ToolTrack)
  static Request moveTool(const Pose& pose, double seconds = 0);
  static Request thenMoveTool(const Pose& pose, double seconds);
  /// Moves the tool evenly from tick to tick, however seldom the viewer draws.
  /// @param velocity  m/s; @param turn  rad/s; @param seconds  after which it stands, unless it is asked again
  static Request steer(const Vec3& velocity, const Vec3& turn, double seconds);
  static Request pull(int skin_vertex, const Vec3& target);
  static Request setFriction(double coefficient, int tool = 0);
  /// Refused by the loop (with a log event) where the material is stiffer than the
  /// time step allows.
  static Request setMaterial(int index, const Material& material);
  static Request setGravity(const Vec3& acceleration);
  static Request setForce(int skin_vertex, const Vec3& force);
  static Request pin(int skin_vertex, const Vec3& place);
  static Request unpin(int skin_vertex);
  static Request moveRegion(int boundary, const Vec3& shift);
  static Request moveHand(int tool, const Pose& pose);
  static Request setOpening(int tool, double opening);
  static Request mark(const Vec3& place, int hardness);
  static Request goToPlace(const PlaceIndex& place);
  static Request simple(Kind kind);  // those without parameters
};

/// Requests, viewer to loop. The viewer thread pushes; at each tick (also while paused or
/// frozen) the loop thread pops as many as were waiting when the tick began, at most the
/// capacity. push() is false when full: the loop has not run for a long time; a lost
/// MoveTool does no harm, others are sent again.
using CommandQueue = SpscRing<Request>;

/// A request at a tick of the run: what recordings are made of and scripts feed in.
/// It takes effect before the tick with that number (0: the first).
struct TimedRequest {
  std::int64_t tick = 0;
  Request request;
};

}  // namespace palpate
