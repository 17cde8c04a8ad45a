#include "realtime/channels/command_queue.h"

namespace palpate {
namespace {

/// A request about one thing and a vector.
Request at(Request::Kind kind, int index, const Vec3& point) {
  Request request = Request::simple(kind);
  request.index = index;
  request.point = point;
  return request;
}

}  // namespace

Request Request::goToPlace(const PlaceIndex& place) {
  Request request = simple(Kind::GoToPlace);
  request.place = place;
  return request;
}

Request Request::simple(Kind kind) {
  Request request;
  request.kind = kind;
  return request;
}

Request Request::moveTool(const Pose& pose, double seconds) {
  Request request = simple(Kind::MoveTool);
  request.pose = pose;
  request.value = seconds;
  return request;
}

Request Request::thenMoveTool(const Pose& pose, double seconds) {
  Request request = moveTool(pose, seconds);
  request.kind = Kind::ThenMoveTool;
  return request;
}

Request Request::steer(const Vec3& velocity, const Vec3& turn, double seconds) {
  Request request = simple(Kind::Steer);
  request.pose.position = velocity;
  request.point = turn;
  request.value = seconds;
  return request;
}

Request Request::pull(int skin_vertex, const Vec3& target) { return at(Kind::Pull, skin_vertex, target); }

Request Request::setFriction(double coefficient, int tool) {
  Request request = simple(Kind::SetFriction);
  request.index = tool;
  request.value = coefficient;
  return request;
}

Request Request::setMaterial(int index, const Material& material) {
  Request request = simple(Kind::SetMaterial);
  request.index = index;
  request.material = material;
  return request;
}

Request Request::setGravity(const Vec3& acceleration) {
  Request request = simple(Kind::SetGravity);
  request.point = acceleration;
  return request;
}

Request Request::setForce(int skin_vertex, const Vec3& force) { return at(Kind::SetForce, skin_vertex, force); }

Request Request::pin(int skin_vertex, const Vec3& place) { return at(Kind::Pin, skin_vertex, place); }

Request Request::unpin(int skin_vertex) { return at(Kind::Unpin, skin_vertex, Vec3::Zero()); }

Request Request::moveRegion(int boundary, const Vec3& shift) { return at(Kind::MoveRegion, boundary, shift); }

Request Request::moveHand(int tool, const Pose& pose) {
  Request request = simple(Kind::MoveHand);
  request.index = tool;
  request.pose = pose;
  return request;
}

Request Request::mark(const Vec3& place, int hardness) { return at(Kind::Mark, hardness, place); }

Request Request::setOpening(int tool, double opening) {
  Request request = simple(Kind::SetOpening);
  request.index = tool;
  request.value = opening;
  return request;
}

}  // namespace palpate
